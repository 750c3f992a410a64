//! List of the files that a command wrote.

use std::path::PathBuf;

/// A line for each file that was written.
pub(crate) fn files(files: &[PathBuf]) -> String {
    let name = |index: usize| if index == 0 { "files" } else { "" };
    files.iter().enumerate().map(|(index, file)| format!("{:<20}{}\n", name(index), file.display())).collect()
}
