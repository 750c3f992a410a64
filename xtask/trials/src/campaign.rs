//! Fault injection: every fault in every state of the safety state machine, at random ticks. Every tick is judged.
//!
//! ```text
//!          readings, lines                      drives, status
//! arm ---------------------> fault --> machine ----------------> judge
//!  ^   host ---> frames ---> link ------^           |
//!  +------------------------------------------------+
//! ```
//!
//! | module | holds |
//! |---|---|
//! | `target` | the targets under test |
//! | `fault`, `case` | the faults, and faults in states |
//! | `injection` | one fault with its random parameters: its effect on readings, lines, frames and the arm |
//! | `host` | the host's frames, and the link's faults on them |
//! | `machine` | the machine under test: the session on the desk, or the chip together with the desk |
//! | `frames` | the comparison of the frames of chip and desk in one tick |
//! | [`judge`] | the safety check of each command, written from docs/safety.md, independent of the machine's code |
//! | `outcome` | the outcome of a run |
//! | `stage` | the data that all runs of a scene share |
//! | `run` | one run, from the first tick to the last |
//! | `script` | the sequence of every run, from the hello to the recovery of torque |
//! | [`drives`] | runs in which the joints are drives on simulated buses, and the judge of their motion |
//! | `report` | the results of all runs |
//!
//! On the desk a run uses [`link::Pacing::Live`], the path that drives real actuators: a board supplies readings and
//! lines, and the host can fall silent. In the emulated chip a run is a dry run, compared with a dry run of the desk on the
//! same bytes. In a dry run each measurement counts as a message of the host. The host is therefore never silent, and the
//! readings of all joints have the same age.
//!
//! Run `k` of a campaign depends only on the seed, `k` and the scenes, not on threads or earlier runs.

mod case;
pub mod drives;
mod fault;
mod frames;
mod host;
mod injection;
pub mod judge;
mod machine;
mod outcome;
mod random;
mod report;
mod run;
mod script;
mod stage;
mod target;

pub use case::{Case, Situation};
pub use fault::{FaultKind, Span};
pub use judge::{SafetyProperty, Unsafe};
pub use machine::{Both, Desk, Machine, MachineError, TickInputs, TickOutput};
pub use outcome::{Counterexample, Exemption, Finished, Motion, Number, Outcome};
pub use report::{Cell, Report, Row};
pub use run::run;
pub use stage::Stage;
pub use target::Target;

use board::chip::{Chip, build_firmware, hello};
use drives::DrivesStage;
use indicatif::ProgressBar;
use link::Pacing;
use robot_compiler::{SceneFile, with_dof};
use sim::failure::Failure;
use sim::parallel::try_in_parallel;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// The runs of a campaign.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// Scenes, used in turn from run to run.
    pub scenes: Vec<SceneFile>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Numbers of the runs.
    pub runs: Vec<u64>,
    /// The target under test.
    pub target: Target,
}

impl Campaign {
    /// Does all runs, or stops early when `stop` is set.
    ///
    /// # Errors
    /// A scene cannot be run, the chip fails, or the campaign is interrupted.
    pub fn report(&self, stop: &AtomicBool, progress: &ProgressBar) -> Result<Report, Failure> {
        let start = Instant::now();
        progress.set_length(self.runs.len() as u64);
        let finished = self.finished(stop, progress)?.into_iter().map(|(_, finished)| finished).collect();
        progress.finish_and_clear();
        let scenes = self.scenes.iter().map(|scene| scene.name.clone()).collect();
        Ok(Report::new(scenes, (self.target, self.seed), finished, start.elapsed()))
    }

    /// Same as [`Campaign::report`], but returns every run with its number, scene by scene.
    ///
    /// # Errors
    /// As [`Campaign::report`].
    pub fn finished(&self, stop: &AtomicBool, progress: &ProgressBar) -> Result<Vec<(u64, Finished)>, Failure> {
        let mut finished = Vec::with_capacity(self.runs.len());
        let scenes = self.scenes.len() as u64;
        for (index, scene) in self.scenes.iter().enumerate() {
            let numbers: Vec<u64> = self.runs.iter().copied().filter(|run| run % scenes == index as u64).collect();
            if !numbers.is_empty() {
                let done = with_dof!(scene.robot.dof(), N => self.runs_of::<N>(scene, &numbers, stop, progress))?;
                finished.extend(numbers.into_iter().zip(done));
            }
        }
        Ok(finished)
    }

    /// The runs of one scene with these numbers, in order.
    fn runs_of<const N: usize>(
        &self,
        scene: &SceneFile,
        numbers: &[u64],
        stop: &AtomicBool,
        progress: &ProgressBar,
    ) -> Result<Vec<Finished>, Failure> {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let cases = Case::of(scene, self.target);
        let scenes = self.scenes.len() as u64;
        let case = |number: u64| {
            let turn = number / scenes;
            let (index, round) = (turn % cases.len() as u64, turn / cases.len() as u64);
            let (case, first) = cases[index as usize];
            // Each round and scene starts with another second request.
            (case, first + case::REQUESTS * (round * scenes + number % scenes))
        };
        let counted = |done: Result<Finished, Failure>| {
            progress.inc(1);
            done
        };
        let goes_on = || if stop.load(Ordering::Relaxed) { Err(Failure::Interrupted) } else { Ok(()) };
        let number = |run: u64| Number { seed: self.seed, run };
        if self.target == Target::Qemu {
            let stage = Stage::<N>::new(scene)?;
            let bench = hello(scene, &model, Pacing::LockStep);
            let target = |error| Failure::Target(miette::Report::from_err(error));
            let program = build_firmware(&scene.path).map_err(target)?;
            let mut both = Both::new(Chip::start(&program, bench).map_err(target)?, scene, &model);
            let one = |&n: &u64| goes_on().and_then(|()| counted(run(&stage, &mut both, case(n).0, number(n))));
            return numbers.iter().map(one).collect();
        }
        let desk = || Desk::new(scene, &model, Pacing::Live);
        if self.target == Target::Drives {
            let new = || Ok((DrivesStage::<N>::new(scene)?, desk()));
            return pooled(numbers, new, |(stage, desk), n| {
                goes_on().and_then(|()| counted(drives::run(stage, desk, case(n), number(n), None)))
            });
        }
        pooled(
            numbers,
            || Ok((Stage::<N>::new(scene)?, desk())),
            |(stage, desk), n| goes_on().and_then(|()| counted(run(stage, desk, case(n).0, number(n)))),
        )
    }
}

/// Does the runs with these numbers in parallel. Creating a session takes longer than running it, so idle ones are kept for reuse.
fn pooled<T: Send>(
    numbers: &[u64],
    new: impl Fn() -> Result<T, Failure> + Sync,
    one: impl Fn(&mut T, u64) -> Result<Finished, Failure> + Sync,
) -> Result<Vec<Finished>, Failure> {
    let free = Mutex::new(vec![new()?]);
    try_in_parallel(numbers.len(), |index| {
        let kept = free.lock().ok().and_then(|mut free| free.pop());
        let mut bench = kept.map_or_else(&new, Ok)?;
        let done = one(&mut bench, numbers[index]);
        if let Ok(mut free) = free.lock() {
            free.push(bench);
        }
        done
    })
}
