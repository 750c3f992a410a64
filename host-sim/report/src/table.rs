//! Tables.

use crate::escape::html;
use std::fmt::Write as _;

/// Meaning of a part of a cell, shown by its colour. The text says the same, for readers who do not see the colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Nothing happened.
    Quiet,
    /// The request was carried out.
    Good,
    /// A limit acted.
    Caution,
    /// Something was stopped.
    Stop,
}

impl Tone {
    fn class(self) -> &'static str {
        match self {
            Self::Quiet => "tone quiet",
            Self::Good => "tone good",
            Self::Caution => "tone caution",
            Self::Stop => "tone stop",
        }
    }
}

/// A cell: the text shown, and the exact number if it represents one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// Text shown.
    pub text: String,
    /// Exact number that the text represents; `None` if it represents none.
    pub exact: Option<f64>,
    /// True to highlight the cell, for a failure or a limit.
    pub warns: bool,
    /// Command that reproduces the cell's result, on hover; a click copies it.
    pub command: Option<String>,
    /// Coloured parts, one below the other, shown in place of the text.
    pub parts: Vec<(Tone, String)>,
}

impl Cell {
    /// Creates a cell whose text represents a number.
    #[must_use]
    pub fn number(text: impl Into<String>, exact: f64) -> Self {
        Self { text: text.into(), exact: Some(exact), ..Self::default() }
    }

    /// Returns the cell, highlighted if `warns`.
    #[must_use]
    pub fn warning(self, warns: bool) -> Self {
        Self { warns, ..self }
    }

    /// Returns the cell with the command that reproduces its result.
    #[must_use]
    pub fn told(self, command: impl Into<String>) -> Self {
        Self { command: Some(command.into()), ..self }
    }

    /// Creates a cell of coloured parts, one below the other.
    #[must_use]
    pub fn coloured(parts: Vec<(Tone, String)>) -> Self {
        let texts: Vec<_> = parts.iter().map(|(_, text)| text.as_str()).collect();
        Self { text: texts.join(", "), parts, ..Self::default() }
    }

    /// Content of the cell. A command can be reached by pointer and keyboard, as for points of a figure.
    fn content(&self) -> String {
        let part = |(tone, text): &(Tone, String)| format!("<span class=\"{}\">{}</span>", tone.class(), html(text));
        let parts: String = self.parts.iter().map(part).collect();
        let text = if parts.is_empty() { html(&self.text) } else { parts };
        self.command.as_deref().map(html).map_or(text.clone(), |command| {
            format!("<span tabindex=\"0\" role=\"button\" title=\"{command}\" data-command=\"{command}\">{text}</span>")
        })
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), ..Self::default() }
    }
}

/// Longest text that is kept on one line, characters.
const LINE_MAX: usize = 28;

/// Alignment of a column's cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    /// Numbers, right-aligned.
    Numbers,
    /// One or two words, left-aligned.
    Words,
    /// Sentences or commands, left-aligned, broken into lines.
    Prose,
}

impl Column {
    /// Class attribute of a cell.
    fn class(self, warns: bool) -> String {
        let names = [
            warns.then_some("warns"),
            match self {
                Self::Numbers => None,
                Self::Words => Some("words"),
                Self::Prose => Some("prose"),
            },
        ];
        let names: Vec<&str> = names.into_iter().flatten().collect();
        if names.is_empty() { String::new() } else { format!(" class=\"{}\"", names.join(" ")) }
    }
}

