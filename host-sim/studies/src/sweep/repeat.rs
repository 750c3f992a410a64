//! The command that repeats one run of a study.

use super::Prepared;
use super::store::STUDY;
use robot_compiler::study::{Study, Subject};
use sim::run::files::shell_word;
use std::path::{Path, PathBuf};

/// What a command for one run names.
#[derive(Clone, Debug)]
pub enum Repeat {
    /// The study file, as a word of a shell.
    Scene(String),
    /// Words behind the number of a campaign's run.
    Campaign {
        /// Seed of everything random.
        seed: u64,
        /// The scene files, as words of a shell.
        scenes: String,
    },
}

impl Repeat {
    /// Commands for the copies of a study in this folder.
    #[must_use]
    pub fn new(prepared: &Prepared, folder: &Path) -> Self {
        match prepared.study.subject {
            Subject::Scene(_) => Self::Scene(shell_word(&folder.join(STUDY))),
            Subject::Campaign(_) => {
                let copies = prepared.files.iter().map(|(name, _)| folder.join(name));
                Self::campaign(prepared.study.runs.seed, copies.filter(|path| is_scene(path)))
            }
        }
    }

    /// Commands for the study's own files.
    pub(super) fn of_files(study: &Study) -> Self {
        match &study.subject {
            Subject::Scene(_) => Self::Scene(shell_word(&study.path)),
            Subject::Campaign(scenes) => Self::campaign(study.runs.seed, scenes.iter().cloned()),
        }
    }

    fn campaign(seed: u64, scenes: impl Iterator<Item = PathBuf>) -> Self {
        Self::Campaign { seed, scenes: scenes.map(|path| shell_word(&path)).collect::<Vec<_>>().join(" ") }
    }

    /// The command for the run with this index.
    #[must_use]
    pub fn command(&self, index: u64) -> String {
        match self {
            Self::Scene(study) => format!("host-sim sweep {study} --replay {index} --out out/run_{index}"),
            Self::Campaign { seed, scenes } => format!("host-sim campaign --seed {seed} --run {index} {scenes}"),
        }
    }
}

/// Whether a copy is a scene, by the name that copies have.
fn is_scene(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("scene"))
}
