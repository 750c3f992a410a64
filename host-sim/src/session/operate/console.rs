//! Sources of commands: a file, a pipe, or a user at a terminal.

use std::collections::VecDeque;
use std::io::{self, BufRead, IsTerminal, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, channel};
use std::time::Duration;

/// Answer of a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// A line of text.
    Text(String),
    /// No line yet.
    None,
    /// No more lines.
    End,
}

/// A source of lines.
#[derive(Debug)]
pub struct Console {
    source: Source,
    name: String,
    number: usize,
    prompted: bool,
}

#[derive(Debug)]
enum Source {
    Script(VecDeque<String>),
    Pipe(Receiver<String>),
    Terminal(Receiver<String>),
}

impl Console {
    /// Lines of a script.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn script(path: &Path) -> io::Result<Self> {
        let text = std::fs::read_to_string(path)?;
        let lines = text.lines().map(str::to_owned).collect();
        Ok(Self { source: Source::Script(lines), name: path.display().to_string(), number: 0, prompted: false })
    }

    /// Lines of standard input.
    #[must_use]
    pub fn standard_input() -> Self {
        let (sender, lines) = channel();
        // The thread ends with the program: a blocking read of a line cannot be interrupted.
        std::thread::spawn(move || {
            for line in io::stdin().lock().lines() {
                if line.is_err() || line.is_ok_and(|line| sender.send(line).is_err()) {
                    break;
                }
            }
        });
        let source = if io::stdin().is_terminal() { Source::Terminal(lines) } else { Source::Pipe(lines) };
        Self { source, name: "standard input".into(), number: 0, prompted: false }
    }

    /// Whether a user types at a terminal, reads the answers, and can correct errors.
    #[must_use]
    pub fn is_a_person(&self) -> bool {
        matches!(self.source, Source::Terminal(_))
    }

    /// File and number of the last line.
    #[must_use]
    pub fn place(&self) -> String {
        format!("{}:{}", self.name, self.number)
    }

    /// The next line. Waits no longer than `wait`.
    pub fn next(&mut self, wait: Duration) -> Line {
        if self.is_a_person() && !self.prompted {
            self.prompted = true;
            eprint!("> ");
            // If flushing fails, only the prompt may be missing.
            io::stderr().flush().ok();
        }
        let line = match &mut self.source {
            Source::Script(lines) => lines.pop_front().map_or(Line::End, Line::Text),
            Source::Pipe(lines) | Source::Terminal(lines) if wait.is_zero() => match lines.try_recv() {
                Ok(line) => Line::Text(line),
                Err(TryRecvError::Empty) => Line::None,
                Err(TryRecvError::Disconnected) => Line::End,
            },
            Source::Pipe(lines) | Source::Terminal(lines) => match lines.recv_timeout(wait) {
                Ok(line) => Line::Text(line),
                Err(RecvTimeoutError::Timeout) => Line::None,
                Err(RecvTimeoutError::Disconnected) => Line::End,
            },
        };
        if let Line::Text(_) = line {
            self.number += 1;
            self.prompted = false;
        }
        line
    }
}
