//! The state of a session for other programs.

use serde::{Deserialize, Serialize};

/// State of a session.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Tick of the board's last status.
    pub tick: u32,
    /// Time of that tick since the session began, s.
    pub time: f64,
    /// Name of the state of the safety state machine.
    pub state: String,
    /// The state in words.
    pub text: String,
    /// Positions, rad or m; empty if they are not known.
    pub q: Vec<f64>,
    /// Velocities, rad/s or m/s; empty if the board does not report them.
    pub qd: Vec<f64>,
    /// Commanded torques, N m or N; empty if no torque acts.
    pub torque: Vec<f64>,
    /// Heat of each motor, as a share of its continuous limit; `None` where it is unknown. Empty for an arm without drives.
    pub heat: Vec<Option<f64>>,
    /// Age of this state, s; `None` in a dry run, whose state changes only with a command.
    pub age: Option<f64>,
    /// Times of the control loop in words, where this program runs it.
    pub timing: Option<String>,
    /// True while the arm follows the targets of another program.
    pub following: bool,
}

/// A session as it introduces itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Greeting {
    /// Path of the scene.
    pub scene: String,
    /// Names of the joints, base first.
    pub joints: Vec<String>,
    /// Ticks per second.
    pub rate: f64,
    /// Lowest and highest position of each joint, rad or m; `None` where there is no limit.
    pub range: Vec<(Option<f64>, Option<f64>)>,
}
