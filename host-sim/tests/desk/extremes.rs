//! The extremes, tested from both sides: a passing cell must go on passing with its number, and a failing one must go
//! on failing for its reason until it is removed from the list here.

use crate::program::at_the_top;
use serde_json::Value;
use std::process::Output;
use studies::extremes::{Cell, Kind, Report, control, inputs, integrators, masses, stability, time};

/// Cells that fail today.
const FAILING: [(&str, &str); 8] = [
    ("integrators", "energy over 100 s, steps of 1 ms, planar 2R, semi-implicit Euler"),
    ("integrators", "energy over 100 s, steps of 2.5 ms, planar 2R, semi-implicit Euler"),
    ("integrators", "energy over 100 s, steps of 1 ms, Puma 560, semi-implicit Euler"),
    ("integrators", "energy over 100 s, steps of 2.5 ms, Puma 560, semi-implicit Euler"),
    ("time", "observed speed with a period of 1e-6 s, f32"),
    ("time", "observed speed with a period of 1e-5 s, f32"),
    ("control", "Coulomb friction three times the model's"),
    ("control", "torque limits times 0.25"),
];

/// True if the number of a cell is required by nothing: what a table says a record is, name by name.
fn is_record(cell: &Cell) -> bool {
    let starts = [
        "predicted period, ",
        "chaotic 2R, ",
        "clock drift, had it been summed",
        "breakaway, peak speed, creeping",
        "breakaway, slips, creeping",
    ];
    let beyond_a_turn = cell.name.starts_with("region at ") && !cell.name.starts_with("region at 1 turn,");
    starts.iter().any(|start| cell.name.starts_with(start))
        || cell.name.ends_with("forward, accelerations")
        || beyond_a_turn
}

/// Assert for the cells of one group that none moved, and that exactly the known ones fail.
fn hold(group: &str, count: usize, cells: Vec<Cell>) {
    let report = Report::of(cells);
    let wrong: Vec<String> = report
        .cells
        .iter()
        .filter(|cell| cell.group != group || cell.passed == FAILING.contains(&(cell.group, &cell.name)))
        .chain(report.cells.iter().filter(|cell| cell.value.is_some() && cell.moved))
        .map(|cell| {
            format!("{},{:?},{:?}: found {}, expected {}", cell.group, cell.name, cell.value, cell.found, cell.expected)
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(
        report.cells.iter().all(|cell| cell.value.is_some() == cell.pinned.is_some()),
        "a number without its expected one"
    );
    let unlike: Vec<&String> = report
        .cells
        .iter()
        .filter(|cell| (cell.kind == Kind::Record) != is_record(cell))
        .map(|cell| &cell.name)
        .collect();
    assert!(unlike.is_empty(), "{unlike:?}");
    // A requirement says more than the number as it was: a window is never wider than from a tenth to ten times it.
    for cell in report.cells.iter().filter(|cell| cell.kind == Kind::Requirement) {
        if let Some((least, most)) = cell.expected.split_once(", in ").and_then(|(_, window)| window.split_once(" to "))
        {
            let [least, most]: [f64; 2] = [least, most].map(|bound| bound.parse().unwrap());
            assert!(least <= 0.0 || most <= 100.0 * least, "{}: {}", cell.name, cell.expected);
        }
    }
    let known = FAILING.iter().filter(|(of, _)| *of == group).count();
    assert_eq!((report.count, report.failed, report.passed), (count, known, count - known));
    // Every failing cell has a reason, and all names are unique.
    assert!(report.cells.iter().all(|cell| cell.passed || cell.reason.as_ref().is_some_and(|why| !why.is_empty())));
    let mut names: Vec<&String> = report.cells.iter().map(|cell| &cell.name).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), count);
    // The page matches the measurements: every row of the group's table, and nothing else under its heading.
    let page = include_str!("../../../docs/measured/extremes.md");
    let table = report.markdown();
    let table = &table[table.find("### ").unwrap()..];
    assert!(page.contains(table), "docs/measured/extremes.md is not what `host-sim extremes --write` writes:\n{table}");
}

/// Run the command in the project's root folder.
fn extremes(arguments: &[&str]) -> Output {
    at_the_top().arg("extremes").args(arguments).output().unwrap()
}

#[test]
fn a_page_without_a_place_for_the_tables_is_refused_before_the_run() {
    let output = extremes(&["--write", "README.md"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout), (Some(2), vec![]), "{said}");
    assert!(said.contains("README.md: expected the lines `<!-- measured: extremes -->`"), "{said}");
    assert_eq!(extremes(&["--write", "no/such/page.md"]).status.code(), Some(2));
    assert_eq!(extremes(&["--long", "-1"]).status.code(), Some(2));
    assert_eq!(extremes(&["--long", "nan"]).status.code(), Some(2));
}

#[test]
fn json_counts_the_cells_and_the_page_has_the_count() {
    let output = extremes(&["--json"]);
    assert_eq!(output.status.code(), Some(0));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let [count, passed, failed] = ["count", "passed", "failed"].map(|name| report[name].as_u64().unwrap());
    assert_eq!((count, failed), (326, FAILING.len() as u64));
    assert_eq!(count, passed + failed);
    assert_eq!(report["cells"].as_array().unwrap().len() as u64, count);
    let page = include_str!("../../../docs/measured/extremes.md");
    let records = report["records"].as_u64().unwrap();
    assert!(records > 60 && records < count / 2, "{records}");
    let required = count - records;
    let said = format!("{count} cells: {passed} passed, {failed} failed; {required} requirements, {records} records");
    assert!(page.contains(&said), "{said}");
    for cell in report["cells"].as_array().unwrap() {
        assert!(["requirement", "record"].contains(&cell["kind"].as_str().unwrap()), "{cell}");
    }
}

#[test]
fn masses_and_inertias() {
    hold("masses", 114, masses::cells());
}

#[test]
fn inputs_are_right_or_a_fault() {
    hold("inputs", 90, inputs::cells().unwrap());
}

#[test]
fn integrators_keep_their_order() {
    hold("integrators", 32, integrators::cells().unwrap());
}

#[test]
fn time_does_not_drift() {
    hold("time", 27, time::cells().unwrap());
}

#[test]
fn control_stays_bounded() {
    hold("control", 16, control::cells().unwrap());
}

#[test]
fn stable_periods_are_predicted() {
    hold("stability", 47, stability::cells().unwrap());
}

#[test]
fn a_page_begins_with_what_fails_and_has_every_cell() {
    let cell = |name: &str, passed: bool| Cell {
        group: "control",
        name: name.to_owned(),
        done: "made up".to_owned(),
        kind: Kind::Requirement,
        expected: "at most 1".to_owned(),
        found: "2.00".to_owned(),
        value: Some(2.0),
        pinned: None,
        moved: false,
        passed,
        reason: (!passed).then(|| "too much <rubs>".to_owned()),
    };
    let report = Report::of(vec![cell("one that holds", true), cell("one that fails", false)]);
    let html = report.page().unwrap().html();
    let (list, tables) = html.split_once("<figure>").unwrap();
    assert!(
        list.contains("<li>control, one that fails: too much &lt;rubs&gt;</li>") && !list.contains("one that holds")
    );
    assert!(tables.contains("<td class=\"warns words\">FAIL</td>") && tables.contains("<td class=\"words\">pass</td>"));
    assert_eq!(tables.matches("<th scope=\"row\">").count(), report.count);
    assert!(tables.matches("<circle").count() > 20, "simulated borders of stability");
}
