//! Names that several commands take on the command line.

use clap::ValueEnum;

/// Target that computes the torques.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// This program.
    Desk,
    /// The firmware, in an emulated STM32F405.
    Qemu,
}

/// Inclusion of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Presence {
    /// It counts.
    Present,
    /// It is left out.
    Absent,
}
