//! Files that a command wrote.

use report::Page;
use sim::failure::{Failure, in_file};
use sim::output::Output;
use std::fs;
use std::path::{Path, PathBuf};

/// Write a page to the file of `--report`, if it was given and has been claimed.
pub(crate) fn write_report(
    output: &Output,
    path: Option<&Path>,
    page: impl FnOnce() -> Result<Page, Failure>,
) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    fs::write(path, page()?.html()).map_err(|error| in_file(path, &error))?;
    output.written(&[path.to_owned()])
}

/// A line for each file that was written.
pub(crate) fn files(files: &[PathBuf]) -> String {
    let name = |index: usize| if index == 0 { "files" } else { "" };
    files.iter().enumerate().map(|(index, file)| format!("{:<20}{}\n", name(index), file.display())).collect()
}
