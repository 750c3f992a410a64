//! Inputs in the project: the shipped files, and the findings of fuzzing.

use std::fs;
use std::path::{Path, PathBuf};

/// A folder in the project's root.
pub(crate) fn top(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new("")).join(folder)
}

/// Inputs that were findings once, `found/TARGET/*`, with their paths.
#[must_use]
pub fn found(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("found").join(target);
    paths(&folder).into_iter().map(|path| (path.clone(), fs::read(&path).unwrap())).collect()
}

/// The files with this ending in some folders, folder by folder, each sorted.
pub(crate) fn files(folders: &[&str], ending: &str) -> Vec<Vec<u8>> {
    let named = |path: &PathBuf| path.extension().is_some_and(|extension| extension == ending);
    let paths = folders.iter().flat_map(|folder| paths(&top(folder))).filter(named);
    paths.map(|path| fs::read(path).unwrap()).collect()
}

fn paths(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_file()).collect();
    files.sort();
    files
}
