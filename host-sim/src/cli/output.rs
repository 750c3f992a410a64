//! Results on standard output.

use report::Page;
use serde::Serialize;
use sim::failure::{Failure, in_file};
use sim::output::Output;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Print a result. Whoever has read enough of it, as `head` has, is no failure.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    match io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::Output(error)),
        Ok(()) | Err(_) => Ok(()),
    }
}

/// A result as JSON over several lines, as people and `jq` read it; no line end.
pub(super) fn json(result: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(result).map_err(|error| Failure::Output(error.into()))
}

/// Write a page to the file of `--report`, if it was given and has been claimed.
pub(super) fn write_report(
    output: &Output,
    path: Option<&Path>,
    page: impl FnOnce() -> Result<Page, Failure>,
) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    fs::write(path, page()?.html()).map_err(|error| in_file(path, &error))?;
    output.written(&[path.to_owned()])
}

/// A line for each file that was written.
pub(super) fn files(files: &[PathBuf]) -> String {
    let name = |index: usize| if index == 0 { "files" } else { "" };
    files.iter().enumerate().map(|(index, file)| format!("{:<20}{}\n", name(index), file.display())).collect()
}
