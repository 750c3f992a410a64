//! The lines of a connection.

use serde::{Deserialize, Serialize};

/// A line to a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Ask {
    /// The token of the session. Always the first line.
    Token(String),
    /// Report the state.
    State,
    /// Go to these positions, rad or m, while the operator's command `follow` is in force. The answer is the state.
    Target(Vec<f64>),
    /// No more targets: the arm stops, and is held.
    Done,
    /// Stop along the path and hold the arm.
    Stop,
    /// Emergency stop: fault 9, and the safe action of the scene.
    EmergencyStop,
}

/// A line from a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Answer {
    /// The token is right.
    Hello(Greeting),
    /// The state.
    State(Snapshot),
    /// The outcome of a stop: the operator's own message.
    Stopped(String),
    /// The line had no effect, for this reason.
    Error(String),
}

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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
    use super::{Answer, Ask};

    #[test]
    fn lines_are_those_of_the_page() {
        let all = [
            (Ask::Token("ab".into()), r#"{"token":"ab"}"#),
            (Ask::State, r#""state""#),
            (Ask::Target(vec![0.5, -1.0]), r#"{"target":[0.5,-1.0]}"#),
            (Ask::Done, r#""done""#),
            (Ask::Stop, r#""stop""#),
            (Ask::EmergencyStop, r#""emergency-stop""#),
        ];
        let page = include_str!("../../../../../docs/reference/session-socket.md");
        for (ask, line) in all {
            assert_eq!(serde_json::to_string(&ask).unwrap(), line);
            assert_eq!(serde_json::from_str::<Ask>(line).unwrap(), ask);
            let shown = line.split(['[', ':']).next().unwrap();
            assert!(page.contains(shown), "docs/reference/session-socket.md: expected {shown}");
        }
        assert_eq!(serde_json::to_string(&Answer::Error("no".into())).unwrap(), r#"{"error":"no"}"#);
    }

    #[test]
    fn other_lines_are_no_requests() {
        for line in [
            "",
            "GET / HTTP/1.1",
            "{}",
            r#"{"target":[1,null]}"#,
            r#"{"target":[NaN]}"#,
            r#"{"stop":1,"state":2}"#,
            "[]",
        ] {
            assert!(serde_json::from_str::<Ask>(line).is_err(), "{line}");
        }
    }
}
