//! Fields of a line of text: separators, numbers, lists.

use csv::StringRecord;

/// Parses a number with a decimal point or a decimal comma; `None` if it is not a finite number.
pub(super) fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    let number = text.parse::<f64>().ok().or_else(|| {
        let comma = text.matches(',').count() == 1 && !text.contains('.');
        let plain = text.replace('−', "-").replace(',', if comma { "." } else { "," });
        plain.parse().ok()
    });
    number.filter(|x: &f64| x.is_finite())
}

/// True if a field contains no reading.
pub(super) fn is_missing(text: &str) -> bool {
    matches!(text.trim().to_lowercase().as_str(), "" | "nan" | "null" | "none" | "na" | "n/a")
}

/// Separator of fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Separator {
    byte: u8,
    /// Its name in messages.
    pub(super) name: &'static str,
}

impl Separator {
    pub(super) const SEMICOLON: Self = Self { byte: b';', name: "semicolons" };
    pub(super) const TAB: Self = Self { byte: b'\t', name: "tabs" };
    pub(super) const COMMA: Self = Self { byte: b',', name: "commas" };
    /// Blanks are replaced by tabs before the text is read.
    pub(super) const BLANKS: Self = Self { byte: b'\t', name: "blanks" };
    const BAR: Self = Self { byte: b'|', name: "vertical bars" };
    pub(super) const ALL: [Self; 5] = [Self::SEMICOLON, Self::TAB, Self::COMMA, Self::BLANKS, Self::BAR];

    pub(super) fn fields(self, line: &str) -> Vec<String> {
        if self == Self::BLANKS {
            return between_blanks(line, false);
        }
        self.rows(line).next().map_or_else(Vec::new, |(_, row)| row.iter().map(str::to_owned).collect())
    }

    /// Line and fields of each row of a text, in which blanks have been replaced by tabs.
    pub(super) fn rows(self, text: &str) -> impl Iterator<Item = (u64, StringRecord)> {
        let reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .delimiter(self.byte)
            .from_reader(text.as_bytes());
        // Reading from memory cannot fail, and the text is valid UTF-8.
        let rows = reader.into_records().filter_map(Result::ok);
        rows.map(|row| (row.position().map_or(0, csv::Position::line), row))
    }
}

/// Splits at blanks that are not inside brackets or quotes. With `glue`, a bracket belongs to the word before it.
pub(super) fn between_blanks(line: &str, glue: bool) -> Vec<String> {
    let mut fields: Vec<String> = Vec::new();
    let (mut depth, mut quoted, mut open) = (0_i32, false, false);
    for c in line.trim().chars() {
        match c {
            '"' => {
                quoted = !quoted;
                if !open {
                    fields.push(String::new());
                    open = true;
                }
                continue;
            }
            '[' | '(' => {
                open |= glue && !fields.is_empty();
                depth += 1;
            }
            ']' | ')' => depth -= 1,
            _ => {}
        }
        if c.is_whitespace() && depth <= 0 && !quoted {
            open = false;
            continue;
        }
        if !open {
            fields.push(String::new());
            open = true;
        }
        if let Some(field) = fields.last_mut() {
            field.push(c);
        }
    }
    fields
}

/// Text of a comment line, without its marker.
pub(super) fn comment(line: &str) -> Option<&str> {
    let line = line.trim_start();
    ["#", "%", "//"]
        .iter()
        .find_map(|mark| line.strip_prefix(mark))
        .map(|rest| rest.trim_start_matches(['#', '%', '/']))
}

/// Counts the numbers of a row; a list counts each of its numbers.
pub(super) fn numbers(fields: &[String]) -> usize {
    let count = |field: &String| match is_list(field) {
        true => elements(field).iter().filter(|field| number(field).is_some()).count(),
        false => usize::from(number(field).is_some()),
    };
    fields.iter().map(count).sum()
}

/// True for `[0.1, 0.2]` and `(0.1, 0.2)`.
pub(super) fn is_list(field: &str) -> bool {
    let ends = field.chars().next().zip(field.chars().next_back());
    matches!(ends, Some(('[', ']') | ('(', ')'))) && elements(field).len() > 1
}

/// Elements of a list in one field.
pub(super) fn elements(field: &str) -> Vec<String> {
    let inner = field.trim_matches(['[', ']', '(', ')']);
    let parts = inner.split(|c: char| c == ',' || c == ';' || c.is_whitespace());
    let bare = parts.map(|part| part.trim_matches(['\'', '"', ' ']).to_owned());
    bare.filter(|part| !part.is_empty()).collect()
}
