//! `choose`: settings that are accurate enough, and what they cost.

pub mod bound;
pub mod cheapest;
pub mod margins;
pub mod trade;

use super::parts::OrPart;
use crate::cli::interrupt::stop_on_interrupt;
use clap::Subcommand;
use sim::failure::Failure;
use studies::trade::chip::Chip;

/// `choose`, or one of its parts.
pub type ChooseCommand = OrPart<cheapest::ChooseArgs, ChoosePart>;

/// Parts of `choose`.
#[derive(Clone, Debug, Subcommand)]
pub enum ChoosePart {
    /// Cost of every choice of accuracy on the chip: the ones that nothing beats.
    Trade(trade::TradeArgs),
    /// Error of torques in single precision: proven upper bound, and largest error found.
    Bound(bound::BoundArgs),
    /// Margin of each number of a scene before the arm is lost.
    Margins(margins::MarginsArgs),
}

/// Runs the command or its part; returns the exit code.
///
/// # Errors
/// Those of the command.
pub fn run(command: &ChooseCommand, chip: &dyn Chip) -> Result<u8, Failure> {
    match command {
        OrPart::Itself(args) => cheapest::run(args, chip, &stop_on_interrupt()).map(|()| 0),
        OrPart::Part(ChoosePart::Trade(args)) => trade::run(args, chip, &stop_on_interrupt()).map(|()| 0),
        OrPart::Part(ChoosePart::Bound(args)) => bound::run(args).map(|()| 0),
        OrPart::Part(ChoosePart::Margins(args)) => margins::run(args, &stop_on_interrupt()).map(|()| 0),
    }
}
