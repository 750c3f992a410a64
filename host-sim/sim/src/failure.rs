//! Reasons why a command fails, and the exit codes of the program.

use std::io;
use std::path::Path;

/// Exit code: something outside the program failed.
pub const OUTSIDE: u8 = 1;
/// Exit code: bad input.
pub const INPUT: u8 = 2;
/// Exit code: the run ended in a fault, the simulation of the arm diverged, a robot file is wrong, or an identified model is doubtful.
pub const FAULT: u8 = 3;
/// Exit code: chip and desk differed.
pub const PARITY: u8 = 4;
/// Exit code: interrupted; the code of shells for Ctrl-C.
pub const INTERRUPTED: u8 = 130;

/// Reason why a command failed.
#[derive(Debug)]
pub enum Failure {
    /// A file, a line or an option is wrong.
    Input(miette::Report),
    /// The target failed or sent an invalid answer.
    Target(miette::Report),
    /// A result cannot be written.
    Output(io::Error),
    /// Interrupted before there was a result to write.
    Interrupted,
}

impl Failure {
    /// Wraps an error about wrong input; the error names the position of the mistake.
    pub fn input(error: impl Into<miette::Report>) -> Self {
        Self::Input(error.into())
    }

    /// The exit code.
    #[must_use]
    pub const fn code(&self) -> u8 {
        match self {
            Self::Input(_) => INPUT,
            Self::Target(_) | Self::Output(_) => OUTSIDE,
            Self::Interrupted => INTERRUPTED,
        }
    }

    /// Message for the user.
    #[must_use]
    pub fn report(self) -> miette::Report {
        match self {
            Self::Input(report) | Self::Target(report) => report,
            Self::Output(error) => miette::miette!("the result cannot be written: {error}"),
            Self::Interrupted => miette::miette!("interrupted before the run began: nothing was recorded"),
        }
    }
}

/// A number in a message, with an exponent if it would otherwise have many digits.
pub fn number(x: f64) -> String {
    if x == 0.0 || (1e-6..1e15).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

/// Failure for a file that cannot be written, or was only partly written.
pub fn in_file(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Output(io::Error::other(format!("{}: {error}", path.display())))
}
