//! Fault injection: every fault in every state of the safety state machine, at random ticks, each tick judged.
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
//! | `case` | which faults there are, which states |
//! | `injection` | one fault with its numbers: what it does to readings, lines, frames and the arm |
//! | `host` | what the host sends, and what becomes of it on the link |
//! | `machine` | who is put to the test: the session on the desk, or the chip with the desk beside it |
//! | [`judge`] | whether a command was safe: from docs/safety.md, and nothing of the machine |
//! | `run` | one run, from the first tick to the last |
//! | `report` | what came of all of them |
//!
//! On the desk a run is [`link::Pacing::Live`]: the very path that drives drives, with the readings and lines of a board, and a host that
//! can fall silent. In the emulated chip it is a drill, beside the desk's on the same bytes. There each measurement is a word of the
//! host, so that it is never silent, and all joints' readings are equally old.
//!
//! Run `k` of a campaign depends on seed, `k` and scenes alone: not on threads, nor on the runs before it.

mod case;
mod dice;
mod host;
mod injection;
pub mod judge;
mod machine;
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

/// Which runs.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// The scenes, run by run in turn.
    pub scenes: Vec<SceneFile>,
    /// Seed of everything random.
    pub seed: u64,
    /// The runs' numbers.
    pub runs: Vec<u64>,
    /// In the emulated chip, the desk beside it.
    pub on_chip: bool,
}

impl Campaign {
    /// Do all the runs; until `stop` is set.
    ///
    /// # Errors
    /// A scene that cannot be run, a chip that is of no use, an interruption.
    pub fn report(&self, stop: &AtomicBool, progress: &ProgressBar) -> Result<Report, Failure> {
        let start = Instant::now();
        progress.set_length(self.runs.len() as u64);
        let mut finished = Vec::new();
        for (index, scene) in self.scenes.iter().enumerate() {
            finished.extend(with_dof!(scene.robot.dof(), N => self.runs_of::<N>(scene, index as u64, stop, progress))?);
        }
        progress.finish_and_clear();
        let scenes = self.scenes.iter().map(|scene| scene.name.clone()).collect();
        Ok(Report::new(scenes, self, finished, start.elapsed()))
    }

    /// The runs of one scene, in order.
    fn runs_of<const N: usize>(
        &self,
        scene: &SceneFile,
        index: u64,
        stop: &AtomicBool,
        progress: &ProgressBar,
    ) -> Result<Vec<Finished>, Failure> {
        let stage = Stage::<N>::new(scene)?;
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let cases = Case::of(scene, self.on_chip);
        let scenes = self.scenes.len() as u64;
        let numbers: Vec<u64> = self.runs.iter().copied().filter(|run| run % scenes == index).collect();
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
            return numbers.into_iter().map(|number| one(&stage, &mut both, number)).collect();
        }
        // A session takes longer to make than to run: those that are free are kept.
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
