//! Command-line options that several requests share.

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use robot_compiler::Robot;
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

/// Options of every command that takes a robot under gravity.
#[derive(Clone, Debug, Default, PartialEq, Args)]
pub struct GravityArgs {
    /// Gravitational acceleration in the base frame, m/s^2. Without it, 0,0,-9.81, turned if the robot file turns the base.
    #[arg(long, value_name = "GX,GY,GZ", value_delimiter = ',', allow_hyphen_values = true)]
    pub gravity: Option<Vec<f64>>,
}

impl GravityArgs {
    /// Gravity of the option, or else the default in the base frame of this robot, m/s^2.
    #[must_use]
    pub fn of(&self, robot: &Robot) -> Vec<f64> {
        self.gravity.clone().unwrap_or_else(|| robot.gravity().as_slice().to_vec())
    }
}
