//! `firmware`: build it, flash it, and the key that a host and a board share.

pub mod key;

use clap::{Args, Subcommand};
use sim::failure::Failure;

/// Options of `firmware`.
#[derive(Clone, Debug, Args)]
pub struct FirmwareArgs {
    /// The task.
    #[command(subcommand)]
    pub task: FirmwareTask,
}

/// The task.
#[derive(Clone, Debug, Subcommand)]
pub enum FirmwareTask {
    /// Make the key that a host and a board share.
    Key(key::KeyArgs),
}

/// Does a task of the firmware; returns the exit code.
///
/// # Errors
/// Those of the task.
pub fn run(args: &FirmwareArgs) -> Result<u8, Failure> {
    match &args.task {
        FirmwareTask::Key(args) => key::run(args),
    }
}
