//! The measured program.

use crate::budget::Failure;
use chip_image::Program;
use std::path::Path;

/// Reads the program from its file.
///
/// # Errors
/// The file cannot be read, or is not a program.
pub(crate) fn read(elf: &Path) -> Result<Program, Failure> {
    let broken = |why: String| Failure::Program { path: elf.to_owned(), why };
    let bytes = std::fs::read(elf).map_err(|error| broken(error.to_string()))?;
    Program::parse(&bytes).map_err(|error| broken(error.to_string()))
}
