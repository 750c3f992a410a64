//! The program `newtau`, run in a folder or at a terminal.

use crate::process::{cargo, root, run, target_directory};
use anyhow::{Context as _, Result};
use std::io::Write as _;
use std::num::NonZeroU16;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

/// Time between two lines that are typed. `home` and `jog` are done before the next line.
const BETWEEN_LINES: Duration = Duration::from_millis(600);

/// Time after which a session that waits for a line that no page types is ended, s. Its exit code is then 124.
const LONGEST: u32 = 120;

/// Size of a terminal that keeps a whole session.
const ROWS: NonZeroU16 = NonZeroU16::new(1000).unwrap();
const COLUMNS: NonZeroU16 = NonZeroU16::new(400).unwrap();

/// The program, as it was built with the tests.
pub(super) struct Program {
    path: PathBuf,
}

/// A program that has ended.
pub(super) struct Ended {
    pub(super) code: Option<i32>,
    /// Its standard output, then its standard error.
    pub(super) printed: String,
}

impl Program {
    /// Builds it in the profile of the tests: times are not compared.
    pub(super) fn build() -> Result<Self> {
        run(cargo(["build", "--package", "host-sim", "--locked"]).current_dir(root()))?;
        Ok(Self { path: target_directory().join("debug/newtau") })
    }

    fn command(&self, call: &str) -> Result<Command> {
        let words = shlex::split(call).with_context(|| format!("an open quote in {call}"))?;
        let mut command = Command::new(&self.path);
        command.args(words);
        Ok(command)
    }

    /// Runs a command in a folder, without input.
    pub(super) fn run(&self, call: &str, folder: &Path) -> Result<Ended> {
        let mut command = self.command(call)?;
        let output = command.current_dir(folder).stdin(Stdio::null()).output().context("cannot start newtau")?;
        let printed = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
        Ok(Ended { code: output.status.code(), printed })
    }

    /// Runs a command at a terminal of its own, types what the page shows after `> `, and presses the keys that it shows in brackets.
    pub(super) fn typed(&self, call: &str, folder: &Path, shown: &[String]) -> Result<Ended> {
        // `script`, a part of every Debian, makes the terminal.
        let line = format!(
            "stty rows {ROWS} cols {COLUMNS}; exec timeout --foreground {LONGEST} {} {call}",
            self.path.display()
        );
        let mut child = Command::new("script")
            .args(["--quiet", "--return", "--command", &line, "/dev/null"])
            .current_dir(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .context("cannot start `script`, which makes a terminal")?;
        let mut keys = child.stdin.take().context("no standard input")?;
        let typed = shown.iter().flat_map(|block| block.lines()).filter_map(typed);
        // A session that the page leaves open: Ctrl-D ends it, and `y` accepts that joints sink.
        let typed: Vec<Typed> =
            typed.chain(["\u{4}", "y\r", "\u{4}"].map(|keys| Typed::Keys(keys.to_owned()))).collect();
        let typist = thread::spawn(move || {
            for one in typed {
                thread::sleep(BETWEEN_LINES);
                let written = match one {
                    Typed::Keys(keys_of) => keys.write_all(keys_of.as_bytes()).and_then(|()| keys.flush()),
                    Typed::Pause(time) => {
                        thread::sleep(time);
                        Ok(())
                    }
                };
                // A program that has ended reads no more; its exit code and output tell.
                if written.is_err() {
                    break;
                }
            }
            thread::sleep(BETWEEN_LINES);
        });
        let output = child.wait_with_output()?;
        let _ = typist.join();
        Ok(Ended { code: output.status.code(), printed: on_the_screen(&output.stdout) })
    }
}

/// Action of a person at the keyboard.
#[derive(Debug, PartialEq, Eq)]
enum Typed {
    Keys(String),
    Pause(Duration),
}

/// The action at a shown line: type what is after `> `, press the key `(Esc)`, or wait, `(3 s)`.
fn typed(line: &str) -> Option<Typed> {
    if let Some(line) = line.strip_prefix("> ") {
        return Some(Typed::Keys(format!("{line}\r")));
    }
    match line.strip_prefix('(')?.strip_suffix(')')? {
        "Esc" => Some(Typed::Keys("\u{1b}".to_owned())),
        time => time.strip_suffix(" s")?.parse().ok().map(|seconds| Typed::Pause(Duration::from_secs(seconds))),
    }
}

/// The lines that stay on the screen of a terminal with many rows.
fn on_the_screen(bytes: &[u8]) -> String {
    let mut terminal = vt100::Parser::new(ROWS, COLUMNS, 0);
    terminal.process(bytes);
    terminal.screen().contents()
}

#[cfg(test)]
mod tests {
    use super::{Typed, on_the_screen, typed};
    use std::time::Duration;

    #[test]
    fn a_terminal_keeps_what_was_not_written_over() {
        let bytes = b"> arm\r\ntick 1 \r\x1b[2Ktick 2 \r\x1b[2Karm: armed\r\n> x\r\n\x1b[1A\x1b[2Kdone\r\n";
        assert_eq!(on_the_screen(bytes), "> arm\narm: armed\ndone");
    }

    #[test]
    fn shown_lines_are_typed_and_keys_pressed() {
        assert_eq!(typed("> arm"), Some(Typed::Keys("arm\r".to_owned())));
        assert_eq!(typed("(Esc)"), Some(Typed::Keys("\u{1b}".to_owned())));
        assert_eq!(typed("(3 s)"), Some(Typed::Pause(Duration::from_secs(3))));
        assert_eq!((typed("arm: armed"), typed("(no key)")), (None, None));
    }
}
