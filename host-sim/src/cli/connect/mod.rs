//! `connect`: operate an arm, and check records of that.

pub mod replay;
pub mod session;

use super::parts::OrPart;
use crate::cli::interrupt::presses;
use clap::Subcommand;
use sim::failure::Failure;

/// `connect`, or one of its parts.
pub type ConnectCommand = OrPart<session::ConnectArgs, ConnectPart>;

/// Parts of `connect`.
#[derive(Clone, Debug, Subcommand)]
pub enum ConnectPart {
    /// Run a record of `connect` again on the desk, and demand the very same bits.
    Replay(replay::ReplayArgs),
}

/// Runs the command or its part; returns the exit code.
///
/// # Errors
/// Those of the command.
pub fn run(command: &ConnectCommand) -> Result<u8, Failure> {
    match command {
        OrPart::Itself(args) => session::run(args, presses()),
        OrPart::Part(ConnectPart::Replay(args)) => replay::run(args),
    }
}
