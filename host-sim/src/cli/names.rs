//! Names that several commands take on the command line.

use clap::ValueEnum;

/// Inclusion of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Presence {
    /// It counts.
    Present,
    /// It is left out.
    Absent,
}
