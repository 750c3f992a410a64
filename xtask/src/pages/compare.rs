//! Comparison of shown and printed output, with times and paths masked.

/// Placeholder in a page for any number of lines, including none.
const ANY_LINES: &str = "...";

/// Marks in a typed session a line at which something is done, and that is not printed.
const DONE: [&str; 2] = ["> ", "("];

/// Lines of a summary of which only the name must agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Masked {
    /// Times, which depend on this machine.
    Times,
    /// Times, and the chip's instruction counts, which depend on the compiler.
    TimesAndInstructions,
}

impl Masked {
    fn names(self) -> &'static [&'static str] {
        match self {
            Self::Times => &["time per tick", "faster than real"],
            Self::TimesAndInstructions => &["time per tick", "faster than real", "instructions"],
        }
    }

    /// The line without the part that may differ.
    fn line(self, line: &str) -> String {
        if let Some(&name) = self.names().iter().find(|&&name| line.starts_with(name)) {
            return name.to_owned();
        }
        // A firmware's file is named after its content; which folder it is in depends on the machine.
        line.trim_end().split(' ').map(path).collect::<Vec<_>>().join(" ")
    }
}

/// The word, without the folders above `target/chip`, with `HASH` in place of a hash between hyphens, and with `NUMBER` in place of the process in the
/// name of a file that is deleted at once.
fn path(word: &str) -> String {
    let word = word.find("target/chip/").map_or(word, |at| &word[at..]);
    let is_hash = |part: &str| part.len() == 8 && part.bytes().all(|byte| byte.is_ascii_hexdigit());
    let is_process = |part: &str| part.strip_suffix(".bin").is_some_and(|id| id.parse::<u32>().is_ok());
    let masked = word.split('-').map(|part| match part {
        part if is_hash(part) => "HASH",
        part if is_process(part) => "NUMBER.bin",
        part => part,
    });
    masked.collect::<Vec<_>>().join("-")
}

/// Difference between shown and printed output; `None` if the shown lines are among the printed ones, in their order. Shown lines without `...` between
/// them are printed one directly after the other.
pub(super) fn difference(shown: &str, printed: &str, masked: Masked) -> Option<String> {
    let lines = |text| str::lines(text).map(|line| masked.line(line)).collect::<Vec<_>>();
    let (shown, printed) = (lines(shown), lines(printed));
    let mut rest = &printed[..];
    for part in shown.split(|line| line == ANY_LINES) {
        let Some(at) = (0..=rest.len()).find(|&at| rest[at..].starts_with(part)) else {
            return Some(told(part, rest));
        };
        rest = &rest[at + part.len()..];
    }
    None
}

/// Difference between a typed session and what was printed at its terminal. How far the arm has come when a key is pressed depends on the person, so the
/// digits of lines that report a tick are masked.
pub(super) fn difference_typed(shown: &str, printed: &str) -> Option<String> {
    let session = |text: &str| {
        let lines = text.lines().filter(|line| !DONE.iter().any(|start| line.starts_with(start)));
        let masked = lines
            .map(|line| if line.starts_with("tick ") || line.starts_with("  ") { digits(line) } else { line.into() });
        masked.flat_map(|line| [line, "\n".to_owned()]).collect::<String>()
    };
    difference(&session(shown), &session(printed), Masked::Times)
}

/// The line with one `#` for each number, and without its blanks, which depend on the length of numbers.
fn digits(line: &str) -> String {
    let number = |word: &str| word.trim_end_matches([',', ':']).parse::<f64>().is_ok();
    line.split_whitespace().map(|word| if number(word) { "#" } else { word }).collect::<Vec<_>>().join(" ")
}

/// The first shown line that is not printed, and the printed line with which most of its start agrees.
fn told(part: &[String], rest: &[String]) -> String {
    // Compare from the place where most lines agree.
    let agreeing = |at: usize| part.iter().zip(&rest[at..]).take_while(|(shown, printed)| shown == printed).count();
    let same = (0..rest.len()).map(agreeing).max().unwrap_or_default();
    let missing = part.get(same).map_or("nothing", String::as_str);
    let common = |line: &str| line.chars().zip(missing.chars()).take_while(|(a, b)| a == b).count();
    let nearest = rest.iter().max_by_key(|line| common(line)).map_or("nothing", String::as_str);
    format!("  shown    {missing}\n  nearest  {nearest}")
}

#[cfg(test)]
mod tests {
    use super::{Masked, difference, difference_typed};

    const PRINTED: &str =
        "head\ntime per tick       404 ns\ninstructions        1353 to 1353 per tick\nparity  0\nend\n";

    fn agrees(shown: &str) -> bool {
        difference(shown, PRINTED, Masked::Times).is_none()
    }

    #[test]
    fn times_may_differ_and_nothing_else() {
        assert!(agrees(PRINTED));
        assert!(agrees(&PRINTED.replace("404 ns", "2.43 ms")));
        assert!(!agrees(&PRINTED.replace("1353", "1354")));
        assert!(!agrees(&PRINTED.replace("parity  0", "parity  1")));
        assert!(!agrees(&format!("{PRINTED}more\n")) && !agrees("head\nend\n"));
    }

    #[test]
    fn instructions_of_another_compiler_may_differ_too() {
        let shown = PRINTED.replace("1353", "1354");
        assert_eq!(difference(&shown, PRINTED, Masked::TimesAndInstructions), None);
    }

    #[test]
    fn a_part_may_be_shown_and_dots_stand_for_any_lines() {
        assert!(agrees("parity  0\n") && agrees("head\n...\nend\n") && agrees("...\nparity  0\n..."));
        assert!(!agrees("parity  1\n") && !agrees("parity  0\n...\nhead\n"), "in another order");
    }

    #[test]
    fn folders_and_hashes_of_files_may_differ() {
        let printed = "board: /home/me/project/target/chip/move-0a1b2c3d-f405-can.elf";
        let same = |shown| difference(shown, printed, Masked::Times).is_none();
        assert!(same("board: .../target/chip/move-HASH-f405-can.elf"));
        assert!(!same("board: .../target/chip/other-HASH-f405-can.elf") && !same("target/chip/move-HASH-f405-can.elf"));
    }

    #[test]
    fn a_typed_session_may_be_typed_at_another_pace() {
        let shown =
            "> run\nrun: running\n(Esc)\nstop: sent\ntick 5629, 5.629 s\n  shoulder   -0.70237 rad   13.479 N m\n";
        let printed =
            "> run\nrun: running\nstop: sent\nstatus\ntick 31, 0.031 s\n  shoulder   -0.1 rad   3.479 N m\n> \n";
        let differs = |printed: &str| difference_typed(shown, printed).is_some();
        assert!(differs(printed), "an echoed line that the page does not show");
        let printed = printed.replace("\nstatus", "");
        assert!(!differs(&printed), "{:?}", difference_typed(shown, &printed));
        assert!(differs(&printed.replace("sent", "lost")) && differs(&printed.replace("shoulder", "elbow")));
    }

    #[test]
    fn the_first_line_that_differs_is_reported() {
        let told = difference("head\ntime per tick  1\nparity  1\n", PRINTED, Masked::Times);
        assert_eq!(told.as_deref(), Some("  shown    parity  1\n  nearest  parity  0"));
    }
}
