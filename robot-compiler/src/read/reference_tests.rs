//! The reference of robot and scene files, made by asking the readers: shipped files with one key changed or left out.
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    reason = "a test stops at the first surprise; bounds are the very numbers"
)]

mod document;
mod kinds;
mod probe;
mod readme;

use document::{Path as KeyPath, inline, leaves, name};
use kinds::{FileKind, ROBOT_FILES, SCENE_FILES};
use probe::{Bound, Probe};
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

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

/// TOML files below a folder, those of the folder itself first.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let (mut folders, mut files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    files.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    files.sort();
    folders.sort();
    let below = folders.iter().filter(|folder| !folder.ends_with("studies")).flat_map(|folder| self::files(folder));
    files.into_iter().chain(below).collect()
}

impl<T: PartialEq> FileKind<T> {
    /// Files that the reader accepts, and the keys that their tables may have.
    fn documents(&self) -> (Vec<(PathBuf, Table)>, BTreeSet<String>) {
        // The table of actuators is read once, when a file first needs it: its keys are not those of a robot file.
        let _ = super::robot::actuators::all();
        KNOWN.with_borrow_mut(BTreeSet::clear);
        let shipped = files(&top().join(self.folder)).into_iter().map(|path| {
            let text = std::fs::read_to_string(&path).unwrap();
            (path, text)
        });
        let added = self.additions.iter().map(|(file, line, lines)| {
            let path = top().join(self.folder).join(file);
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.contains(line), "{file} has no {line:?}");
            (path, text.replacen(line, lines, 1))
        });
        let all: Vec<_> = shipped.chain(added).collect();
        let shipped = all.len() - self.additions.len();
        let accepted = all.into_iter().enumerate().filter_map(|(index, (path, text))| {
            let result = (self.read)(&text, &path);
            assert!(result.is_ok() || index < shipped, "{}: {}", path.display(), result.err().unwrap());
            result.is_ok().then(|| (path, toml::from_str(&text).unwrap()))
        });
        let accepted: Vec<_> = accepted.collect();
        assert!(accepted.len() > 15, "{} files of {}", accepted.len(), self.folder);
        (accepted, KNOWN.with_borrow(Clone::clone))
    }

    /// The page: a table for each table of the file, a row for each key.
    fn page(&self) -> String {
        let (documents, _) = self.documents();
        // A file that is right without the key shows more than one in which another key needs it.
        let count = Cell::new(0);
        let mut first: BTreeMap<String, (&PathBuf, &Table, KeyPath)> = BTreeMap::new();
        let mut tries: BTreeMap<String, u32> = BTreeMap::new();
        for (file, document) in &documents {
            for path in leaves(document) {
                let key = name(&path);
                let tries = tries.entry(key.clone()).or_default();
                if *tries == TRIES {
                    continue;
                }
                *tries += 1;
                let probe = Probe { read: self.read, file, document, path: &path, count: &count };
                if probe.missing().is_none() {
                    *tries = TRIES;
                    first.insert(key, (file, document, path));
                } else {
                    first.entry(key).or_insert((file, document, path));
                }
            }
        }
        let words = std::fs::read_to_string(top().join(self.folder).join("README.md")).unwrap();
        let mut tables: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for (key, (file, document, path)) in &first {
            let (outer, last) = key.rsplit_once('.').unwrap_or(("", key));
            let probe = Probe { read: self.read, file, document, path, count: &count };
            tables.entry(outer).or_default().push(row(last, file, &probe, &words));
        }
        let mut page = self.head.to_owned();
        for (table, rows) in tables {
            let title = if table.is_empty() { "Top level".to_owned() } else { format!("`{table}`") };
            let _ = write!(page, "\n## {title}\n\n{COLUMNS}{}", rows.concat());
        }
        eprintln!("{} readings of {}", count.get(), self.folder);
        page
    }
}

/// Places of a key that are tried without it.
const TRIES: u32 = 12;

const COLUMNS: &str = "| key | expected | without the key | example | accepted in that file |\n|---|---|---|---|---|\n";

/// The row of a key.
fn row<T: PartialEq>(key: &str, file: &Path, probe: &Probe<'_, T>, words: &str) -> String {
    let expected = probe.expected();
    let range = probe.start().map_or_else(String::new, |(start, whole)| {
        if probe.accepts_all_but_zero(start, whole) {
            return "any number but 0".to_owned();
        }
        let [lo, hi] = [false, true].map(|above| probe.bound(start, whole, above));
        let mut range = range(lo, hi);
        if probe.is_list() && !range.is_empty() && range != ANY {
            range = format!("first number: {range}");
        }
        let answers = [lo, hi].into_iter().flatten().map(|bound| probe.beyond(bound, whole));
        let answers: BTreeSet<_> = answers.filter(|answer| *answer != expected && !answer.is_empty()).collect();
        for answer in answers {
            let _ = write!(range, "{}beyond: expected {answer}", if range.is_empty() { "" } else { "; " });
        }
        range
    });
    let missing = match probe.missing() {
        Some(error) if error.field().ends_with(key) => format!("error: {}", error.problem()),
        Some(error) => format!("error at `{}`: {}", error.field(), error.problem()),
        None => probe
            .default(candidates(key, probe, &expected, words))
            .map_or_else(|| "allowed".to_owned(), |value| format!("`{}`", inline(&value))),
    };
    let example = probe.example();
    let example =
        if example.chars().count() > 60 { example.chars().take(57).chain("...".chars()).collect() } else { example };
    let file = file.strip_prefix(top()).unwrap().display();
    let cells = [expected, missing, format!("`{example}` ({file})"), range];
    format!("| `{key}` | {} |\n", cells.map(|cell| cell.replace('|', "\\|").replace('\n', " ")).join(" | "))
}

