//! A study that is ready to run.

use super::experiment::SceneRuns;
use robot_compiler::study::{Design, Study, with_robot};
use sha2::{Digest as _, Sha256};
use sim::failure::Failure;
use sim::parallel::{Jobs, try_in_parallel};
use std::fs;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// A study, its files, and all data that its runs share.
#[derive(Debug)]
pub struct Prepared {
    /// The study.
    pub study: Study,
    /// Number of runs.
    pub count: u64,
    /// The study's files: names and texts. They refer to each other by these names.
    pub files: Vec<(String, String)>,
    /// Hash of the files and of the program's version. Two folders with the same hash are parts of the same study.
    pub identity: String,
    pub(super) runs: SceneRuns,
}

/// Largest number of runs that a thread does together and keeps in memory.
const CHUNK: u64 = 16;

/// Version of this program; the results of a run depend on it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

impl Prepared {
    /// Reads a study with all its files; `runs` replaces its number of runs.
    ///
    /// # Errors
    /// [`Failure::Input`]: a file cannot be read, a key does not exist, the first run is invalid, or a number of runs is given for a grid.
    pub fn load(path: &Path, runs: Option<u64>) -> Result<Self, Failure> {
        let mut study = Study::load(path).map_err(Failure::input)?;
        if let Some(runs) = runs {
            if study.runs.design == Design::Grid {
                let problem = miette::miette!("--runs {runs}: {} is a grid, whose steps give its runs", path.display());
                return Err(Failure::Input(problem));
            }
            study.runs.count = runs;
        }
        let count = study.runs.count;
        let files = study.copies(count).map_err(Failure::input)?;
        let runs = SceneRuns::new(&study)?;
        Ok(Self { identity: identity(&files), study, count, files, runs })
    }

    /// Titles of the columns of a table of runs, the index first.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        core::iter::once("index".to_owned()).chain(self.runs.columns()).collect()
    }

    /// Does the runs with these indices, and returns them in order as cells of the [`columns`](Self::columns). Every run depends only on the study
    /// and its index.
    ///
    /// All runs of a study are done here, so that several can be computed together.
    ///
    /// # Errors
    /// [`Failure::Interrupted`] after `stop`; otherwise those of the runs.
    pub fn outcomes(&self, indices: Range<u64>, jobs: &Jobs, stop: &AtomicBool) -> Result<Vec<Vec<String>>, Failure> {
        let count = indices.end.saturating_sub(indices.start);
        let chunk = count.div_ceil(jobs.count() as u64).clamp(1, CHUNK);
        let part = |number: usize| {
            let from = indices.start + number as u64 * chunk;
            self.runs.rows(from..indices.end.min(from + chunk), stop)
        };
        let parts = usize::try_from(count.div_ceil(chunk)).unwrap_or(usize::MAX);
        Ok(jobs.run(|| try_in_parallel(parts, part))?.concat())
    }

    /// Checks that the copies of the study's files overwrite no other file in a folder.
    ///
    /// # Errors
    /// [`Failure::Input`]: the folder has a different file with a copy's name.
    pub fn may_lie_in(&self, folder: &Path) -> Result<(), Failure> {
        replace_nothing(&self.files, folder, "expected an empty folder, or one that the same study wrote")
    }

    /// Files of one run, by name and text: its scene, and its robot (the study's own if the run does not change it).
    ///
    /// # Errors
    /// [`Failure::Input`] if the text is not a valid scene.
    pub(super) fn stand_alone(&self, scene: &str, robot: Option<&str>) -> Result<Vec<(String, String)>, Failure> {
        let own = self.files.iter().find(|(name, _)| name.starts_with("robot"));
        let (name, text) = own.map_or(("robot.toml", ""), |(name, text)| (name, text));
        let scene = with_robot(scene, name).map_err(Failure::input)?;
        Ok(vec![("scene.toml".to_owned(), scene), (name.to_owned(), robot.unwrap_or(text).to_owned())])
    }
}

/// Checks that these files, by name and text, overwrite no different ones in a folder.
///
/// # Errors
/// [`Failure::Input`]: the folder has a different file with such a name.
pub(super) fn replace_nothing(files: &[(String, String)], folder: &Path, expected: &str) -> Result<(), Failure> {
    let other =
        |(name, text): &&(String, String)| fs::read(folder.join(name)).is_ok_and(|found| found != text.as_bytes());
    files.iter().find(other).map_or(Ok(()), |(name, _)| {
        Err(Failure::Input(miette::miette!(
            help = expected.to_owned(),
            "{}: has another {name}, which a copy would replace",
            folder.display()
        )))
    })
}

/// Hash of a study's files and of the program's version.
fn identity(files: &[(String, String)]) -> String {
    let mut hash = Sha256::new();
    hash.update(VERSION);
    for (name, text) in files {
        for part in [name, text] {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part);
        }
    }
    hexadecimal(&hash.finalize())
}

/// Formats bytes in hexadecimal.
pub(super) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
