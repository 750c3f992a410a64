//! The marker file, which lists the files that this program wrote into a folder.

use crate::failure::{Failure, in_file};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;

/// Name of the marker of a folder.
pub(crate) const MARKER: &str = ".newtau-output.json";

/// Name of the marker in earlier versions.
const EARLIER: &str = ".host-sim-output.json";

const ABOUT: &str =
    "newtau made this folder. It replaces these files, unless they were changed since; everything else is left alone.";

/// Files that this program wrote into a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Marker {
    #[serde(default)]
    about: String,
    /// SHA-256 of each file by its name.
    #[serde(default)]
    files: BTreeMap<String, String>,
}

impl Marker {
    /// True if this file name is that of a marker.
    pub(crate) fn is_named(name: &str) -> bool {
        [MARKER, EARLIER].contains(&name)
    }

    /// True if the folder has a marker.
    pub(crate) fn is_in(folder: &Path) -> bool {
        [MARKER, EARLIER].iter().any(|name| folder.join(name).exists())
    }

    /// Reads the marker of a folder; returns an empty one if there is none, or a broken one.
    pub(crate) fn read(folder: &Path) -> Self {
        let text = [MARKER, EARLIER].iter().find_map(|name| fs::read(folder.join(name)).ok()).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    }

    /// Marks a folder that has no marker.
    pub(crate) fn adopt(folder: &Path) -> Result<(), Failure> {
        if Self::is_in(folder) {
            return Ok(());
        }
        Self::default().write(folder).map_err(|error| in_file(&folder.join(MARKER), &error))
    }

    /// Digest that a file had when it was written.
    pub(crate) fn digest(&self, path: &Path) -> Option<&str> {
        self.files.get(&*path.file_name()?.to_string_lossy()).map(String::as_str)
    }

    pub(crate) fn set(&mut self, path: &Path) -> io::Result<()> {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        self.files.insert(name, digest(path)?);
        Ok(())
    }

    pub(crate) fn write(&self, folder: &Path) -> io::Result<()> {
        let whole = Self { about: ABOUT.to_owned(), files: self.files.clone() };
        // Written in one step, because shards write to the same folder at the same time.
        let beside = folder.join(format!("{MARKER}.{}", std::process::id()));
        fs::write(&beside, serde_json::to_string_pretty(&whole)? + "\n")?;
        fs::rename(&beside, folder.join(MARKER))
    }
}

/// SHA-256 of a file.
pub(crate) fn digest(path: &Path) -> io::Result<String> {
    let (mut file, mut hash, mut buffer) = (File::open(path)?, Sha256::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut buffer)? {
            0 => break,
            read => hash.update(&buffer[..read]),
        }
    }
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}
