//! Command-line options that several requests share.

use clap::Args;
use robot_compiler::Robot;

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
