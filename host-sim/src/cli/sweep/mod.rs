//! `sweep`: very many runs.

pub mod merge;
pub mod study;

use clap::{Args, Subcommand};
use sim::failure::Failure;

/// `sweep`, or one of its parts.
#[derive(Clone, Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct SweepCommand {
    /// The part.
    #[command(subcommand)]
    pub part: Option<SweepPart>,
    /// Options of `sweep` itself.
    #[command(flatten)]
    pub args: Option<study::SweepArgs>,
}

/// Parts of `sweep`.
#[derive(Clone, Debug, Subcommand)]
pub enum SweepPart {
    /// Put the shards of a study together.
    Merge(merge::MergeArgs),
}

impl SweepCommand {
    /// Does what is asked for; returns the exit code.
    ///
    /// # Errors
    /// Those of the command.
    pub fn run(&self) -> Result<u8, Failure> {
        match (&self.part, &self.args) {
            (Some(SweepPart::Merge(args)), _) => merge::run(args),
            (None, Some(args)) => study::run(args, &super::stop_on_interrupt()),
            (None, None) => Ok(0),
        }
    }
}
