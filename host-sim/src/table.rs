//! Tables in a terminal.

use comfy_table::{CellAlignment, Row, Table, presets};

/// A table whose first columns are words and the others numbers.
pub(crate) fn table(head: impl Into<Row>, words: usize) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(head);
    for column in table.column_iter_mut().skip(words) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
