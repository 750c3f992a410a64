//! A study that is ready to run.

use super::experiment::SceneRuns;
use super::faults::CampaignRuns;
use crate::failure::Failure;
use crate::study::parallel::{Jobs, try_in_parallel};
use robot_compiler::study::{Design, Study, Subject, with_robot};
use sha2::{Digest as _, Sha256};
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// A study, its files, and all that its runs share.
#[derive(Debug)]
pub struct Prepared {
    /// The study.
    pub study: Study,
    /// Number of runs.
    pub count: u64,
    /// The study's files by name and text, each naming the others by these names.
    pub files: Vec<(String, String)>,
    /// Hash of the files and of the program's version: two folders with the same are parts of the same study.
    pub identity: String,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    Scene(Box<SceneRuns>),
    Campaign(Box<CampaignRuns>),
}

/// Version of this program, of which a run is a function too.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Runs that a thread does side by side: enough that few lanes of a batch wait for the last run.
const SIDE_BY_SIDE: u64 = 64;

impl Prepared {
    /// Reads a study with all its files, with another number of runs where one is given.
    ///
    /// # Errors
    /// [`Failure::Input`]: a file that cannot be read, a key that leads nowhere, a first run that cannot be read, a number of runs beside a
    /// grid.
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
        let kind = match &study.subject {
            Subject::Scene(experiment) => Kind::Scene(Box::new(SceneRuns::new(&study, experiment)?)),
            Subject::Campaign(scenes) => Kind::Campaign(Box::new(CampaignRuns::new(scenes, study.runs.seed)?)),
        };
        Ok(Self { identity: identity(&files), study, count, files, kind })
    }

    /// Titles of the columns of a table of runs, the index first.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        let behind = match &self.kind {
            Kind::Scene(runs) => runs.columns(),
            Kind::Campaign(runs) => runs.columns(),
        };
        core::iter::once("index".to_owned()).chain(behind).collect()
    }

    /// The runs with these indices, in order, as cells of the [`columns`](Self::columns). Every run is a function of the study and its
    /// index alone.
    ///
    /// # Errors
    /// [`Failure::Interrupted`] after `stop`; otherwise as the runs.
    pub fn outcomes(&self, indices: Range<u64>, jobs: &Jobs, stop: &AtomicBool) -> Result<Vec<Vec<String>>, Failure> {
        match &self.kind {
            Kind::Scene(runs) => jobs.run(|| {
                let groups = indices.end.saturating_sub(indices.start).div_ceil(SIDE_BY_SIDE);
                let rows = try_in_parallel(usize::try_from(groups).unwrap_or(usize::MAX), |group| {
                    let first = indices.start + group as u64 * SIDE_BY_SIDE;
                    let indices = first..(first + SIDE_BY_SIDE).min(indices.end);
                    let rows = indices.clone().zip(runs.rows(indices, stop)?);
                    Ok(rows.map(|(index, row)| core::iter::once(index.to_string()).chain(row).collect()).collect())
                })?;
                Ok(rows.into_iter().flat_map(|rows: Vec<Vec<String>>| rows).collect())
            }),
            Kind::Campaign(runs) => jobs.run(|| runs.rows(indices, stop)),
        }
    }

    /// Files of one run by name and text: its scene, and its robot, which the study's own is where the run does not change it.
    ///
    /// # Errors
    /// [`Failure::Input`] for a text that is no scene.
    pub(super) fn stand_alone(&self, scene: &str, robot: Option<&str>) -> Result<Vec<(String, String)>, Failure> {
        let own = self.files.iter().find(|(name, _)| name.starts_with("robot"));
        let (name, text) = own.map_or(("robot.toml", ""), |(name, text)| (name, text));
        let scene = with_robot(scene, name).map_err(Failure::input)?;
        Ok(vec![("scene.toml".to_owned(), scene), (name.to_owned(), robot.unwrap_or(text).to_owned())])
    }

    /// Runs of a scene; `None` for a campaign.
    pub(super) fn scene_runs(&self) -> Option<&SceneRuns> {
        match &self.kind {
            Kind::Scene(runs) => Some(runs),
            Kind::Campaign(_) => None,
        }
    }
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

/// Bytes in hexadecimal.
pub(super) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
