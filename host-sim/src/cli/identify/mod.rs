//! `identify`: an arm from logs of its motion.

pub mod corrections;
pub mod excite;
pub mod logs;

use super::parts::OrPart;
use clap::Subcommand;
use sim::failure::Failure;

/// `identify`, or one of its parts.
pub type IdentifyCommand = OrPart<logs::IdentifyArgs, IdentifyPart>;

/// Parts of `identify`.
#[derive(Clone, Debug, Subcommand)]
pub enum IdentifyPart {
    /// Design a motion worth recording, to identify an arm from.
    Excite(excite::ExciteArgs),
}

/// Runs the command or its part; returns the exit code.
///
/// # Errors
/// Those of the command.
pub fn run(command: &IdentifyCommand) -> Result<u8, Failure> {
    match command {
        OrPart::Itself(args) => logs::run(args),
        OrPart::Part(IdentifyPart::Excite(args)) => excite::run(args).map(|()| 0),
    }
}
