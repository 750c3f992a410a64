//! Tables in Markdown.

use std::fmt::Display;

/// A table: the head, and rows of cells.
pub(crate) struct Table(pub(crate) String);

impl Table {
    pub(crate) fn new(head: &[&str]) -> Self {
        let line = |cells: Vec<&str>| format!("| {} |\n", cells.join(" | "));
        Self(line(head.to_vec()) + &"|---".repeat(head.len()) + "|\n")
    }

    /// Adds a row of anything that can be printed.
    pub(crate) fn put(&mut self, cells: &[&dyn Display]) {
        self.row(&cells.iter().map(ToString::to_string).collect::<Vec<_>>());
    }

    pub(crate) fn row(&mut self, cells: &[String]) {
        self.0 += &format!("| {} |\n", cells.join(" | "));
    }
}

/// Formats a number as `12,345`.
pub(crate) fn thousands(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::thousands;

    #[test]
    fn thousands_are_set_apart() {
        let all = [0, 12, 999, 1000, 12_345, 1_234_567].map(thousands);
        assert_eq!(all, ["0", "12", "999", "1,000", "12,345", "1,234,567"]);
    }
}
