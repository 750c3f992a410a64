//! Pages that commands write: reports for a browser, and tables of the documentation.

use crate::failure::{Failure, in_file};
use crate::output::Output;
use report::Page;
use robot_compiler::emit::page::Page as Document;
use std::fs;
use std::path::Path;

/// Writes a report.
///
/// # Errors
/// [`Failure::Output`]: the file cannot be written.
pub fn write(path: &Path, page: &Page) -> Result<(), Failure> {
    fs::write(path, page.html()).map_err(|error| in_file(path, &error))
}

/// Writes a report to the file of `--report`, if the option was given and the file has been claimed.
///
/// # Errors
/// As [`write()`], and the errors of `page`.
pub fn write_claimed(
    output: &Output,
    path: Option<&Path>,
    page: impl FnOnce() -> Result<Page, Failure>,
) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    write(path, &page()?)?;
    output.written(&[path.to_owned()])
}

/// Reads the document of `--write`, which must have a marked section for each of these tables.
///
/// # Errors
/// [`Failure::Input`]: the document cannot be read, or lacks a section.
pub fn document(path: Option<&Path>, places: &[&str]) -> Result<Option<Document>, Failure> {
    let read = |path| Document::read(path, places).map_err(|error| Failure::Input(miette::miette!("{error}")));
    path.map(read).transpose()
}

/// Puts tables into their sections and writes the document.
///
/// # Errors
/// [`Failure::Output`]: the file cannot be written.
pub fn fill(mut document: Document, tables: &[(&str, String)]) -> Result<(), Failure> {
    let filled = tables.iter().try_for_each(|(place, text)| document.put(place, text));
    filled.and_then(|()| document.write()).map_err(Failure::Output)
}
