//! Names that several commands take on the command line.

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use robot_compiler::names::{self, Named};

/// Parser of a type by its list of names, which help shows.
#[must_use]
pub fn named<T: Named>() -> impl TypedValueParser<Value = T> {
    let values = T::NAMES.iter().map(|&(name, about, _)| match about {
        "" => PossibleValue::new(name),
        about => PossibleValue::new(name).help(about),
    });
    PossibleValuesParser::new(values).try_map(|name| names::named(&name))
}

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

/// Programming language of written code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Language {
    /// `no_std` Rust.
    #[default]
    Rust,
    /// C99, with a header for C++.
    C,
}
