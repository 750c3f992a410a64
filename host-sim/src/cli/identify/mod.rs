//! `identify`: an arm from logs of its motion.

pub mod excite;
pub mod logs;
pub mod corrections;

use clap::{Args, Subcommand};
use sim::failure::Failure;

/// `identify`, or one of its parts.
#[derive(Clone, Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct IdentifyCommand {
    /// The part.
    #[command(subcommand)]
    pub part: Option<IdentifyPart>,
    /// Options of `identify` itself.
    #[command(flatten)]
    pub args: Option<logs::IdentifyArgs>,
}

/// Parts of `identify`.
#[derive(Clone, Debug, Subcommand)]
pub enum IdentifyPart {
    /// Design a motion worth recording, to identify an arm from.
    Excite(excite::ExciteArgs),
}

impl IdentifyCommand {
    /// Does what is asked for; returns the exit code.
    ///
    /// # Errors
    /// Those of the command.
    pub fn run(&self) -> Result<u8, Failure> {
        match (&self.part, &self.args) {
            (Some(IdentifyPart::Excite(args)), _) => excite::run(args).map(|()| 0),
            (None, Some(args)) => logs::run(args),
            (None, None) => Ok(0),
        }
    }
}
