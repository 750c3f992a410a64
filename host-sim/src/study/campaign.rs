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
//! | `case` | the faults and the states |
//! | `injection` | one fault with its random parameters: its effect on readings, lines, frames and the arm |
//! | `host` | the host's frames, and the link's faults on them |
//! | `machine` | the machine under test: the session on the desk, or the chip with the desk beside it |
//! | [`judge`] | the safety check of each command, written from docs/safety.md, independent of the machine's code |
//! | `run` | one run, from the first tick to the last |
//! | `report` | the results of all runs |
//!
//! On the desk a run uses [`link::Pacing::Live`], the path that drives real actuators: a board supplies readings and
//! lines, and the host can fall silent. In the emulated chip a run is a drill, compared with a drill of the desk on the
//! same bytes. In a drill each measurement counts as a message of the host. The host is therefore never silent, and the
//! readings of all joints have the same age.
//!
//! Run `k` of a campaign depends on the seed, `k` and the scenes alone, not on threads or earlier runs.

mod case;
mod host;
mod injection;
pub mod judge;
mod machine;
mod page;
mod random;
mod report;
mod run;

pub use case::{Case, FaultKind, Situation};
pub use judge::{Law, Unsafe};
pub use machine::{Both, Desk, Machine, Said, Told, Trouble};
pub use report::{Cell, Report, Row};
pub use run::{Counterexample, Finished, Number, Outcome, Stage, run};

use crate::chip::{Chip, build_firmware, hello};
use crate::failure::Failure;
use crate::study::parallel::try_in_parallel;
use indicatif::ProgressBar;
use link::Pacing;
use robot_compiler::{SceneFile, with_dof};
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
    /// Run in the emulated chip with the desk beside it.
    pub on_chip: bool,
}

impl Campaign {
    /// Do all runs, or stop early when `stop` is set.
    ///
    /// # Errors
    /// A scene cannot be run, the chip fails, or the campaign is interrupted.
    pub fn report(&self, stop: &AtomicBool, progress: &ProgressBar) -> Result<Report, Failure> {
        let start = Instant::now();
        progress.set_length(self.runs.len() as u64);
        let finished = self.finished(stop, progress)?.into_iter().map(|(_, finished)| finished).collect();
        progress.finish_and_clear();
        let scenes = self.scenes.iter().map(|scene| scene.name.clone()).collect();
        Ok(Report::new(scenes, self, finished, start.elapsed()))
    }

    /// As [`Campaign::report`]; every run with its number, scene by scene.
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
        let stage = Stage::<N>::new(scene)?;
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let cases = Case::of(scene, self.on_chip);
        let scenes = self.scenes.len() as u64;
        let one = |stage: &Stage<N>, machine: &mut dyn Machine<N>, number: u64| {
            if stop.load(Ordering::Relaxed) {
                return Err(Failure::Interrupted);
            }
            let case = cases[((number / scenes) % cases.len() as u64) as usize];
            let number = Number { seed: self.seed, run: number };
            let done = run(stage, machine, case, number)?;
            progress.inc(1);
            Ok(done)
        };
        if self.on_chip {
            let bench = hello(scene, &model, Pacing::LockStep);
            let target = |error| Failure::Target(miette::Report::from_err(error));
            let program = build_firmware(&scene.path).map_err(target)?;
            let mut both = Both::new(Chip::start(&program, bench).map_err(target)?, scene, &model);
            return numbers.iter().map(|number| one(&stage, &mut both, *number)).collect();
        }
        // A session takes longer to create than to run: idle ones are kept for reuse.
        let free = Mutex::new(vec![(stage, Desk::new(scene, &model, Pacing::Live))]);
        let on_desk = |index: usize| {
            let number = numbers[index];
            let kept = free.lock().ok().and_then(|mut free| free.pop());
            let (stage, mut desk) = match kept {
                Some(kept) => kept,
                None => (Stage::new(scene)?, Desk::new(scene, &model, Pacing::Live)),
            };
            let done = one(&stage, &mut desk, number);
            if let Ok(mut free) = free.lock() {
                free.push((stage, desk));
            }
            done
        };
        try_in_parallel(numbers.len(), on_desk)
    }
}
