//! Gravity, where no scene gives it.

use clap::Args;

/// Options of every command that takes a robot under gravity.
#[derive(Clone, Debug, Args)]
pub struct GravityArgs {
    /// Gravitational acceleration in the base frame, m/s^2.
    #[arg(
        long,
        value_name = "GX,GY,GZ",
        value_delimiter = ',',
        allow_hyphen_values = true,
        default_value = "0,0,-9.81"
    )]
    pub gravity: Vec<f64>,
}