/// A table with a caption. The first column names the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    caption: String,
    head: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Creates a table without rows.
    #[must_use]
    pub fn new<S: AsRef<str>>(caption: impl Into<String>, head: &[S]) -> Self {
        let head = head.iter().map(|name| name.as_ref().to_owned()).collect();
        Self { caption: caption.into(), head, rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: Vec<Cell>) {
        self.rows.push(cells);
    }

    /// Alignment of a column, derived from its contents. The first column, with the rows' names, has its own style.
    fn column(&self, index: usize) -> Column {
        let cells = || self.rows.iter().filter_map(|row| row.get(index));
        if index == 0 {
            return Column::Numbers;
        }
        if cells().any(|cell| cell.text.chars().count() > LINE_MAX) {
            return Column::Prose;
        }
        let worded = |cell: &Cell| cell.exact.is_none() && cell.text.starts_with(char::is_alphabetic);
        let filled = || cells().filter(|cell| !cell.text.is_empty());
        if filled().next().is_some() && filled().all(worded) { Column::Words } else { Column::Numbers }
    }

    pub(crate) fn write(&self, out: &mut String) {
        let _ = write!(
            out,
            "<div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{0}\"><table><caption>{0}</caption><thead><tr>",
            html(&self.caption)
        );
        let count = self.rows.iter().map(Vec::len).max().unwrap_or(0).max(self.head.len());
        let columns: Vec<Column> = (0..count).map(|index| self.column(index)).collect();
        for (name, column) in self.head.iter().zip(&columns) {
            let _ = write!(out, "<th scope=\"col\"{}>{}</th>", column.class(false), html(name));
        }
        out.push_str("</tr></thead><tbody>\n");
        for row in &self.rows {
            out.push_str("<tr>");
            for (index, (cell, column)) in row.iter().zip(&columns).enumerate() {
                let tag = if index == 0 { "th scope=\"row\"" } else { "td" };
                let class = column.class(cell.warns);
                let exact = cell.exact.map_or(String::new(), |x| format!(" data-exact=\"{x:?}\" title=\"{x:?}\""));
                let _ = write!(out, "<{tag}{class}{exact}>{}</{}>", cell.content(), &tag[..2]);
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</tbody></table></div>\n");
    }
}

#[cfg(test)]
mod tests {
    use super::{Cell, Table, Tone};

    #[test]
    fn sentences_stand_in_lines_at_the_left_and_numbers_at_the_right() {
        let mut table = Table::new("cells", &["cell", "done", "kind", "found"]);
        let done = "every joint is given a mass of nothing at all";
        table.row(vec!["one".into(), done.into(), "requirement".into(), Cell::number("1.2", 1.2)]);
        table.row(vec!["two".into(), "short".into(), "".into(), "none".into()]);
        let mut out = String::new();
        table.write(&mut out);
        for expected in [
            "<th scope=\"col\">cell</th><th scope=\"col\" class=\"prose\">done</th>",
            "<td class=\"prose\">short</td>",
            "<th scope=\"col\" class=\"words\">kind</th>",
            "<td>none</td>",
        ] {
            assert!(out.contains(expected), "{expected}: {out}");
        }
    }

    #[test]
    fn a_cell_hands_its_command_to_pointer_and_keyboard() {
        let mut table = Table::new("worst", &["run"]);
        table.row(vec![Cell::from("54").told("newtau sweep 'a b' --replay 54")]);
        let mut out = String::new();
        table.write(&mut out);
        let command = "newtau sweep &#39;a b&#39; --replay 54";
        assert!(out.contains(&format!("title=\"{command}\" data-command=\"{command}\">54</span></th>")), "{out}");
        assert!(out.contains("tabindex=\"0\" role=\"button\""), "{out}");
    }

    #[test]
    fn coloured_parts_of_a_cell_are_words_too() {
        let mut table = Table::new("outcomes", &["fault", "idle"]);
        let parts = vec![(Tone::Stop, "fault 9: 4".to_owned()), (Tone::Quiet, "goes on: 1".to_owned())];
        table.row(vec!["nothing".into(), Cell::coloured(parts)]);
        let mut out = String::new();
        table.write(&mut out);
        let cell = "<span class=\"tone stop\">fault 9: 4</span><span class=\"tone quiet\">goes on: 1</span></td>";
        assert!(out.contains(cell), "{out}");
    }

    #[test]
    fn a_cell_keeps_the_exact_number_behind_its_text() {
        let mut table = Table::new("a < b", &["joint", "error"]);
        table.row(vec!["waist".into(), Cell::number("1.23 mrad", 0.001_234_5).warning(true)]);
        let mut out = String::new();
        table.write(&mut out);
        assert!(out.contains("<caption>a &lt; b</caption>"), "{out}");
        assert!(out.contains("<th scope=\"row\">waist</th>"), "{out}");
        assert!(
            out.contains("<td class=\"warns\" data-exact=\"0.0012345\" title=\"0.0012345\">1.23 mrad</td>"),
            "{out}"
        );
    }
}
