//! `choose`: settings that are accurate enough, and their costs.

pub mod bound;
pub mod cheapest;
pub mod margins;
pub mod trade;

use super::parts::OrPart;
use crate::run::stop_on_interrupt;
use clap::Subcommand;
use sim::failure::Failure;
use studies::trade::chip::Chip;

/// `choose`, or one of its parts.
pub type ChooseCommand = OrPart<cheapest::ChooseArgs, ChoosePart>;

/// Parts of `choose`.
#[derive(Clone, Debug, Subcommand)]
pub enum ChoosePart {
    /// Show accuracy and cost on the chip of many settings, and those that no other setting beats.
    Trade(trade::TradeArgs),
    /// Bound the torque error of single precision: proven upper bound, and largest error found.
    Bound(bound::BoundArgs),
    /// Show how far each number of a scene may change before the arm is lost.
    Margins(margins::MarginsArgs),
}

/// Runs the command or its part. Returns the exit code.
///
/// Errors of the command.
/// Those of the command.
pub fn run(command: &ChooseCommand, chip: &dyn Chip) -> Result<u8, Failure> {
    match command {
        OrPart::Itself(args) => cheapest::run(args, chip, &stop_on_interrupt()).map(|()| 0),
        OrPart::Part(ChoosePart::Trade(args)) => trade::run(args, chip, &stop_on_interrupt()).map(|()| 0),
        OrPart::Part(ChoosePart::Bound(args)) => bound::run(args).map(|()| 0),
        OrPart::Part(ChoosePart::Margins(args)) => margins::run(args, &stop_on_interrupt()).map(|()| 0),
    }
}
