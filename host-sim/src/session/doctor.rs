//! Is everything there that a use of the project needs? One [`Check`] for each thing, with what to do about it.
//!
//! What is missing is a [`State::Problem`] for the uses that need it and a [`State::Warning`] for all others, so the same list
//! serves who simulates on a desk and who stands in front of a board.

mod board;
mod program;
mod scene;
mod tools;

pub use board::checks as board_checks;
pub use scene::check as scene_check;
pub use tools::checks as tool_checks;

use clap::ValueEnum;
use serde::Serialize;

/// What somebody wants to do.
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

/// How a check came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// As it should be.
    Ok,
    /// Not needed for what was asked; something else will miss it.
    Warning,
    /// What was asked for does not work without it.
    Problem,
}

impl State {
    /// What something missing or wrong is to a use that needs it, or does not.
    const fn wrong(needed: bool) -> Self {
        if needed { Self::Problem } else { Self::Warning }
    }

    /// As it is printed.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Warning => "warning",
            Self::Problem => "problem",
        }
    }
}

/// One thing that was looked at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Check {
    /// What was looked at.
    pub name: &'static str,
    /// How it came out.
    pub state: State,
    /// What was found.
    pub found: String,
    /// What to do, where something is not as it should be.
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
