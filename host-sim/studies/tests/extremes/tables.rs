//! The tables of `docs/measured/extremes`, one for each group, and the page that summarises them.

use crate::cell::{Cell, Kind, number};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Groups in the order of the page.
const GROUPS: [&str; 6] = ["masses", "inputs", "integrators", "time", "control", "stability"];

const COLUMNS: [&str; 7] = ["cell", "what is done", "kind", "expected", "found", "share of the bound", "verdict"];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/measured/extremes")
}

/// True if tables and page are to be written again.
pub(crate) fn is_update() -> bool {
    std::env::var_os("UPDATE_EXTREMES").is_some()
}

/// Asserts that a file contains this text; writes it if `UPDATE_EXTREMES` is set.
fn same(path: &Path, text: &str) {
    if is_update() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let found = std::fs::read_to_string(path).unwrap_or_default();
    let command = "UPDATE_EXTREMES=1 cargo nextest run -p studies --test extremes";
    assert_eq!(found, text, "{} is not what was measured: `{command}` writes it", path.display());
}

/// Asserts that the group's table contains these cells.
pub(crate) fn hold(group: &str, cells: &[Cell]) {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(COLUMNS).unwrap();
    for cell in cells {
        let share = cell.share.map(|share| number(share, "")).unwrap_or_default();
        let verdict = cell.reason.as_ref().map_or_else(|| cell.passes().to_owned(), |why| format!("fails: {why}"));
        rows.write_record([&cell.name, &cell.done, cell.kind.name(), &cell.expected, &cell.found, &share, &verdict])
            .unwrap();
    }
    let text = String::from_utf8(rows.into_inner().unwrap()).unwrap();
    same(&folder().join(format!("{group}.csv")), &text);
}

struct Row {
    words: [String; 7],
}

impl Row {
    fn share(&self) -> Option<f64> {
        self.words[5].parse().ok()
    }

    fn fails(&self) -> bool {
        self.words[6].starts_with("fails")
    }

    fn is_record(&self) -> bool {
        self.words[2] == Kind::Record.name()
    }

    fn line(&self, columns: &[usize]) -> String {
        let words: Vec<String> = columns.iter().map(|column| self.words[*column].replace('|', "\\|")).collect();
        format!("| {} |\n", words.join(" | "))
    }
}

fn rows(group: &str) -> Vec<Row> {
    let mut table = csv::Reader::from_path(folder().join(format!("{group}.csv"))).unwrap();
    table.records().map(|row| Row { words: core::array::from_fn(|k| row.as_ref().unwrap()[k].to_owned()) }).collect()
}

/// Number of a group's requirements on the page: those nearest to their bounds.
const SHOWN: usize = 3;

#[test]
fn the_page_sums_up_the_tables() {
    let mut counts = "| group | cells | requirements | records | failing |\n|---|---|---|---|---|\n".to_owned();
    let mut failing = "| group | cell | found | why |\n|---|---|---|---|\n".to_owned();
    let mut near = "| group | cell | expected | found | share of the bound |\n|---|---|---|---|---|\n".to_owned();
    for group in GROUPS {
        let rows = rows(group);
        let count = |of: fn(&Row) -> bool| rows.iter().filter(|row| of(row)).count();
        let (records, failed) = (count(Row::is_record), count(Row::fails));
        let _ = writeln!(
            counts,
            "| [{group}](extremes/{group}.csv) | {} | {} | {records} | {failed} |",
            rows.len(),
            rows.len() - records
        );
        rows.iter().filter(|row| row.fails()).for_each(|row| {
            let line = row.line(&[0, 4, 6]);
            let _ = write!(failing, "| {group} {}", line.replace("fails: ", ""));
        });
        let mut bounded: Vec<&Row> = rows.iter().filter(|row| !row.fails() && row.share().is_some()).collect();
        bounded.sort_by(|a, b| b.share().partial_cmp(&a.share()).unwrap());
        bounded.iter().take(SHOWN).for_each(|row| {
            let _ = write!(near, "| {group} {}", row.line(&[0, 3, 4, 5]));
        });
    }
    let long: String = rows("long").iter().map(|row| row.line(&[0, 3, 4, 6])).collect();
    let page = format!(
        "# The extremes\n\n\
        Dynamics, controller and simulated arm at the edges of their range. `cargo nextest run -p studies --test extremes` measures all \
        of it again; a number that differs by more than 2 % from the recorded one fails the test, in either direction. [What this says, in short](../theory/numerics.md#the-extremes).\n\n\
        A requirement has a bound from theory or from use, or a documented outcome. A record is a number without a requirement. The table of \
        each group lists its cells and what each of them does.\n\n{counts}\n\
        ## What fails\n\n{failing}\n\
        ## Nearest to their bounds\n\nThe {SHOWN} passing requirements of each group that use most of their bound.\n\n{near}\n\
        ## A day\n\nMeasured only when the tables are written again, which takes two minutes: a million ticks of 1 µs, and 24 simulated hours at 1 kHz.\n\n\
        | cell | expected | found | |\n|---|---|---|---|\n{long}"
    );
    assert!(page.split_whitespace().count() < 1500, "{} words", page.split_whitespace().count());
    same(&folder().with_extension("md"), &page);
}
