//! `identify`: the model of an arm from logs of its motion.

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
    /// Design a motion to record for the identification of an arm.
    Excite(excite::ExciteArgs),
}

/// Runs the command or its part. Returns the exit code.
///
/// # Errors
/// Errors of the command.
pub fn run(command: &IdentifyCommand) -> Result<u8, Failure> {
    match command {
        OrPart::Itself(args) => logs::run(args),
        OrPart::Part(IdentifyPart::Excite(args)) => excite::run(args).map(|()| 0),
    }
}
