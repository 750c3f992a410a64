//! The lines of a connection.

use super::snapshot::{Greeting, Snapshot};
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
