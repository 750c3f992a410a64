//! Keys of a terminal: a line editor with a stop key.

use std::sync::Arc;
use std::sync::atomic::AtomicU32;

/// Counter of presses: of Ctrl-C, or of the stop key.
pub type Presses = Arc<AtomicU32>;

/// Outcome of typed bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Event {
    /// A whole line.
    Line(String),
    /// The stop key: Esc, or space on an empty line.
    Stop,
    /// The line so far, after a change.
    Typed(String),
    /// The dead-man key, Tab.
    Held,
    /// Ctrl-D on an empty line.
    End,
}

/// Line that is being typed.
#[derive(Clone, Debug, Default)]
pub(super) struct Editor {
    line: Vec<u8>,
}

const END: u8 = 0x04;
const TAB: u8 = 0x09;
const BACKSPACE: [u8; 2] = [0x08, 0x7F];
const ERASE_LINE: u8 = 0x15;
const ESCAPE: u8 = 0x1B;

impl Editor {
    /// Handles the bytes of one read. A key press arrives alone; pasted text and the sequences of arrow keys arrive in one piece.
    pub(super) fn take(&mut self, bytes: &[u8]) -> Vec<Event> {
        let mut events = Vec::new();
        let mut rest = bytes;
        while let Some((&byte, after)) = rest.split_first() {
            rest = after;
            match byte {
                // Arrow keys and similar: the sequence is skipped. An Esc that is alone, or before anything else, stops.
                ESCAPE if matches!(after, [b'[' | b'O', _, ..]) => {
                    let end = after.iter().skip(1).position(|byte| (0x40..=0x7E).contains(byte));
                    rest = after.get(end.map_or(after.len(), |end| end + 2)..).unwrap_or_default();
                }
                ESCAPE => events.push(Event::Stop),
                // In pasted text a space at the beginning of a line is an indentation. Several presses may arrive together.
                b' ' if self.line.is_empty() => {
                    if bytes.iter().all(|byte| *byte == b' ') {
                        events.push(Event::Stop);
                    }
                }
                b'\n' | b'\r' => {
                    events.push(Event::Line(self.text()));
                    self.line.clear();
                }
                END if self.line.is_empty() => events.push(Event::End),
                // A key that is held arrives alone. Within a line or pasted text it is a slip.
                TAB if bytes.iter().all(|byte| *byte == TAB) => events.push(Event::Held),
                ERASE_LINE => {
                    self.line.clear();
                    events.push(Event::Typed(String::new()));
                }
                byte if BACKSPACE.contains(&byte) => {
                    // Removes one whole UTF-8 character: its continuation bytes, then its first byte.
                    while self.line.pop().is_some_and(|byte| byte & 0xC0 == 0x80) {}
                    events.push(Event::Typed(self.text()));
                }
                byte if byte < 0x20 => {}
                byte => {
                    self.line.push(byte);
                    // A character of several bytes is shown once it is whole.
                    let is_whole =
                        str::from_utf8(&self.line).map_or_else(|error| error.error_len().is_some(), |_| true);
                    if is_whole {
                        events.push(Event::Typed(self.text()));
                    }
                }
            }
        }
        events
    }

    fn text(&self) -> String {
        String::from_utf8_lossy(&self.line).into_owned()
    }
}

/// A terminal whose keys are read one by one. Its settings are restored on drop.
#[cfg(unix)]
#[derive(Debug)]
pub(super) struct Keyboard(rustix::termios::Termios);

#[cfg(unix)]
impl Keyboard {
    /// Switches the terminal to reading single keys; `None` if it does not allow that.
    pub(super) fn take() -> Option<Self> {
        use rustix::termios::{InputModes, LocalModes, OptionalActions, tcgetattr, tcsetattr};
        let input = std::io::stdin();
        let before = tcgetattr(&input).ok()?;
        let mut raw = before.clone();
        // Ctrl-C stays a signal, and output stays as it is.
        raw.local_modes.remove(LocalModes::ICANON | LocalModes::ECHO);
        // Ctrl-S would stop the output, and with it the heartbeat.
        raw.input_modes.remove(InputModes::IXON);
        tcsetattr(&input, OptionalActions::Now, &raw).ok()?;
        Some(Self(before))
    }
}

