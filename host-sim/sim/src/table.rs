//! Tables in a terminal and in Markdown.

use comfy_table::{CellAlignment, Row, Table, presets};

/// A table in Markdown.
pub fn markdown<S: AsRef<str>>(head: &[S], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let head: Vec<&str> = head.iter().map(AsRef::as_ref).collect();
    let rows = rows.into_iter().map(|row| format!("| {} |\n", row.join(" | ")));
    format!("| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len())) + &rows.collect::<String>()
}

/// A table with a head. Its first `words` columns are text on the left; the others are numbers on the right.
pub fn table(head: impl Into<Row>, words: usize) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(head);
    for column in table.column_iter_mut().skip(words) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
