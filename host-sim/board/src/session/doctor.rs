//! Checks of everything that the project needs, for a simulation or for work at a board. One [`Check`] for each item, with advice if it is missing or
//! wrong.
//!
//! A missing item is a [`State::Problem`] for the uses that need it and a [`State::Warning`] for all others. So the
//! same list serves a simulation on a desk and the work at a board.

mod board;
mod program;
mod scene;
mod tools;

pub use board::checks as board_checks;
pub use scene::check as scene_check;
pub use tools::checks as tool_checks;

use clap::ValueEnum;
use serde::Serialize;

/// A use of the project to check for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Use {
    /// Simulate on this machine.
    Desk,
    /// Run the firmware in the emulated chip.
    Emulator,
    /// Write the firmware to a board.
    Flash,
}

/// Result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// Present and correct.
    Ok,
    /// Missing or wrong, but not needed for the checked uses.
    Warning,
    /// Missing or wrong, and needed for a checked use.
    Problem,
}

impl State {
    /// State of a missing or wrong item: a problem if a checked use needs it, otherwise a warning.
    const fn wrong(needed: bool) -> Self {
        if needed { Self::Problem } else { Self::Warning }
    }

    /// Name for the output.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Warning => "warning",
            Self::Problem => "problem",
        }
    }
}

/// One checked item.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Check {
    /// Name of the item.
    pub name: &'static str,
    /// Result of the check.
    pub state: State,
    /// Details of the item as found.
    pub found: String,
    /// Advice, if the item is missing or wrong.
    pub advice: Option<String>,
}

impl Check {
    fn ok(name: &'static str, found: impl Into<String>) -> Self {
        Self { name, state: State::Ok, found: found.into(), advice: None }
    }

    fn wrong(name: &'static str, needed: bool, found: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { name, state: State::wrong(needed), found: found.into(), advice: Some(advice.into()) }
    }
}
