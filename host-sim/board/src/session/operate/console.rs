//! Sources of commands: a file, a pipe, or a user at a terminal.
//!
//! At a terminal, a thread reads every key immediately, whatever the operator's loop waits for. Esc, space on an empty line, and the lines `stop` and
//! `s` count as presses of the stop key and bypass the queue of lines. Ctrl-D is the line `quit`.

use super::keys::{Editor, Event, Keyboard, Presses};
use super::screen::Screen;
use firmware_image::process::line_channel;
use std::collections::VecDeque;
use std::io::{self, BufRead as _, BufReader, IsTerminal as _, Read as _, Write as _};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
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
    /// Presses of the stop key; `None` without a terminal.
    stops: Option<Presses>,
    /// Presses of the dead-man key; `None` where single keys cannot be read.
    held: Option<Presses>,
    screen: Screen,
    prompted: bool,
    /// Restores the terminal's settings when the console ends.
    _keyboard: Option<Keyboard>,
}

#[derive(Debug)]
enum Source {
    Script(VecDeque<String>),
    Pipe(Receiver<String>),
    Terminal(Receiver<String>),
}

impl Console {
    /// Reads the lines of a script. If a user sits at the terminal, the stop key works; other typed input has no effect.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn script(path: &Path) -> io::Result<Self> {
        let text = std::fs::read_to_string(path)?;
        let lines = text.lines().map(str::to_owned).collect();
        let console = Self::new(Source::Script(lines), path.display().to_string());
        Ok(if io::stdin().is_terminal() { console.with_stop_key().0 } else { console })
    }

    /// Lines of standard input.
    #[must_use]
    pub fn standard_input() -> Self {
        if !io::stdin().is_terminal() {
            let lines = line_channel(BufReader::new(io::stdin()));
            return Self::new(Source::Pipe(lines), "standard input".into());
        }
        let console = Self::new(Source::Script(VecDeque::new()), "standard input".into());
        let (mut console, lines) = console.with_stop_key();
        console.source = Source::Terminal(lines);
        console
    }

    /// Reads the terminal's keys in a separate thread. Returns a channel of the typed lines.
    fn with_stop_key(mut self) -> (Self, Receiver<String>) {
        let (sender, lines) = channel();
        let (stops, held, keyboard) = (Presses::default(), Presses::default(), Keyboard::take());
        // Without single keys the terminal itself echoes, and the program does not know what is on the screen.
        if keyboard.is_some() {
            self.screen = Screen::new();
        }
        let (count, by_key, screen) = (Arc::clone(&stops), keyboard.is_some(), self.screen.clone());
        let alive = Arc::clone(&held);
        std::thread::spawn(move || match by_key {
            true => read_keys(&sender, &count, &alive, &screen),
            false => read_lines(&sender, &count),
        });
        self.held = keyboard.is_some().then_some(held);
        (self.stops, self._keyboard) = (Some(stops), keyboard);
        (self, lines)
    }

    /// A console with lines that a user at a terminal has already typed.
    #[cfg(test)]
    pub(crate) fn typed(lines: &[&str]) -> Self {
        let (sender, typed) = channel();
        lines.iter().for_each(|line| sender.send((*line).to_owned()).unwrap_or_default());
        Self::new(Source::Terminal(typed), "terminal".into())
    }

    fn new(source: Source, name: String) -> Self {
        Self {
            source,
            name,
            number: 0,
            stops: None,
            held: None,
            screen: Screen::default(),
            prompted: false,
            _keyboard: None,
        }
    }

    /// Counter of presses of the stop key, if a user types at a terminal.
    #[must_use]
    pub fn stops(&self) -> Option<Presses> {
        self.stops.clone()
    }

    /// Counter of presses of the dead-man key, Tab; `None` where single keys cannot be read.
    #[must_use]
    pub fn dead_man(&self) -> Option<Presses> {
        self.held.clone()
    }

    /// The lowest lines of the terminal, which whoever prints must respect.
    #[must_use]
    pub fn screen(&self) -> Screen {
        self.screen.clone()
    }

    /// True if a user types at a terminal, reads the answers, and can correct errors.
    #[must_use]
    pub fn is_a_person(&self) -> bool {
        matches!(self.source, Source::Terminal(_))
    }

    /// File and number of the last line.
    #[must_use]
    pub fn place(&self) -> String {
        format!("{}:{}", self.name, self.number)
    }

    /// Discards all lines that were typed and not executed, and returns their number. After a stop, none of them may move the arm again.
    pub fn discard(&mut self) -> usize {
        match &self.source {
            Source::Terminal(lines) => lines.try_iter().filter(|line| !line.trim().is_empty()).count(),
            Source::Script(_) | Source::Pipe(_) => 0,
        }
    }

    /// Shows that the program waits for a line, if a user types at a terminal.
    fn prompt(&mut self) {
        if self.prompted || !self.is_a_person() {
            return;
        }
        self.prompted = true;
        if self.screen.is_drawn() {
            self.screen.prompts(true);
        } else if io::stderr().is_terminal() {
            eprint!("> ");
            // If flushing fails, only the prompt may be missing.
            io::stderr().flush().ok();
        }
    }

    /// The next line. Waits no longer than `wait`.
    pub fn next(&mut self, wait: Duration) -> Line {
        self.prompt();
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
            self.screen.prompts(false);
        }
        line
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        self.screen.close();
    }
}

/// True if the line requests a stop, which must not wait for other lines.
fn is_stop(line: &str) -> bool {
    matches!(line.trim(), "stop" | "s")
}

/// Sends a line, or counts it if it requests a stop. A script takes no typed lines, but the stop key works all the same.
fn pass_on(line: String, lines: &Sender<String>, stops: &AtomicU32) {
    if is_stop(&line) {
        stops.fetch_add(1, Ordering::Relaxed);
    } else {
        lines.send(line).ok();
    }
}

/// Reads lines of a terminal whose keys cannot be read one by one.
fn read_lines(lines: &Sender<String>, stops: &AtomicU32) {
    for line in io::stdin().lock().lines() {
        let Ok(line) = line else { break };
        pass_on(line, lines, stops);
    }
}

/// Reads a terminal key by key, shows what is typed, and sends whole lines.
fn read_keys(lines: &Sender<String>, stops: &AtomicU32, held: &AtomicU32, screen: &Screen) {
    let mut editor = Editor::default();
    let mut bytes = [0; 256];
    loop {
        let count = match io::stdin().lock().read(&mut bytes) {
            Ok(0) => return,
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => return,
        };
        for event in editor.take(bytes.get(..count).unwrap_or_default()) {
            match event {
                Event::Stop => {
                    stops.fetch_add(1, Ordering::Relaxed);
                }
                Event::Held => {
                    held.fetch_add(1, Ordering::Relaxed);
                }
                Event::Typed(line) => screen.typed(line),
                // Shown before it is sent, so that its answer comes below it. Showing does not wait for the terminal.
                Event::Line(line) => {
                    screen.entered(&line);
                    pass_on(line, lines, stops);
                }
                // Keys are read until the program ends, because an arm may be moving.
                Event::End => pass_on("quit".into(), lines, stops),
            }
        }
    }
}
