//! The program at a terminal: options by name, results, progress bar, messages, Ctrl-C and exit code.

use crate::failure::Failure;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use robot_compiler::Robot;
use robot_compiler::names::{self, Named};
use serde::Serialize;
use std::io::{self, IsTerminal, Write as _};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Prints a result. It is no failure if the reader closes the pipe early, as `head` does.
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

/// A progress bar on standard error, if that is a terminal. `counted` is the unit of the number, or empty.
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

/// Prints messages without line breaks, because scripts read them too and search them for a line number.
pub fn keep_lines_of_messages() {
    let unbroken = || miette::MietteHandlerOpts::new().wrap_lines(false).build();
    if let Err(error) = miette::set_hook(Box::new(move |_| Box::new(unbroken()))) {
        eprintln!("{error}");
    }
}

/// Returns a flag that Ctrl-C sets. `otherwise` describes the effect of Ctrl-C if the system allows no handler.
#[must_use]
pub fn stop_on_interrupt(otherwise: &str) -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    if let Err(error) = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed)) {
        eprintln!("Ctrl-C will {otherwise}: {error}");
    }
    stop
}

/// Prints a failure. Returns the program's exit code.
#[must_use]
pub fn exit_code(done: Result<u8, Failure>) -> ExitCode {
    ExitCode::from(done.unwrap_or_else(|failure| {
        let code = failure.code();
        eprintln!("{:?}", failure.report());
        code
    }))
}

/// Prints a note on standard error if the robot's base is rotated, because results depend on it.
pub fn say_mounting(robot: &Robot) {
    let note = robot.mounting_note();
    if !note.is_empty() {
        eprintln!("note: {note}");
    }
}

/// Parser of a type by its list of names, which help shows.
#[must_use]
pub fn named<T: Named>() -> impl TypedValueParser<Value = T> {
    let values = T::NAMES.iter().map(|&(name, about, _)| match about {
        "" => PossibleValue::new(name),
        about => PossibleValue::new(name).help(about),
    });
    PossibleValuesParser::new(values).try_map(|name| names::named(&name))
}
