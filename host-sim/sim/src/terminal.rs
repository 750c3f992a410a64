//! Results on standard output, and a progress bar on standard error.

use crate::failure::Failure;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::io::{self, IsTerminal, Write as _};

/// Print a result. A reader that closes the pipe early, as `head` does, is no failure.
///
/// # Errors
/// [`Failure::Output`]: standard output cannot be written.
pub fn print(text: &str) -> Result<(), Failure> {
    match io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::Output(error)),
        Ok(()) | Err(_) => Ok(()),
    }
}

/// A result as indented JSON without a line end.
///
/// # Errors
/// [`Failure::Output`]: the result cannot be written as JSON.
pub fn json(result: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(result).map_err(|error| Failure::Output(error.into()))
}

/// A progress bar on standard error, if that is a terminal. `counted` names the unit of the number; empty for none.
#[must_use]
pub fn progress_bar(length: Option<u64>, counted: &str) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(length, ProgressDrawTarget::stderr_with_hz(10));
    let number = if counted.is_empty() { String::new() } else { format!("{{pos}} of {{len}} {counted}, ") };
    match ProgressStyle::with_template(&format!("{{bar:40}} {{percent:>3}} %  {number}{{eta}} to go  {{msg}}")) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
