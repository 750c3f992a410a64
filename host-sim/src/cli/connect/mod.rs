//! `connect`: operate an arm, and check records of that.

pub mod replay;
pub mod session;

use clap::{Args, Subcommand};
use sim::failure::Failure;

/// `connect`, or one of its parts.
#[derive(Clone, Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct ConnectCommand {
    /// The part.
    #[command(subcommand)]
    pub part: Option<ConnectPart>,
    /// Options of `connect` itself.
    #[command(flatten)]
    pub args: Option<session::ConnectArgs>,
}

/// Parts of `connect`.
#[derive(Clone, Debug, Subcommand)]
pub enum ConnectPart {
    /// Run a record of `connect` again on the desk, and demand the very same bits.
    Replay(replay::ReplayArgs),
}

impl ConnectCommand {
    /// Does what is asked for; returns the exit code.
    ///
    /// # Errors
    /// Those of the command.
    pub fn run(&self) -> Result<u8, Failure> {
        match (&self.part, &self.args) {
            (Some(ConnectPart::Replay(args)), _) => replay::run(args),
            (None, Some(args)) => session::run(args, super::presses()),
            (None, None) => Ok(0),
        }
    }
}
