//! Manifest of a table of runs.

use super::{MANIFEST, Shard};
use crate::sweep::Prepared;
use crate::sweep::prepared::VERSION;
use serde::{Deserialize, Serialize};
use sim::failure::{Failure, in_file};
use std::fs;
use std::path::Path;

/// State of a table of runs after its last whole block.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Hash of the study's files and of the program's version.
    pub study: String,
    /// Version of the program.
    pub version: String,
    /// Hash of the study's first run as computed on this machine. Parts with different hashes come from different programs.
    pub first_run: String,
    /// Number of runs of the whole study.
    pub runs: u64,
    /// Number of the shard, counted from 1, and number of shards.
    pub shard: [u64; 2],
    /// First index of the shard.
    pub from: u64,
    /// Index after the last one of the shard.
    pub to: u64,
    /// Number of rows that are safely written.
    pub rows: u64,
    /// Number of bytes of the table that are safely written, including its head.
    pub bytes: u64,
    /// SHA-256 of these bytes.
    pub sha256: String,
}

impl Manifest {
    /// Creates the manifest of an empty table.
    #[must_use]
    pub fn new(prepared: &Prepared, first_run: &str, shard: Shard) -> Self {
        let indices = shard.indices(prepared.count);
        Self {
            study: prepared.identity.clone(),
            version: VERSION.to_owned(),
            first_run: first_run.to_owned(),
            runs: prepared.count,
            shard: shard.numbers(),
            from: indices.start,
            to: indices.end,
            rows: 0,
            bytes: 0,
            sha256: String::new(),
        }
    }

    /// True if all rows are written.
    #[must_use]
    pub const fn is_complete(&self) -> bool {
        self.rows == self.to - self.from
    }

    /// Reads the manifest of a folder; `None` if there is none.
    ///
    /// # Errors
    /// [`Failure::Input`]: it cannot be read, or is not a manifest.
    pub fn read(folder: &Path) -> Result<Option<Self>, Failure> {
        let path = folder.join(MANIFEST);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(Failure::Input(miette::miette!("{}: {error}", path.display()))),
        };
        let read: Result<Self, _> = serde_json::from_str(&text);
        let manifest = read.map_err(|error| {
            Failure::Input(miette::miette!(
                help = "expected a manifest as `newtau sweep` writes it",
                "{}: {error}",
                path.display()
            ))
        })?;
        let possible = Shard::new(manifest.shard[0], manifest.shard[1]).is_some_and(|shard| {
            shard.indices(manifest.runs) == (manifest.from..manifest.to) && manifest.rows <= manifest.to - manifest.from
        });
        if possible {
            return Ok(Some(manifest));
        }
        Err(Failure::Input(miette::miette!(
            help = "expected the indices of this shard",
            "{}: rows {} of {} to {} in shard {}/{}",
            path.display(),
            manifest.rows,
            manifest.from,
            manifest.to,
            manifest.shard[0],
            manifest.shard[1]
        )))
    }

    /// Writes the manifest atomically.
    ///
    /// # Errors
    /// [`Failure::Output`] if it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(self).map_err(|error| Failure::Output(error.into()))?;
        replace(&folder.join(MANIFEST), format!("{text}\n").as_bytes())
    }

    /// Describes the first difference between two manifests that should belong to the same study; `None` if there is none.
    #[must_use]
    pub fn differs(&self, other: &Self) -> Option<String> {
        if self.version != other.version {
            Some(format!("version {} of the program, not {}", self.version, other.version))
        } else if self.runs != other.runs {
            Some(format!("{} runs, not {}", self.runs, other.runs))
        } else if self.study != other.study {
            Some("another study: a scene, a robot or the study differs".to_owned())
        } else if self.first_run != other.first_run {
            Some("the study's first run gave other numbers: another build of the program".to_owned())
        } else {
            None
        }
    }
}

/// Writes a file atomically: readers see the old or the new contents.
pub(crate) fn replace(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let beside = path.with_extension("new");
    let written = fs::write(&beside, bytes).and_then(|()| fs::rename(&beside, path));
    written.map_err(|error| in_file(path, &error))
}
