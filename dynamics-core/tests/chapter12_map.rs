//! The tables of `docs/theory/chapter12.md` are complete: they lead from every equation, example and exercise of the robot-dynamics chapter to
//! code and tests, and everything that they name exists.
//!
//! Rows are `| numbers | what | code and files | tests |` under the headings `Equations`, `Examples` and `Exercises`. In the
//! last two columns every name in backticks is an entry: `crate::module::item` (an item or a method), a file with its
//! path, or `file.rs::test`. A row without an entry has `none:` and the reason, which is allowed only for exercises.
#![allow(clippy::unwrap_used, reason = "a table that cannot be read should stop the test")]

mod calls;
mod source;

use calls::{Reached, sources};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Numbers of each kind in the chapter.
const HEADINGS: [(&str, core::ops::RangeInclusive<u32>); 3] =
    [("Equations", 1..=535), ("Examples", 323..=347), ("Exercises", 1..=38)];

/// Crates that an entry may name, and the folders of their modules. `dynamics-core` re-exports the modules of `src/dynamics` as its own.
const CRATES: [(&str, &str); 6] = [
    ("dynamics_core", "dynamics-core/src"),
    ("dynamics_core", "dynamics-core/src/dynamics"),
    ("robot_compiler", "robot-compiler/src"),
    ("host_sim", "host-sim/src"),
    ("sim", "host-sim/sim/src"),
    ("studies", "host-sim/studies/src"),
];

/// Keywords before an item's name at its definition.
const ITEMS: [&str; 6] = ["fn", "struct", "enum", "trait", "const", "type"];

struct Row<'a> {
    heading: &'a str,
    numbers: Vec<u32>,
    entries: Vec<&'a str>,
    line: &'a str,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap()
}

/// The texts between pairs of backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// `12.1-12.3, 12.5` as 1, 2, 3, 5; `None` if a part is neither a number nor a range.
fn numbers(cell: &str) -> Option<Vec<u32>> {
    let number = |text: &str| -> Option<u32> {
        let text = text.trim();
        text.strip_prefix("12.").unwrap_or(text).parse().ok()
    };
    let parts = cell.split(',').map(|part| match part.split_once('-') {
        Some((first, last)) => Some(number(first)?..=number(last)?),
        None => number(part).map(|n| n..=n),
    });
    parts.collect::<Option<Vec<_>>>().map(|ranges| ranges.into_iter().flatten().collect())
}

fn rows(text: &str) -> Result<Vec<Row<'_>>, String> {
    let mut heading = "";
    let mut rows = Vec::new();
    for line in text.lines() {
        if let Some(found) = line.strip_prefix("## ") {
            heading = found;
        }
        let cells: Vec<_> = line.trim().trim_matches('|').split('|').map(str::trim).collect();
        let [first, .., code, tests] = cells[..] else { continue };
        let head = !first.starts_with(|c: char| c.is_ascii_digit());
        if !line.starts_with('|') || head || !HEADINGS.iter().any(|(known, _)| *known == heading) {
            continue;
        }
        let numbers = numbers(first).ok_or_else(|| format!("{heading}: {first} is no list of numbers"))?;
        let entries = quoted(code).chain(quoted(tests)).collect();
        rows.push(Row { heading, numbers, entries, line });
    }
    Ok(rows)
}

/// Numbers without a row, and rows without an entry that need one.
fn missing(rows: &[Row]) -> Vec<String> {
    let mut missing = Vec::new();
    for (heading, all) in HEADINGS {
        let found: BTreeSet<u32> =
            rows.iter().filter(|row| row.heading == heading).flat_map(|row| row.numbers.iter().copied()).collect();
        missing.extend(all.clone().filter(|n| !found.contains(n)).map(|n| format!("{heading}: {n} has no row")));
        missing.extend(found.iter().filter(|n| !all.contains(n)).map(|n| format!("{heading}: there is no {n}")));
    }
    let excused = |row: &Row| row.heading == "Exercises" && row.line.contains("| none: ");
    missing.extend(rows.iter().filter(|row| row.entries.is_empty() && !excused(row)).map(|row| row.line.to_owned()));
    missing
}

