//! The lines of the program on the chip: `micro begin`, `micro NAME COUNT` for each stretch, `micro end ROWS`.

/// A stretch and its count: instructions in the emulator, cycles on a board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct StretchRow {
    pub(super) name: String,
    pub(super) count: u64,
}

/// Rows of the first whole report in a text; `None` if there is none.
pub(super) fn rows(text: &str) -> Option<Vec<StretchRow>> {
    let mut report = Report::default();
    text.lines().find_map(|line| report.line(line))
}

/// Assembles a report from its lines.
#[derive(Debug, Default)]
pub(super) struct Report {
    /// Rows since the beginning of a report; `None` before it, and after a line that cannot be read.
    rows: Option<Vec<StretchRow>>,
}

impl Report {
    /// Adds a line. Returns the rows at the end of a complete report. Lines from other sources are ignored. A line of the program that cannot be read
    /// invalidates the report, and reading resumes with the next one.
    pub(super) fn line(&mut self, line: &str) -> Option<Vec<StretchRow>> {
        let mut words = line.split_ascii_whitespace();
        if words.next() != Some("micro") {
            return None;
        }
        match (words.next(), words.next().map(str::parse::<u64>), words.next()) {
            (Some("begin"), None, None) => self.rows = Some(Vec::new()),
            (Some("end"), Some(Ok(count)), None) => {
                return self.rows.take().filter(|rows| rows.len() as u64 == count);
            }
            (Some(name), Some(Ok(count)), None) => {
                if let Some(rows) = &mut self.rows {
                    rows.push(StretchRow { name: name.to_owned(), count });
                }
            }
            _ => self.rows = None,
        }
        None
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{StretchRow, rows};

    #[test]
    fn the_first_whole_report_counts() {
        let row = |name: &str, count| StretchRow { name: name.into(), count };
        let expected = Some(vec![row("a", 1), row("b", 23)]);
        let whole = "micro begin\nmicro a 1\r\nqemu: warning\nmicro b 23\nmicro end 2\n";
        assert_eq!(rows(whole), expected);
        // Reading that starts in the middle, a lost line, and a line with a broken byte.
        for before in ["ro b 23\nmicro end 2\n", "micro begin\nmicro b 23\nmicro end 2\n", "micro begin\nmicro a 1x\n"]
        {
            assert_eq!(rows(before), None, "{before}");
            assert_eq!(rows(&(before.to_owned() + whole)), expected, "{before}");
        }
    }
}