#[cfg(unix)]
impl Drop for Keyboard {
    fn drop(&mut self) {
        use rustix::termios::{OptionalActions, tcsetattr};
        tcsetattr(std::io::stdin(), OptionalActions::Now, &self.0).ok();
    }
}

/// Stand-in for systems without single-key input: whole lines are read, and `stop` is a typed line.
#[cfg(not(unix))]
#[derive(Debug)]
pub(super) struct Keyboard;

#[cfg(not(unix))]
impl Keyboard {
    /// Returns `None`.
    pub(super) fn take() -> Option<Self> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::{Editor, Event};

    fn lines(events: &[Event]) -> Vec<&str> {
        let mut lines = Vec::new();
        for event in events {
            if let Event::Line(line) = event {
                lines.push(line.as_str());
            }
        }
        lines
    }

    fn stops(events: &[Event]) -> usize {
        events.iter().filter(|event| **event == Event::Stop).count()
    }

    #[test]
    fn escape_stops_anywhere_and_space_on_an_empty_line() {
        let mut editor = Editor::default();
        assert_eq!(stops(&editor.take(b"\x1b")), 1);
        assert_eq!(stops(&editor.take(b" ")), 1);
        // Two quick presses may arrive in one read.
        assert_eq!((stops(&editor.take(b"  ")), stops(&editor.take(b"\x1b\x1b"))), (2, 2));
        // Within a line, space is a character, and Esc stops.
        let mut all = Vec::new();
        b"jog 1 2".iter().for_each(|byte| all.extend(editor.take(&[*byte])));
        assert_eq!(stops(&all), 0);
        assert_eq!(stops(&editor.take(b"\x1b")), 1);
        assert_eq!(lines(&editor.take(b"\n")), ["jog 1 2"]);
    }

    #[test]
    fn arrow_keys_and_pasted_lines_do_not_stop() {
        let mut editor = Editor::default();
        assert_eq!(editor.take(b"\x1b[A"), []);
        assert_eq!(editor.take(b"\x1b[1;5C"), []);
        let pasted = editor.take(b"  home\n confirm\narm\n");
        assert_eq!((stops(&pasted), lines(&pasted)), (0, vec!["home", "confirm", "arm"]));
    }

    #[test]
    fn what_is_entered_was_shown() {
        let mut editor = Editor::default();
        let shown = |events: &[Event]| {
            let typed = events
                .iter()
                .rev()
                .find_map(|event| if let Event::Typed(line) = event { Some(line.clone()) } else { None });
            typed.unwrap_or_default()
        };
        // Half of a character is not shown; a byte that is no character is.
        assert_eq!(shown(&editor.take("h\u{e9}".as_bytes().get(..2).unwrap())), "h");
        assert_eq!(shown(&editor.take(&[0xA9])), "h\u{e9}");
        assert_eq!(shown(&editor.take(&[0xFF, b'x'])), "h\u{e9}\u{fffd}x");
        assert_eq!(lines(&editor.take(b"\n")), ["h\u{e9}\u{fffd}x"]);
    }

    #[test]
    fn a_line_is_edited() {
        let mut editor = Editor::default();
        let mut all = editor.take("hé\x7f\x7f".as_bytes());
        all.extend(editor.take(b"arx\x7fm\r"));
        assert_eq!(lines(&all), ["arm"]);
        let mut all = editor.take(b"goto\x15home\n");
        assert_eq!(lines(&all), ["home"]);
        all = editor.take(&[4]);
        assert_eq!(all, [Event::End]);
    }
}
