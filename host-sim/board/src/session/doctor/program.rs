//! Other programs, run for their version or their output.

use std::io;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Limit on a program's run time. A version query is fast; a search for probes may take seconds.
const LIMIT: Duration = Duration::from_secs(20);

/// Outcome of a run.
pub(super) enum Answer {
    /// The path has no such program.
    Missing,
    /// The program could not start, failed, or took too long; the text is the reason.
    Failed(String),
    /// The program succeeded with this output.
    Said(String),
}

impl Answer {
    /// The output, if the program succeeded.
    pub(super) fn said(self) -> Option<String> {
        match self {
            Self::Said(text) => Some(text),
            Self::Missing | Self::Failed(_) => None,
        }
    }
}

/// Runs a program to its end, or to [`LIMIT`].
pub(super) fn ask(program: &str, arguments: &[&str]) -> Answer {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = match command.spawn() {
        Ok(child) => child,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Answer::Missing,
        Err(error) => return Answer::Failed(format!("cannot be started: {error}")),
    };
    let end = Instant::now() + LIMIT;
    // The output of these programs fits into a pipe's buffer, so none waits for a reader before it ends.
    while matches!(child.try_wait(), Ok(None)) {
        if Instant::now() >= end {
            child.kill().ok();
            child.wait().ok();
            return Answer::Failed(format!("did not end within {} s", LIMIT.as_secs()));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    match child.wait_with_output() {
        Ok(output) if output.status.success() => {
            Answer::Said(String::from_utf8_lossy(&output.stdout).trim().to_owned())
        }
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr);
            Answer::Failed(format!("{}: {}", output.status, said.lines().last().unwrap_or("it said nothing")))
        }
        Err(error) => Answer::Failed(error.to_string()),
    }
}

/// The first line of a program's output.
pub(super) fn first_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().to_owned()
}
