//! `sweep`: very many runs.

pub mod merge;
pub mod study;

use super::parts::OrPart;
use crate::cli::interrupt::stop_on_interrupt;
use clap::Subcommand;
use sim::failure::Failure;

/// `sweep`, or one of its parts.
pub type SweepCommand = OrPart<study::SweepArgs, SweepPart>;

/// Parts of `sweep`.
#[derive(Clone, Debug, Subcommand)]
pub enum SweepPart {
    /// Put the shards of a study together.
    Merge(merge::MergeArgs),
}

/// Runs the command or its part; returns the exit code.
///
/// # Errors
/// Those of the command.
pub fn run(command: &SweepCommand) -> Result<u8, Failure> {
    match command {
        OrPart::Itself(args) => study::run(args, &stop_on_interrupt()),
        OrPart::Part(SweepPart::Merge(args)) => merge::run(args),
    }
}
