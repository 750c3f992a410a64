//! The person who moves the arm by hand, and types.

use firmware_image::process::line_channel;
use sim::failure::Failure;
use std::io::{self, BufReader};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

/// Interval at which the joints are read while a person moves them.
const LOOK: Duration = Duration::from_millis(20);

/// Lines of a person.
pub(super) struct Person(Receiver<String>);

impl Person {
    /// Begins to read standard input.
    pub(super) fn new() -> Self {
        Self(line_channel(BufReader::new(io::stdin())))
    }

    /// Reads these lines instead.
    #[cfg(test)]
    pub(super) fn of(lines: Receiver<String>) -> Self {
        Self(lines)
    }

    /// The next line; meanwhile, `look` is called every 20 ms.
    pub(super) fn answer(&self, mut look: impl FnMut() -> Result<(), Failure>) -> Result<String, Failure> {
        loop {
            match self.0.recv_timeout(LOOK) {
                Ok(line) => return Ok(line.trim().to_owned()),
                Err(RecvTimeoutError::Timeout) => look()?,
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(Failure::Input(miette::miette!(
                        "the input ended before the setup was complete: nothing was written"
                    )));
                }
            }
        }
    }

    /// The next line.
    pub(super) fn enter(&self) -> Result<String, Failure> {
        self.answer(|| Ok(()))
    }

    /// Forgets lines that came before a question: they cannot be its answer.
    pub(super) fn forget(&self) {
        while self.0.try_recv().is_ok() {}
    }
}
