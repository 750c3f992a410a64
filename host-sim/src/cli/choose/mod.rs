//! `choose`: settings that are accurate enough, and what they cost.

pub mod bound;
pub mod cheapest;
pub mod margins;
pub mod trade;

use clap::{Args, Subcommand};
use sim::failure::Failure;
use studies::trade::chip::Chip;

/// `choose`, or one of its parts.
#[derive(Clone, Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct ChooseCommand {
    /// The part.
    #[command(subcommand)]
    pub part: Option<ChoosePart>,
    /// Options of `choose` itself.
    #[command(flatten)]
    pub args: Option<cheapest::ChooseArgs>,
}

/// Parts of `choose`.
#[derive(Clone, Debug, Subcommand)]
pub enum ChoosePart {
    /// What every choice of accuracy costs on the chip: the ones that nothing beats.
    Trade(trade::TradeArgs),
    /// How wrong the torques of single precision are: a proven bound, and the worst that was found.
    Bound(bound::BoundArgs),
    /// How far each number of a scene may go before the arm is lost.
    Margins(margins::MarginsArgs),
}

impl ChooseCommand {
    /// Does what is asked for; returns the exit code.
    ///
    /// # Errors
    /// Those of the command.
    pub fn run(&self, chip: &dyn Chip) -> Result<u8, Failure> {
        match (&self.part, &self.args) {
            (Some(ChoosePart::Trade(args)), _) => trade::run(args, chip, &super::stop_on_interrupt()).map(|()| 0),
            (Some(ChoosePart::Bound(args)), _) => bound::run(args).map(|()| 0),
            (Some(ChoosePart::Margins(args)), _) => margins::run(args, &super::stop_on_interrupt()).map(|()| 0),
            (None, Some(args)) => cheapest::run(args, chip, &super::stop_on_interrupt()).map(|()| 0),
            (None, None) => Ok(0),
        }
    }
}