/// Values that may be the default of a key: words that the reader expects, and numbers of the lines that explain the key.
fn candidates<'a, T: PartialEq>(
    key: &str,
    probe: &Probe<'_, T>,
    expected: &'a str,
    words: &'a str,
) -> impl Iterator<Item = Value> + use<'a, T> {
    let parts = |text: &'a str| text.split([' ', ',', ';', '|', ':', '(', ')', '`', '[', ']', '\n']);
    let texts = parts(expected).map(|word| Value::String(word.trim_matches('"').to_owned()));
    let lines = words.lines().filter(|line| line.starts_with('|') && parts(line).any(|word| word == key));
    let mut numbers: Vec<f64> = lines.flat_map(parts).filter_map(|part| part.parse::<f64>().ok()).collect();
    numbers.extend([0.0, 1.0, -1.0, f64::INFINITY]);
    numbers.sort_by(|a, b| a.abs().total_cmp(&b.abs()).then(b.total_cmp(a)));
    numbers.dedup();
    let standard_gravity = Value::Array([0.0, 0.0, -9.81].map(Value::Float).into());
    let lists = if probe.is_list() { vec![standard_gravity] } else { Vec::new() };
    let numbers = numbers.into_iter().flat_map(|x| [Value::Float(x), Value::Integer(x as i64)]);
    [true, false].map(Value::Boolean).into_iter().chain(texts).chain(lists).chain(numbers)
}

/// Range without bounds.
const ANY: &str = "any number";

/// Words for a range.
fn range(lo: Option<Bound>, hi: Option<Bound>) -> String {
    let shown = |x: f64| if x != 0.0 && !(1e-3..1e7).contains(&x.abs()) { format!("{x:e}") } else { format!("{x}") };
    match (lo, hi) {
        // A list of values, which the expected value names.
        (Some(lo), Some(hi)) if lo.value == hi.value => String::new(),
        (Some(lo), Some(hi)) if lo.included && hi.included => format!("{} to {}", shown(lo.value), shown(hi.value)),
        (lo, hi) => {
            let lo = lo.map(|lo| format!("{} {}", if lo.included { "at least" } else { "above" }, shown(lo.value)));
            let hi = hi.map(|hi| format!("{} {}", if hi.included { "at most" } else { "below" }, shown(hi.value)));
            let both: Vec<_> = lo.into_iter().chain(hi).collect();
            if both.is_empty() { ANY.to_owned() } else { both.join(", ") }
        }
    }
}

fn compare<T: PartialEq>(kind: &FileKind<T>) -> Option<String> {
    let (page, path) = (kind.page(), top().join(kind.page));
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    if std::env::var_os("UPDATE_EMITTED").is_some() {
        std::fs::write(&path, &page).unwrap();
        return None;
    }
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let (old, new) = (lines(&written), lines(&page));
    let differ: Vec<_> = new.iter().filter(|line| !old.contains(line)).map(|line| format!("+ {line}")).collect();
    let gone = old.iter().filter(|line| !new.contains(line)).map(|line| format!("- {line}"));
    let differ: Vec<_> = gone.chain(differ).collect();
    (!differ.is_empty()).then(|| format!("{}:\n{}", kind.page, differ.join("\n")))
}

#[test]
fn the_reference_of_robot_and_scene_files_is_what_the_reader_of_robots_answers() {
    assert_eq!(compare(&ROBOT_FILES), None);
}

#[test]
fn the_reference_of_robot_and_scene_files_is_what_the_reader_of_scenes_answers() {
    assert_eq!(compare(&SCENE_FILES), None);
}

#[test]
fn the_reference_has_every_key_that_a_file_may_have() {
    let missing = |page: &str, known: BTreeSet<String>| {
        let text = std::fs::read_to_string(top().join(page)).unwrap();
        let keys: BTreeSet<_> =
            text.split('`').skip(1).step_by(2).flat_map(|key| key.split(['.', '[', ']'])).map(str::to_owned).collect();
        known.into_iter().filter(|key| !keys.contains(key)).map(|key| format!("{page}: {key}")).collect::<Vec<_>>()
    };
    let robots = ROBOT_FILES.documents().1;
    let scenes: BTreeSet<_> = SCENE_FILES.documents().1.difference(&robots).cloned().collect();
    let missing = [missing(ROBOT_FILES.page, robots), missing(SCENE_FILES.page, scenes)].concat();
    assert!(missing.is_empty(), "{missing:?}");
}
