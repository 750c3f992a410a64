//! The tables of keys in `robots/README.md` and `scenes/README.md`, compared with the keys that the readers accept.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use crate::{Robot, SceneFile};
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

thread_local! {
    /// Keys that tables of the files read so far may have, the last part of each name alone.
    static KNOWN: RefCell<BTreeSet<String>> = const { RefCell::new(BTreeSet::new()) };
}

/// Records the keys of a table.
pub(crate) fn record(known: &[&str]) {
    KNOWN.with_borrow_mut(|all| all.extend(known.iter().map(|key| (*key).to_owned())));
}

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// TOML files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    let below = folders.iter().filter(|folder| !folder.ends_with("studies")).flat_map(|folder| self::files(folder));
    files.into_iter().filter(|path| path.extension().is_some_and(|e| e == "toml")).chain(below).collect()
}

/// Keys that the readers accept in the files of a folder.
fn accepted(folder: &str, load: fn(&Path) -> bool) -> BTreeSet<String> {
    KNOWN.with_borrow_mut(BTreeSet::clear);
    let loaded = files(&top().join(folder)).iter().filter(|file| load(file)).count();
    assert!(loaded > 15, "{loaded} files of {folder}");
    KNOWN.with_borrow(Clone::clone)
}

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
    let robots = accepted("robots", |file| Robot::load(file).is_ok());
    let scenes = accepted("scenes", |file| {
        let text = std::fs::read_to_string(file).unwrap();
        // No shipped scene changes how hand guiding feels.
        let text = text.replace("law = \"teach\"\n", "law = \"teach\"\nteach = { friction = 0.8 }\n");
        SceneFile::from_toml_str(&text, file).is_ok()
    });
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
