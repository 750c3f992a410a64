//! A bar for what takes its time.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};

/// A bar on standard error, where that is a terminal. `counted` names what is counted, where a person should read the number.
pub(crate) fn progress_bar(length: Option<u64>, counted: &str) -> ProgressBar {
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
