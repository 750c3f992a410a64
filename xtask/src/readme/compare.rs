//! Comparison of shown and printed output, with times masked.

/// Placeholder in a page for any number of lines, including none.
const ANY_LINES: &str = "...";

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
    fn line(self, line: &str) -> &str {
        self.names().iter().find(|&&name| line.starts_with(name)).map_or(line.trim_end(), |&name| name)
    }
}

/// Difference between shown and printed output; `None` if both agree.
pub(super) fn difference(shown: &str, printed: &str, masked: Masked) -> Option<String> {
    let lines = |text| str::lines(text).map(|line| masked.line(line)).collect::<Vec<_>>();
    let (shown, printed) = (lines(shown), lines(printed));
    let mut parts = shown.split(|&line| line == ANY_LINES);
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = printed.strip_prefix(first) else {
        return Some(told(first, &printed));
    };
    let mut last = first;
    let mut anywhere = false;
    for part in parts {
        let Some(at) = (0..=rest.len()).find(|&at| rest[at..].starts_with(part)) else {
            return Some(told(part, rest));
        };
        rest = &rest[at + part.len()..];
        (last, anywhere) = (part, true);
    }
    // After the last `...`, the shown lines must be the end.
    let ends = if anywhere { printed.ends_with(last) } else { rest.is_empty() };
    (!ends).then(|| told(last, &printed))
}

/// Both texts, starting at the first line that differs.
fn told(shown: &[&str], printed: &[&str]) -> String {
    let same = shown.iter().zip(printed).take_while(|(shown, printed)| shown == printed).count();
    let line = |lines: &[&str]| lines.get(same).map_or("nothing", |&line| line).to_owned();
    format!("  shown    {}\n  printed  {}", line(shown), line(printed))
}

#[cfg(test)]
mod tests {
    use super::{Masked, difference};

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
        assert!(!agrees("head\n") && !agrees(&format!("{PRINTED}more\n")) && !agrees(""));
    }

    #[test]
    fn instructions_of_another_compiler_may_differ_too() {
        let shown = PRINTED.replace("1353", "1354");
        assert_eq!(difference(&shown, PRINTED, Masked::TimesAndInstructions), None);
    }

    #[test]
    fn dots_stand_for_any_lines() {
        assert!(agrees("...\nparity  0\n...\n") && agrees("head\n...\n") && agrees("...\nend\n"));
        assert!(agrees("...\ninstructions        1353 to 1353 per tick\nparity  0\n...\n"));
        assert!(!agrees("...\nparity  1\n...\n") && !agrees("...\nparity  0\n") && !agrees("parity  0\n...\n"));
        assert!(!agrees("...\nparity  0\n...\nhead\n...\n"), "in another order");
    }

    #[test]
    fn the_first_line_that_differs_is_reported() {
        let told = difference("head\ntime per tick  1\nother\n", PRINTED, Masked::Times);
        assert_eq!(told.as_deref(), Some("  shown    other\n  printed  instructions        1353 to 1353 per tick"));
    }
}
