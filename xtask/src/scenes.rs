//! The shipped scenes.

use crate::process::root;
use anyhow::{Context as _, Result};
use std::path::PathBuf;

/// The shipped scenes for the firmware: those at the top of the folder, by name.
pub(crate) fn shipped() -> Result<Vec<PathBuf>> {
    let folder = root().join("scenes");
    let mut scenes = Vec::new();
    for entry in std::fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            scenes.push(path);
        }
    }
    scenes.sort();
    Ok(scenes)
}
