//! How the program ends.

use std::io::{self, Write as _};

/// Exit code: something outside failed.
pub const OUTSIDE: u8 = 1;
/// Exit code: bad input.
pub const INPUT: u8 = 2;
/// Exit code: the run ended in a fault, or the simulated arm ran away.
pub const FAULT: u8 = 3;
/// Exit code: chip and desk differed.
pub const PARITY: u8 = 4;
/// Exit code: interrupted, as shells have it for Ctrl-C.
pub const INTERRUPTED: u8 = 130;

/// Why a command could not be carried out.
#[derive(Debug)]
pub enum Failure {
    /// A file, a line or an option is wrong.
    Input(miette::Report),
    /// The target died or answers nonsense.
    Target(miette::Report),
    /// A result cannot be written.
    Output(io::Error),
    /// Interrupted before there was anything to write.
    Interrupted,
}

impl Failure {
    /// Wrong input, with its place.
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

    /// What to tell the person.
    #[must_use]
    pub fn report(self) -> miette::Report {
        match self {
            Self::Input(report) | Self::Target(report) => report,
            Self::Output(error) => miette::miette!("the result cannot be written: {error}"),
            Self::Interrupted => miette::miette!("interrupted before the run began: nothing was recorded"),
        }
    }
}

/// Print a result. Whoever has read enough of it, as `head` has, is no failure.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    match io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::Output(error)),
        Ok(()) | Err(_) => Ok(()),
    }
}
