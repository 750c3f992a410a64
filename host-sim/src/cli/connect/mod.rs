//! `connect`: operates an arm, and checks records of such sessions.

pub mod options;
pub mod replay;
pub mod session;

use super::parts::OrPart;
use crate::cli::interrupt::presses;
use clap::Subcommand;
use sim::failure::Failure;

/// `connect`, or one of its parts.
pub type ConnectCommand = OrPart<options::ConnectArgs, ConnectPart>;

/// Parts of `connect`.
#[derive(Clone, Debug, Subcommand)]
pub enum ConnectPart {
    /// Replay a record of `connect` on the desk, and require the same bits.
    Replay(replay::ReplayArgs),
}

/// Runs the command or its part. Returns the exit code.
///
/// # Errors
/// Errors of the command.
pub fn run(command: &ConnectCommand) -> Result<u8, Failure> {
    match command {
        OrPart::Itself(args) => session::run(args, presses()),
        OrPart::Part(ConnectPart::Replay(args)) => replay::run(args),
    }
}