/// True if the text has `word name`, and the name ends there.
fn makes(text: &str, word: &str, name: &str) -> bool {
    let wanted = format!("{word} {name}");
    text.match_indices(&wanted)
        .any(|(at, _)| !text[at + wanted.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_'))
}

/// The files of a module and of the modules inside it, as one text.
fn module(path: &Path) -> Option<String> {
    let mut text = std::fs::read_to_string(path.with_extension("rs")).ok();
    for entry in std::fs::read_dir(path).into_iter().flatten().flatten() {
        let inner = entry.path();
        if inner.extension().is_some_and(|e| e == "rs") {
            text.get_or_insert_default().push_str(&std::fs::read_to_string(inner).ok()?);
        }
    }
    text
}

fn exists(entry: &str) -> bool {
    if let Some((file, test)) = entry.split_once(".rs::") {
        return std::fs::read_to_string(root().join(file).with_extension("rs"))
            .is_ok_and(|text| makes(&text, "fn", test));
    }
    let Some((named, path)) = entry.split_once("::") else {
        return entry.contains('/') && root().join(entry).is_file();
    };
    let folders = CRATES.iter().filter(|(name, _)| *name == named).map(|(_, folder)| root().join(folder));
    folders.into_iter().any(|mut at| {
        let mut items = path.split("::").peekable();
        let is_module = |at: &Path| at.with_extension("rs").is_file() || at.join("mod.rs").is_file();
        while let Some(inner) = items.next_if(|part| is_module(&at.join(part))) {
            at.push(inner);
        }
        let Some(text) = module(&at) else { return false };
        items.all(|item| ITEMS.iter().any(|word| makes(&text, word, item)))
    })
}

fn unresolved<'a>(rows: &[Row<'a>]) -> Vec<&'a str> {
    rows.iter().flat_map(|row| row.entries.iter().copied()).filter(|entry| !exists(entry)).collect()
}

/// Number of functions of the core with each name.
fn definitions() -> BTreeMap<String, usize> {
    let mut folders = vec![root().join("dynamics-core/src")];
    let mut found = BTreeMap::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
            } else {
                let tokens = source::tokens(&std::fs::read_to_string(entry).unwrap());
                for function in source::functions(&tokens) {
                    *found.entry(function.name).or_default() += 1;
                }
            }
        }
    }
    found
}

/// Items of a row that none of its tests calls, and tests of a row that call none of its items.
fn uncalled(rows: &[Row]) -> Vec<String> {
    let definitions = definitions();
    let mut files = BTreeMap::new();
    let mut missing = Vec::new();
    for row in rows {
        let (tests, code): (Vec<&str>, Vec<&str>) = row.entries.iter().partition(|entry| entry.contains(".rs::"));
        let code: Vec<&str> = code.into_iter().filter(|entry| entry.contains("::")).collect();
        for test in &tests {
            let (file, _) = test.rsplit_once("::").unwrap();
            files.entry(file.to_owned()).or_insert_with(|| sources(&root(), file));
        }
        let reached: Vec<Reached> = tests
            .iter()
            .map(|test| test.rsplit_once("::").unwrap())
            .map(|(file, test)| Reached::by(&files[file], test))
            .collect();
        let uses = |reached: &Reached, entry: &str| {
            let mut parts = entry.rsplit("::");
            let (item, owner) = (parts.next().unwrap_or(""), parts.next().unwrap_or(""));
            let alone = definitions.get(item).is_none_or(|count| *count == 1);
            match entry.strip_prefix("host_sim::cli::") {
                Some(_) => reached.runs(owner),
                None => reached.uses(owner, item, alone),
            }
        };
        let of_row = row.line.split('|').nth(1).unwrap_or("").trim();
        let nobody = code.iter().filter(|entry| !reached.iter().any(|reached| uses(reached, entry)));
        missing.extend(nobody.map(|entry| format!("{of_row}: no test calls {entry}")));
        let idle = tests.iter().zip(&reached).filter(|(_, reached)| !code.iter().any(|entry| uses(reached, entry)));
        if !code.is_empty() {
            missing.extend(idle.map(|(test, _)| format!("{of_row}: {test} calls none of the row's functions")));
        }
    }
    missing
}

#[test]
fn every_function_of_the_map_is_called_by_a_test_of_its_row() {
    let text = read("docs/theory/chapter12.md");
    let found = uncalled(&rows(&text).unwrap());
    assert!(found.is_empty(), "{}:\n{}", found.len(), found.join("\n"));
}

#[test]
fn every_equation_example_and_exercise_has_a_row() {
    let text = read("docs/theory/chapter12.md");
    assert_eq!(missing(&rows(&text).unwrap()), Vec::<String>::new());
}

#[test]
fn every_entry_of_the_map_is_there() {
    let text = read("docs/theory/chapter12.md");
    let found = unresolved(&rows(&text).unwrap());
    assert!(found.is_empty(), "not found:\n{}", found.join("\n"));
}

