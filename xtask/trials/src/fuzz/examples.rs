//! Inputs that the project contains: the shipped files, and findings of the fuzzer.

use crate::fuzz::cases::{Case, Table};
use std::fs;
use std::path::{Path, PathBuf};

/// A folder in the project's root.
pub(crate) fn top(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new("")).join(folder)
}

/// Inputs that once violated a property, `found/TARGET/*`, with their paths.
#[must_use]
pub fn found(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("found").join(target);
    paths(&folder).into_iter().map(|path| (path.clone(), fs::read(&path).unwrap())).collect()
}

/// Files with this extension in some folders, folder by folder, each sorted.
pub(crate) fn files(folders: &[&str], ending: &str) -> Vec<Vec<u8>> {
    let named = |path: &PathBuf| path.extension().is_some_and(|extension| extension == ending);
    let paths = folders.iter().flat_map(|folder| paths(&top(folder))).filter(named);
    paths.map(|path| fs::read(path).unwrap()).collect()
}

/// Invalid files with this extension in the tests of the robot compiler, sorted by name.
pub(crate) fn invalid(ending: &str) -> Vec<Vec<u8>> {
    let folder = top("robot-compiler/tests/bad");
    let tables = paths(&folder).into_iter().filter(|path| path.extension().is_some_and(|extension| extension == "txt"));
    let mut cases: Vec<_> = tables.flat_map(|path| Table::read(&path).cases).collect();
    cases.retain(|case| case.name.ends_with(&format!(".{ending}")));
    cases.sort_by(|a, b| a.name.cmp(&b.name));
    let bytes = |case: Case| case.input.map_or_else(|| fs::read(folder.join(&case.name)).unwrap(), String::into_bytes);
    cases.into_iter().map(bytes).collect()
}

fn paths(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_file()).collect();
    files.sort();
    files
}

#[cfg(test)]
mod tests {
    use super::invalid;

    /// A wrong path to the tables would silently leave them out.
    #[test]
    fn invalid_files_of_the_compiler_are_found() {
        let has = |ending, text: &str| {
            invalid(ending).iter().filter(|bytes| String::from_utf8_lossy(bytes).contains(text)).count()
        };
        assert_eq!(has("toml", "mass = -1.5"), 1);
        assert_eq!(has("urdf", "<mass value=\"-2.0\"/>"), 1);
    }
}
