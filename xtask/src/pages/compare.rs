//! Comparison of shown and printed output, with times and paths masked.

/// Placeholder in a page for any number of lines, including none.
pub(super) const ANY_LINES: &str = "...";

/// Lines of a typed session after which positions depend on the moment at which the person acted: a stop in a motion, a cut cable.
const IN_A_MOTION: [&str; 2] = ["(Esc)", "> cut "];

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
/// folder of a file that is deleted at once.
fn path(word: &str) -> String {
    let word = word.find("target/chip/").map_or(word, |at| &word[at..]);
    let is_hash = |part: &str| part.len() == 8 && part.bytes().all(|byte| byte.is_ascii_hexdigit());
    let is_process = |part: &str| word.contains("newtau-run-") && part.parse::<u32>().is_ok();
    let masked = word.split('-').map(|part| match part {
        part if is_hash(part) => "HASH",
        part if is_process(part) => "NUMBER",
        part => part,
    });
    masked.collect::<Vec<_>>().join("-")
}

/// Difference between shown and printed output; `None` if all lines agree. Only `...` stands for lines that are not shown, also at both ends.
pub(super) fn difference(shown: &str, printed: &str, masked: Masked) -> Option<String> {
    let lines = |text| str::lines(text).map(|line| masked.line(line)).collect::<Vec<_>>();
    compared(&lines(shown), &lines(printed), |shown, printed| shown == printed)
}

/// Difference between a typed session and what remained on its screen, where the typed lines are seen, too, but no keys and pauses.
///
/// With `paced`, simulated time follows the clock, so the number of a tick depends on the person who types; after an action in a motion, positions,
/// torques and the duration of the next motion do, too. These numbers are masked.
pub(super) fn difference_typed(shown: &str, printed: &str, paced: bool) -> Option<String> {
    let mut in_a_motion = false;
    let masked = |line: &str| {
        in_a_motion |= IN_A_MOTION.iter().any(|start| line.starts_with(start));
        let of_position = line.starts_with("  ") || line.contains(": running; ");
        let depends = line.starts_with("tick ") || in_a_motion && of_position;
        if paced && depends { digits(line) } else { line.trim_end().to_owned() }
    };
    let shown: Vec<_> = shown.lines().map(masked).filter(|line| !line.starts_with('(')).collect();
    // A prompt at which nothing was typed.
    let printed: Vec<_> = printed.lines().map(|line| line.trim_end().to_owned()).filter(|line| line != ">").collect();
    compared(&shown, &printed, |shown, printed| shown == printed || paced && shown == digits(printed))
}

/// The first part without `...` that is not printed in its place: the first at the start, the last at the end, the others in their order.
fn compared(shown: &[String], printed: &[String], same: impl Fn(&str, &str) -> bool) -> Option<String> {
    let agreeing = |part: &[String], rest: &[String]| part.iter().zip(rest).take_while(|(a, b)| same(a, b)).count();
    let parts: Vec<_> = shown.split(|line| line == ANY_LINES).collect();
    let mut rest = printed;
    for (index, part) in parts.iter().enumerate() {
        let latest = rest.len().saturating_sub(part.len());
        let earliest = if index + 1 == parts.len() { latest } else { 0 };
        let latest = if index == 0 { 0 } else { latest };
        let Some(at) = (earliest..=latest).find(|&at| agreeing(part, &rest[at..]) == part.len()) else {
            // Compare from the place where most lines agree.
            let most = (0..rest.len()).map(|at| agreeing(part, &rest[at..])).max().unwrap_or_default();
            return Some(told(part.get(most), rest));
        };
        rest = &rest[at + part.len()..];
    }
    None
}

/// The line with one `#` for each number, and without its blanks, which depend on the length of numbers.
fn digits(line: &str) -> String {
    let number = |word: &str| word.trim_end_matches([',', ':']).parse::<f64>().is_ok();
    line.split_whitespace().map(|word| if number(word) { "#" } else { word }).collect::<Vec<_>>().join(" ")
}

/// The first shown line that is not printed, and the printed line with which most of its start agrees.
fn told(missing: Option<&String>, rest: &[String]) -> String {
    let line = |line: Option<&String>| line.map_or("nothing", String::as_str).to_owned();
    let Some(missing) = missing else {
        let (first, last) = (line(rest.first()), line(rest.last()));
        return format!("  lines that are not shown need `...`\n  first    {first}\n  last     {last}");
    };
    let common = |line: &str| line.chars().zip(missing.chars()).take_while(|(a, b)| a == b).count();
    format!("  shown    {missing}\n  nearest  {}", line(rest.iter().max_by_key(|line| common(line))))
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
    fn dots_stand_for_any_lines() {
        assert!(
            agrees("head\n...\nend\n") && agrees("...\nparity  0\n...") && agrees("head\n...") && agrees("...\nend")
        );
        assert!(!agrees("...\nparity  1\n...") && !agrees("...\nparity  0\n...\nhead\n..."), "in another order");
    }

    #[test]
    fn lines_at_the_ends_are_left_out_only_with_dots() {
        for cut in [
            "head",
            "end",
            "parity  0",
            "parity  0\n...",
            "...\nparity  0",
            "...\nhead",
            "end\n...",
            "head\n...\nparity  0",
        ] {
            assert!(!agrees(cut), "{cut}");
        }
        let told = difference("parity  0", PRINTED, Masked::Times).unwrap();
        assert_eq!(told, "  lines that are not shown need `...`\n  first    head\n  last     end");
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
        let shown = "> run\nrun: running\n(Esc)\nstop: sent\n> status\ntick 5629, 5.629 s\n  shoulder   -0.70237 rad   13.479 N m\n";
        let printed =
            "> run\nrun: running\nstop: sent\n> status\ntick 31, 0.031 s\n  shoulder   -0.1 rad   3.479 N m\n> \n";
        let agrees = |shown: &str, printed: &str| difference_typed(shown, printed, true).is_none();
        assert!(agrees(shown, printed), "{:?}", difference_typed(shown, printed, true));
        for (right, wrong) in
            [("sent", "lost"), ("shoulder", "elbow"), ("> status", "> get"), ("> status\n", ""), ("> \n", "> quit")]
        {
            assert!(!agrees(shown, &printed.replace(right, wrong)), "{right} became {wrong}");
        }
        assert!(difference_typed(shown, printed, false).is_some(), "time that does not follow the clock");
    }

    #[test]
    fn positions_before_an_action_in_a_motion_are_compared() {
        let printed = "> status\ntick 31, 0.031 s\n  shoulder   0.5 rad\n> cut host\n  shoulder   0.4 rad\npark: running; 3.25 s\n";
        let agrees = |shown: &str| difference_typed(shown, printed, true).is_none();
        assert!(
            agrees(&printed.replace("31", "32"))
                && agrees(&printed.replace("0.4", "0.3"))
                && agrees(&printed.replace("3.25", "3.24"))
        );
        assert!(!agrees(&printed.replace("0.5", "0.6")));
    }

    #[test]
    fn the_first_line_that_differs_is_reported() {
        let told = difference("...\ntime per tick  1\nparity  1\n...", PRINTED, Masked::Times);
        assert_eq!(told.as_deref(), Some("  shown    parity  1\n  nearest  parity  0"));
    }
}
