//! The tables of keys in `robots/README.md` and `scenes/README.md`, compared with the keys that the readers accept.

use super::kinds::{ROBOT_FILES, SCENE_FILES};
use super::top;
use std::collections::BTreeSet;

/// Words of a text that are names of keys.
fn names(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}

/// Words in backticks of a page, and the words in backticks in the first cell of its tables of keys.
fn page(text: &str) -> (BTreeSet<&str>, BTreeSet<&str>) {
    let (mut all, mut rows, mut of_keys) = (BTreeSet::new(), BTreeSet::new(), false);
    for line in text.lines() {
        all.extend(line.split('`').skip(1).step_by(2).flat_map(names));
        if let Some(row) = line.strip_prefix("| ") {
            let first = row.split(" | ").next().unwrap_or_default();
            let head = first.starts_with("key");
            of_keys |= head;
            if of_keys && !head {
                rows.extend(
                    first.split('`').skip(1).step_by(2).flat_map(|key| names(key.split(" =").next().unwrap_or(key))),
                );
            }
        } else if !line.starts_with('|') {
            of_keys = false;
        }
    }
    (all, rows)
}

/// Differences between a page and the readers: keys that must be on it, and keys that may be.
fn differences(name: &str, must: &BTreeSet<String>, may: &BTreeSet<String>) -> Vec<String> {
    let text = std::fs::read_to_string(top().join(name)).unwrap();
    let (all, rows) = page(&text);
    assert!(rows.len() > 30, "{rows:?}");
    let missing = must.iter().filter(|key| !all.contains(key.as_str()));
    let missing = missing.map(|key| format!("{name} does not have the key `{key}`"));
    let stale = rows.iter().filter(|key| !may.contains(**key));
    missing.chain(stale.map(|key| format!("{name} has `{key}`, which no file may have"))).collect()
}

#[test]
fn the_tables_of_keys_are_those_of_the_readers() {
    let robots = ROBOT_FILES.documents().1;
    let scenes = SCENE_FILES.documents().1;
    let of_scenes: BTreeSet<_> = scenes.difference(&robots).cloned().collect();
    let found =
        [differences("robots/README.md", &robots, &robots), differences("scenes/README.md", &of_scenes, &scenes)];
    let found = found.concat();
    assert!(found.is_empty(), "{} differences:\n{}", found.len(), found.join("\n"));
}

#[test]
fn a_row_too_many_and_a_row_too_few_are_found() {
    let (all, rows) = page(
        "| key | value |\n|---|---|\n| `gone` | 1 |\n| `limits = { position }` | `velocity` |\n\n| file |\n|---|\n| `x` |",
    );
    assert!(rows.contains("gone") && rows.contains("limits") && !rows.contains("x") && !rows.contains("velocity"));
    assert!(all.contains("velocity") && all.contains("position"));
}
