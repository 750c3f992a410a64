//! The lowest lines of the operator's terminal: the live line while the arm moves, and the line that is being typed.
//!
//! Everything else is printed above them. So a message does not cut a half-typed command in two, and the prompt is always the last line.
//!
//! One thread alone writes to the terminal. Whoever prints sends it the text and goes on: a terminal that accepts no text delays neither the stop
//! key nor the heartbeat.

use console::{Term, measure_text_width, truncate_str};
use std::io::{self, Write as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

/// Width of a terminal that does not report one.
const COLUMNS: usize = 80;
const PROMPT: &str = "> ";
/// Longest wait for the terminal at the end of the program.
const CLOSING: Duration = Duration::from_secs(1);

/// The lowest lines of standard error, if that is a terminal. Copies share them: the operator's loop prints, and a thread reads keys.
#[derive(Clone, Debug, Default)]
pub struct Screen {
    drawing: Option<Drawing>,
}

#[derive(Clone, Debug)]
struct Drawing {
    changes: Sender<Change>,
    /// Set when standard output has failed, so that the next message reports it.
    failed: Arc<AtomicBool>,
}

#[derive(Debug)]
enum Change {
    /// A line for standard output, above the others.
    Above(String),
    Live(Option<String>),
    Prompt(bool),
    Typed(String),
    Entered(String),
    Close(Sender<()>),
}

#[derive(Debug, Default)]
struct Bottom {
    live: Option<String>,
    typed: String,
    /// True while the program waits for a line.
    prompts: bool,
    /// Number of rows that are on the terminal now.
    rows: usize,
}

impl Screen {
    /// The screen of standard error. If that is no terminal, nothing is ever drawn.
    #[must_use]
    pub fn new() -> Self {
        if !Term::stderr().is_term() {
            return Self::default();
        }
        let (changes, received) = channel();
        let failed = Arc::<AtomicBool>::default();
        let fails = Arc::clone(&failed);
        std::thread::spawn(move || draw_all(&received, &fails));
        Self { drawing: Some(Drawing { changes, failed }) }
    }

    /// True if the lines are drawn.
    pub(super) const fn is_drawn(&self) -> bool {
        self.drawing.is_some()
    }

    fn send(&self, change: Change) {
        if let Some(drawing) = &self.drawing {
            // After `close` nothing is drawn.
            drawing.changes.send(change).ok();
        }
    }

    /// Prints a line to standard output, above the others. Does not wait for the terminal.
    ///
    /// # Errors
    /// Standard output cannot be written, now or at an earlier line.
    pub(super) fn above(&self, line: &str) -> io::Result<()> {
        let Some(drawing) = &self.drawing else { return print(line) };
        if drawing.failed.load(Ordering::Relaxed) {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        self.send(Change::Above(line.to_owned()));
        Ok(())
    }

    /// Sets or removes the live line.
    pub(super) fn live(&self, line: Option<String>) {
        self.send(Change::Live(line));
    }

    /// Shows or hides the prompt.
    pub(super) fn prompts(&self, prompts: bool) {
        self.send(Change::Prompt(prompts));
    }

    /// Shows the line that is being typed.
    pub(super) fn typed(&self, line: String) {
        self.send(Change::Typed(line));
    }

    /// Leaves a line that was entered on the terminal, and begins the next one.
    pub(super) fn entered(&self, line: &str) {
        self.send(Change::Entered(line.to_owned()));
    }

    /// Removes all lines at the end of the program. Waits until everything is printed, but not for a terminal that accepts no text.
    pub(super) fn close(&self) {
        if self.is_drawn() {
            let (done, ended) = channel();
            self.send(Change::Close(done));
            ended.recv_timeout(CLOSING).ok();
        }
    }
}

fn print(line: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "{line}")?;
    out.flush()
}

/// Draws changes until the screen is closed.
fn draw_all(changes: &Receiver<Change>, failed: &AtomicBool) {
    let mut bottom = Bottom::default();
    for change in changes {
        match change {
            Change::Above(line) => {
                bottom.erase();
                if print(&line).is_err() {
                    failed.store(true, Ordering::Relaxed);
                }
                bottom.draw("");
            }
            Change::Live(line) => {
                bottom.live = line;
                bottom.draw("");
            }
            Change::Prompt(prompts) => {
                bottom.prompts = prompts;
                bottom.draw("");
            }
            Change::Typed(line) => {
                bottom.typed = line;
                bottom.draw("");
            }
            Change::Entered(line) => {
                bottom.typed.clear();
                bottom.draw(&format!("{PROMPT}{}\n", printable(&line)));
            }
            Change::Close(done) => {
                bottom.erase();
                done.send(()).ok();
                return;
            }
        }
    }
}

/// The text without control characters, which would move the cursor.
fn printable(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).collect()
}

impl Bottom {
    /// The lines, each shortened to one row.
    fn lines(&self, columns: usize) -> Vec<String> {
        let live = self.live.as_deref().map(|live| truncate_str(live, columns, "…").into_owned());
        let typed = (self.prompts || !self.typed.is_empty()).then(|| {
            let typed = printable(&self.typed);
            let mut shown = format!("{PROMPT}{typed}");
            // The end of a long line stays visible.
            let mut rest = typed.as_str();
            while measure_text_width(&shown) > columns && !rest.is_empty() {
                rest = rest.char_indices().nth(1).map_or("", |(at, _)| &rest[at..]);
                shown = format!("{PROMPT}…{rest}");
            }
            truncate_str(&shown, columns, "").into_owned()
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
    }
}

#[cfg(test)]
mod tests {
    use super::{Bottom, Screen};
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    #[test]
    fn each_line_is_one_row() {
        let live = Some("tick 1  running  q 0.1 0.2 0.3".to_owned());
        let mut bottom = Bottom { live, typed: "goto 0.1 0.2 0.3".to_owned(), ..Bottom::default() };
        assert_eq!(bottom.lines(12), ["tick 1  run…", "> …1 0.2 0.3"]);
        (bottom.live, bottom.typed) = (None, "arm\u{9b}2J".to_owned());
        assert_eq!(bottom.lines(12), ["> arm2J"]);
        bottom.typed = "広い広い広い".to_owned();
        assert_eq!(bottom.lines(8), ["> …広い"]);
        assert_eq!(bottom.lines(1).len(), 1);
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

    #[test]
    fn a_terminal_that_accepts_no_text_delays_nobody() {
        // The thread that draws is stuck: nothing takes the changes.
        let (changes, _stuck) = channel();
        let screen = Screen { drawing: Some(super::Drawing { changes, failed: Arc::<AtomicBool>::default() }) };
        let start = Instant::now();
        for _ in 0..10_000 {
            screen.typed("arm".to_owned());
            screen.live(Some("tick".to_owned()));
            screen.above("message").unwrap();
        }
        screen.close();
        assert!(start.elapsed() < Duration::from_secs(20));
    }
}
