//! Errors that the caller has to fix.

use robot_compiler::FileError;
use std::fmt;

/// A wrong option or file, an exceeded budget, or a tool that has to be installed first. The program exits with
/// [`BadInput::EXIT_CODE`].
#[derive(Debug)]
pub struct BadInput(pub String);

impl BadInput {
    /// Exit code, the same as the simulator's for bad input.
    pub const EXIT_CODE: u8 = 2;
}

impl From<&FileError> for BadInput {
    /// Position, problem and expected value on one line.
    fn from(error: &FileError) -> Self {
        Self(format!("{error}; expected {}", error.expected()))
    }
}

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for BadInput {}
