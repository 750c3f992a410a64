//! Gravity, where no scene gives it.

use clap::Args;
use robot_compiler::Robot;

/// Options of every command that takes a robot under gravity.
#[derive(Clone, Debug, Args)]
pub struct GravityArgs {
    /// Gravitational acceleration in the base frame, m/s^2; 0,0,-9.81 otherwise, turned with the base if the robot's is.
    #[arg(long, value_name = "GX,GY,GZ", value_delimiter = ',', allow_hyphen_values = true)]
    pub gravity: Option<Vec<f64>>,
}

impl GravityArgs {
    /// The option, or gravity in the base frame of this robot.
    #[must_use]
    pub fn of(&self, robot: &Robot) -> Vec<f64> {
        self.gravity.clone().unwrap_or_else(|| robot.gravity().as_slice().to_vec())
    }
}

/// Says on standard error that the base of a robot is turned, where it is: results depend on it.
pub(crate) fn say_mounting(robot: &Robot) {
    let note = robot.mounting_note();
    if !note.is_empty() {
        eprintln!("note: {note}");
    }
}
