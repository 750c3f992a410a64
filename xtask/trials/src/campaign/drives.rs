//! Runs in which the joints are drives on simulated CAN buses: the session, the board's own joint drivers, the drives, and the arm that they move.
//!
//! ```text
//! host -> frames -> session -> joint-io -> buses -> drives -> arm under gravity, brakes, stops
//!                      ^           ^         |
//!                      |           +-- fault +-> replies          the judge looks at the arm and at the drives
//! ```
//!
//! | module | holds |
//! |---|---|
//! | `stage` | the data that all runs of a scene share |
//! | `bench` | a run in progress; `script_steps`: its part of the campaign's script |
//! | `injection` | one fault of drives, buses or host |
//! | `judge` | the safety of the motion, written from docs/safety.md |
//! | `broken` | boards with deliberate faults |
//!
//! Every tick is the firmware's own [`joint_io::run_tick`]. Each joint has a mechanical stop at both limits. An arm without brakes lies on the stops
//! near its rest pose until it is armed, and falls onto them when torque ends.

mod bench;
mod broken;
mod injection;
mod judge;
mod stage;

pub use broken::Breakage;
pub use stage::{BRAKES_ENGAGE, DrivesStage};

use super::case::{Case, Situation};
use super::fault::FaultKind;
use super::machine::Desk;
use super::outcome::{Finished, Number, Outcome};
use super::script::{Script as _, finish};
use bench::DriveRun;
use board::chip::hello;
use link::Pacing;
use robot_compiler::SceneFile;
use sim::failure::Failure;

impl<const N: usize> DrivesStage<N> {
    /// Prepares the runs of a scene.
    ///
    /// # Errors
    /// The scene cannot be run, or its robot has no drives on CAN.
    pub fn new(scene: &SceneFile) -> Result<Self, Failure> {
        let mut stage = Self::unarmed(scene)?;
        stage.arming = stage.arming_ticks(scene)?;
        Ok(stage)
    }

    /// The same runs with a board that was built from another scene. The host greets that board; the judge uses this scene.
    ///
    /// # Errors
    /// The other scene cannot be run.
    pub fn with_board_of(mut self, other: &SceneFile) -> Result<Self, Failure> {
        let model = other.robot.model::<N>().map_err(Failure::input)?;
        self.stage.hello = hello(other, &model, Pacing::LockStep);
        Ok(self)
    }

    /// Fewest ticks of undisturbed arming, over several runs.
    fn arming_ticks(&self, scene: &SceneFile) -> Result<u32, Failure> {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let mut desk = Desk::new(scene, &model, Pacing::Live);
        let case = Case { fault: FaultKind::Nothing, situation: Situation::Armed };
        let mut least = u32::MAX;
        for run in 0..8 {
            let number = Number { seed: 0, run };
            let mut bench = DriveRun::new(self, &mut desk, number, None)?;
            let armed = bench.approach(case.situation).map(|()| Outcome::Unaffected);
            least = least.min(bench.armed_in);
            let done = finish(&self.stage.scene, case, number, bench.tick, bench.judge.motion, armed)?;
            if let Some(found) = done.counterexample {
                return Err(Failure::Input(miette::miette!("{}: {}", scene.path.display(), found.what)));
            }
        }
        Ok(least)
    }
}

/// Does one run. `pair` is the number of the pair of requests, if there is one; `breakage` adds a deliberate fault to the board.
///
/// # Errors
/// [`Failure::Input`] if the scene's machine does not reach the state.
pub fn run<const N: usize>(
    stage: &DrivesStage<N>,
    desk: &mut Desk<N>,
    (case, pair): (Case, u64),
    number: Number,
    breakage: Option<Breakage>,
) -> Result<Finished, Failure> {
    let mut bench = DriveRun::new(stage, desk, number, breakage)?;
    bench.pair = pair;
    let played = bench.play(case);
    let (tick, motion) = (bench.tick, bench.judge.motion);
    finish(&stage.stage.scene, case, number, tick, motion, played)
}