/// Names of tests in `docs/theory/errata.md` are long and have underscores; no formula there looks like a name.
#[test]
fn every_test_that_the_errata_name_is_there() {
    let folders = ["dynamics-core/tests", "dynamics-core/tests/chapter12"].map(|folder| root().join(folder));
    let sources: Vec<String> = folders
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .map(|path| std::fs::read_to_string(path).unwrap())
        .collect();
    let text = read("docs/theory/errata.md");
    let is_test = |name: &&str| name.matches('_').count() > 2 && !name.contains([' ', '/', '=']);
    let named: BTreeSet<&str> = quoted(&text).filter(is_test).collect();
    assert!(named.len() > 30, "{named:?}");
    let gone: Vec<_> = named.iter().filter(|name| !sources.iter().any(|text| makes(text, "fn", name))).collect();
    assert!(gone.is_empty(), "not found: {gone:?}");
}

/// A call is found through helpers, methods, imports under another name and implementations; a mention of the name is not a call.
#[test]
fn a_call_is_told_from_a_name() {
    let text = "\
use dynamics_core::chapter::lagrange::{self, gravity as weight};
use dynamics_core::mass_matrix::mass_matrix;
struct Energies;
impl Check for Energies { fn off(x: f64) -> f64 { lagrange::kinetic_energy(x) } }
struct Others;
impl Check for Others { fn off(x: f64) -> f64 { lagrange::potential_energy(x) } }
fn helper<const N: usize>(State { q }: &State<N>) -> f64 { weight(q) }
fn checked<C: Check>() -> f64 { C::off(1.0) }
#[test]
fn calls() { assert!('{' != '}' && checked::<Energies>() == [2.0].map(lagrange::christoffel) && helper(&state) > 0.0); }
#[test]
fn names() { /* mass_matrix(&d) */ let christoffel = \"mass_matrix(\"; println!(\"{christoffel}\"); own.solve(1); }
fn mass_matrix() {}
";
    let sources = [calls::Source::of(text)];
    let (calls, names) = (Reached::by(&sources, "calls"), Reached::by(&sources, "names"));
    for item in ["kinetic_energy", "christoffel", "gravity"] {
        assert!(calls.uses("lagrange", item, true), "{item}");
        assert!(!names.uses("lagrange", item, true), "{item}");
    }
    assert!(!calls.uses("lagrange", "potential_energy", true), "of the other type");
    assert!(!names.uses("mass_matrix", "mass_matrix", true), "a comment, a text");
    assert!(names.uses("Assembled", "solve", true) && !names.uses("Assembled", "solve", false));
    let found = uncalled(
        &rows(
            "## Equations\n| 12.1 | matrix | `dynamics_core::chapter::lagrange::tip_jacobian` | \
             `dynamics-core/tests/chapter12/example_340.rs::kinematics_are_12_301_to_12_315` |\n",
        )
        .unwrap(),
    );
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].ends_with("no test calls dynamics_core::chapter::lagrange::tip_jacobian"), "{found:?}");
}

/// A faulty table: each of its faults is reported, and its correct parts are not.
#[test]
fn a_broken_table_is_refused() {
    let table = "\
## Equations
| equation | what | code | tests |
|---|---|---|---|
| 12.1-12.533, 12.535 | all but one | `dynamics_core::chapter::posture::Posture::motion` | `dynamics-core/tests/identities.rs::slope_is_the_mass_matrix` |
| 12.536 | one too many | `dynamics_core::chapter::posture::Posture::motions` | `dynamics-core/tests/identities.rs::slope_is_the` |
## Examples
| 323-347 | leads nowhere | none: not an exercise | |
## Exercises
| 1-37 | in words | none: asked for in words | |
| 38 | gone | `robots/gone.toml`, `dynamics_core::gone::motion`, `dynamics_core::chapter::posture` | `docs/theory/dynamics.md` |
";
    let broken = rows(table).unwrap();
    let found = missing(&broken);
    assert_eq!(found.len(), 3, "{found:?}");
    assert_eq!(found[0], "Equations: 534 has no row");
    assert_eq!(found[1], "Equations: there is no 536");
    assert!(found[2].contains("leads nowhere"));
    let wanted = [
        "dynamics_core::chapter::posture::Posture::motions",
        "dynamics-core/tests/identities.rs::slope_is_the",
        "robots/gone.toml",
        "dynamics_core::gone::motion",
    ];
    assert_eq!(unresolved(&broken), wanted);
    // A first column that starts with a number but continues with something else.
    assert!(rows("## Equations\n| 12.1 and 12.2 | two | `a` | `b` |\n").is_err());
}
