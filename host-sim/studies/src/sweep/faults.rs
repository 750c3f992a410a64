//! Runs of a fault-injection campaign.

use crate::campaign::{Campaign, Finished, Outcome, Target};
use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use sim::failure::Failure;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Titles of the columns behind the index.
const COLUMNS: [&str; 7] = ["scene", "fault", "state", "outcome", "ticks", "end", "pass"];

/// A campaign on the desk.
#[derive(Debug)]
pub(super) struct CampaignRuns {
    scenes: Vec<SceneFile>,
    seed: u64,
}

impl CampaignRuns {
    /// Reads the scenes.
    ///
    /// # Errors
    /// [`Failure::Input`]: a scene cannot be read.
    pub(super) fn new(scenes: &[PathBuf], seed: u64) -> Result<Self, Failure> {
        let scenes =
            scenes.iter().map(|path| SceneFile::load(path).map_err(Failure::input)).collect::<Result<_, _>>()?;
        Ok(Self { scenes, seed })
    }

    /// Titles of the columns behind the index.
    pub(super) fn columns(&self) -> Vec<String> {
        COLUMNS.map(str::to_owned).into()
    }

    /// Does these runs, as rows in their order.
    ///
    /// # Errors
    /// As [`Campaign::report`].
    pub(super) fn rows(&self, indices: Range<u64>, stop: &AtomicBool) -> Result<Vec<Vec<String>>, Failure> {
        let campaign =
            Campaign { scenes: self.scenes.clone(), seed: self.seed, runs: indices.collect(), target: Target::Desk };
        let mut finished = campaign.finished(stop, &ProgressBar::hidden())?;
        finished.sort_by_key(|(number, _)| *number);
        Ok(finished.iter().map(|(number, finished)| self.row(*number, finished)).collect())
    }

    fn row(&self, number: u64, finished: &Finished) -> Vec<String> {
        let scene = &self.scenes[(number % self.scenes.len() as u64) as usize].name;
        let outcome = match finished.outcome {
            Outcome::Fault(code) => format!("fault {code}"),
            Outcome::Held(cause) => format!("held {cause}"),
            Outcome::Asked => "asked".to_owned(),
            Outcome::Unaffected => "unaffected".to_owned(),
        };
        let (fault, state) = (finished.case.fault.name(), finished.case.situation.name());
        let (end, pass) = if finished.counterexample.is_some() { ("unsafe", "0") } else { ("complete", "1") };
        let ticks = finished.ticks.to_string();
        [number.to_string().as_str(), scene, fault, state, &outcome, &ticks, end, pass].map(str::to_owned).into()
    }
}
