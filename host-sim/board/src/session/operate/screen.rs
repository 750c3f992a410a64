//! The lowest lines of the operator's terminal: the live line while the arm moves, and the line that is being typed.
//!
//! Everything else is printed above them. So a message does not cut a half-typed command in two, and the prompt is always the last line.

use console::{Term, truncate_str};
use std::io::{self, Write as _};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time between two drawings of the live line.
const REFRESH: Duration = Duration::from_millis(100);
/// Width of a terminal that does not report one.
const COLUMNS: usize = 80;
const PROMPT: &str = "> ";

/// The lowest lines of standard error, if that is a terminal. Copies share them: the operator's loop prints, and a thread reads keys.
#[derive(Clone, Debug, Default)]
pub struct Screen {
    terminal: Option<Arc<Mutex<Bottom>>>,
}

#[derive(Debug, Default)]
struct Bottom {
    live: Option<String>,
    typed: String,
    /// True while the program waits for a line.
    prompts: bool,
    /// Number of rows that are on the terminal now.
    rows: usize,
    drawn: Option<Instant>,
}

impl Screen {
    /// The screen of standard error. If that is no terminal, nothing is ever drawn.
    #[must_use]
    pub fn new() -> Self {
        Self { terminal: Term::stderr().is_term().then(Arc::default) }
    }

    /// Changes the lines, and draws them if the change says so.
    fn change(&self, change: impl FnOnce(&mut Bottom) -> bool) {
        if let Some(bottom) = &self.terminal {
            // A thread that panicked while it drew has left the lines themselves whole.
            let mut bottom = bottom.lock().unwrap_or_else(PoisonError::into_inner);
            if change(&mut bottom) {
                bottom.draw("");
            }
        }
    }

    /// Prints above the lines.
    ///
    /// # Errors
    /// Those of `print`.
    pub(super) fn above<T>(&self, print: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
        let Some(bottom) = &self.terminal else { return print() };
        let mut bottom = bottom.lock().unwrap_or_else(PoisonError::into_inner);
        bottom.erase();
        let printed = print();
        bottom.draw("");
        printed
    }

    /// Sets or removes the live line.
    pub(super) fn live(&self, line: Option<String>) {
        self.change(|bottom| {
            let appears = line.is_some() != bottom.live.is_some();
            bottom.live = line;
            appears || bottom.live.is_some() && bottom.drawn.is_none_or(|at| at.elapsed() >= REFRESH)
        });
    }

    /// Shows or hides the prompt.
    pub(super) fn prompts(&self, prompts: bool) {
        self.change(|bottom| core::mem::replace(&mut bottom.prompts, prompts) != prompts);
    }

    /// Shows the line that is being typed.
    pub(super) fn typed(&self, line: String) {
        self.change(|bottom| core::mem::replace(&mut bottom.typed, line) != bottom.typed);
    }

    /// Leaves a line that was entered on the terminal, and begins the next one.
    pub(super) fn entered(&self, line: &str) {
        self.change(|bottom| {
            bottom.typed.clear();
            bottom.draw(&format!("{PROMPT}{line}\n"));
            false
        });
    }

    /// Removes all lines at the end of the program.
    pub(super) fn close(&self) {
        self.change(|bottom| {
            (bottom.live, bottom.prompts) = (None, false);
            bottom.typed.clear();
            true
        });
    }
}

impl Bottom {
    /// The lines, each shortened to one row.
    fn lines(&self, columns: usize) -> Vec<String> {
        let live = self.live.as_deref().map(|live| truncate_str(live, columns, "…").into_owned());
        let typed = (self.prompts || !self.typed.is_empty()).then(|| {
            // The end of a long line stays visible.
            let room = columns.saturating_sub(PROMPT.len() + 1);
            let excess = self.typed.chars().count().saturating_sub(room);
            let cut = if excess > 0 { "…" } else { "" };
            format!("{PROMPT}{cut}{}", self.typed.chars().skip(excess).collect::<String>())
        });
        live.into_iter().chain(typed).collect()
    }

    /// Control sequence that removes the rows that are on the terminal.
    fn erasing(&self) -> String {
        match self.rows {
            0 => String::new(),
            1 => "\r\x1b[J".to_owned(),
            rows => format!("\r\x1b[{}A\x1b[J", rows - 1),
        }
    }

    fn erase(&mut self) {
        // If writing fails, only the drawing is wrong.
        let mut out = io::stderr().lock();
        write!(out, "{}", self.erasing()).and_then(|()| out.flush()).ok();
        self.rows = 0;
    }

    /// Replaces the rows on the terminal by `above`, which stays, and the present lines.
    fn draw(&mut self, above: &str) {
        // The last column stays empty: a full row would wrap on some terminals.
        let columns = Term::stderr().size_checked().map_or(COLUMNS, |(_, columns)| usize::from(columns));
        let columns = if columns > 1 { columns - 1 } else { COLUMNS };
        let lines = self.lines(columns);
        let mut out = io::stderr().lock();
        write!(out, "{}{above}{}", self.erasing(), lines.join("\n")).and_then(|()| out.flush()).ok();
        self.rows = lines.len();
        self.drawn = Some(Instant::now());
    }
}

#[cfg(test)]
mod tests {
    use super::Bottom;

    #[test]
    fn each_line_is_one_row() {
        let live = Some("tick 1  running  q 0.1 0.2 0.3".to_owned());
        let mut bottom = Bottom { live, typed: "goto 0.1 0.2 0.3".to_owned(), ..Bottom::default() };
        assert_eq!(bottom.lines(12), ["tick 1  run…", "> …1 0.2 0.3"]);
        (bottom.live, bottom.typed) = (None, "arm".to_owned());
        assert_eq!(bottom.lines(12), ["> arm"]);
        bottom.typed.clear();
        assert_eq!(bottom.lines(12), [""; 0]);
        bottom.prompts = true;
        assert_eq!(bottom.lines(12), ["> "]);
    }

    #[test]
    fn as_many_rows_are_erased_as_were_drawn() {
        let erasing = |rows| Bottom { rows, ..Bottom::default() }.erasing();
        assert_eq!([erasing(0), erasing(1), erasing(2)], ["", "\r\x1b[J", "\r\x1b[1A\x1b[J"]);
    }
}
