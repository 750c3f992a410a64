//! `sweep`: very many runs.

pub mod merge;
pub mod study;

use super::parts::OrPart;
use crate::run::stop_on_interrupt;
use clap::Subcommand;
use sim::failure::Failure;

/// `sweep`, or one of its parts.
pub type SweepCommand = OrPart<study::SweepArgs, SweepPart>;

/// Parts of `sweep`.
#[derive(Clone, Debug, Subcommand)]
pub enum SweepPart {
    /// Merge the shards of a study.
    Merge(merge::MergeArgs),
}

/// Runs the command or its part. Returns the exit code.
///
/// # Errors
/// Errors of the command.
pub fn run(command: &SweepCommand) -> Result<u8, Failure> {
    match command {
        OrPart::Itself(args) => study::run(args, &stop_on_interrupt()),
        OrPart::Part(SweepPart::Merge(args)) => merge::run(args),
    }
}
