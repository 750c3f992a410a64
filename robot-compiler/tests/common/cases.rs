//! Tables of test cases: inputs and the output that each must give, in one text file that can be read and edited.
//!
//! A line `==== NAME` begins a case. Its input follows, then a line `----`, then the expected output. `==== NAME from BASE`
//! gives the input as changes of another text: a section of the table without `----`, or else a file, relative to the
//! table's folder.
//!
//! ```text
//! ==== arm.toml
//! name = "arm"
//! mass = 1.5
//!
//! ==== robot_mass_negative.toml from arm.toml
//! - mass = 1.5
//! + mass = -1.5
//! ----
//!   × tests/bad/robot_mass_negative.toml:2:8: mass: found -1.5
//! ```
//!
//! A change is a run of lines of the base. Lines after `- ` are removed, lines after `+ ` are added, lines after two blanks
//! are kept. Together, the removed and kept lines must occur exactly once in the base: add lines around the change until they do. `...`
//! separates two changes. A case that has the name of a file, without a change, is that file.
//!
//! To add a case, write it up to its line `----`. `UPDATE_EMITTED=1 cargo nextest run -p PACKAGE` then writes the outputs
//! into the tables. Check the diff before you commit it.
#![allow(unreachable_pub, reason = "a module of several test programs")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot read its table should stop there")]

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Environment variable that makes tests write their outputs into the tables.
const UPDATE: &str = "UPDATE_EMITTED";

/// A case of a table.
#[derive(Debug)]
pub struct Case {
    /// Its name, which occurs once in the table.
    pub name: String,
    /// Input; `None` for the file of this name in the table's folder.
    pub input: Option<String>,
    /// Output that it must give, without empty lines at its end.
    pub expected: String,
    /// Lines of the table, counted from 0: the first line of the case, and the lines of its output.
    lines: (usize, Range<usize>),
}

/// A table of cases.
#[derive(Debug)]
pub struct Table {
    path: PathBuf,
    text: String,
    /// Texts from which cases are made by changes, with their names.
    pub bases: Vec<(String, String)>,
    /// Cases, in the order of the file.
    pub cases: Vec<Case>,
}

impl Table {
    /// Reads a table.
    pub fn read(path: &Path) -> Self {
        Self::new(path, fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
    }

    /// Reads the text of a table; files are relative to the folder of `path`.
    pub fn new(path: &Path, text: String) -> Self {
        let mut table = Self { path: path.to_owned(), text: text.clone(), bases: Vec::new(), cases: Vec::new() };
        let lines: Vec<&str> = text.lines().collect();
        let mut heads: Vec<usize> = (0..lines.len()).filter(|at| lines[*at].starts_with("====")).collect();
        heads.push(lines.len());
        heads.windows(2).for_each(|ends| table.add(&lines, ends[0]..ends[1]));
        table
    }

    /// Adds the section at these lines.
    fn add(&mut self, lines: &[&str], section: Range<usize>) {
        let head = section.start;
        let title = lines[head].trim_start_matches('=').trim();
        let (name, base) = title.split_once(" from ").map_or((title, None), |(name, base)| (name, Some(base)));
        let place = format!("{}:{}: {name}", self.path.display(), head + 1);
        let mut names = self.cases.iter().map(|case| &case.name).chain(self.bases.iter().map(|(name, _)| name));
        assert!(names.all(|other| other != name), "{place}: the second section of this name");
        let Some(rule) = section.clone().find(|at| lines[*at] == "----") else {
            assert!(base.is_none(), "{place}: no line `----` between the changes and the output");
            let text = lines[head + 1..section.end].join("\n");
            self.bases.push((name.to_owned(), format!("{}\n", text.trim_end_matches('\n'))));
            return;
        };
        let given = &lines[head + 1..rule];
        let input = match base {
            None => Some(given.iter().map(|line| format!("{line}\n")).collect()),
            Some(file) if file == name && given.is_empty() => None,
            Some(base) => Some(changed(&self.base(base), given, &place)),
        };
        let output = rule + 1..section.end;
        let expected = lines[output.clone()].join("\n").trim_end_matches('\n').to_owned();
        self.cases.push(Case { name: name.to_owned(), input, expected, lines: (head, output) });
    }

    /// A text from which cases are made by changes.
    fn base(&self, name: &str) -> String {
        let own = self.bases.iter().find(|(own, _)| own == name).map(|(_, text)| text.clone());
        own.unwrap_or_else(|| {
            let path = self.path.with_file_name(name);
            fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        })
    }

    /// The outputs that differ from those of the table, each with its location, name and lines.
    pub fn differences(&self, found: &[(&str, String)]) -> Vec<String> {
        let path = self.path.display();
        let compared = found.iter().map(|(name, found)| {
            let found = found.trim_end_matches('\n');
            match self.cases.iter().find(|case| case.name == *name) {
                None => Some(format!("{path}: no case {name}, found\n{found}")),
                Some(case) if case.expected == found => None,
                Some(case) => {
                    Some(format!("{path}:{}: {name}\n{}", case.lines.0 + 1, difference(&case.expected, found)))
                }
            }
        });
        compared.flatten().collect()
    }

    /// The text of the table with these outputs; an output without a case becomes a case at the end.
    pub fn with(&self, found: &[(&str, String)]) -> String {
        let mut lines: Vec<&str> = self.text.lines().collect();
        for case in self.cases.iter().rev() {
            let Some((_, found)) = found.iter().find(|(name, _)| case.name == *name) else { continue };
            let output = case.lines.1.clone();
            let blank = (output.end < lines.len()).then_some("");
            lines.splice(output, found.trim_end_matches('\n').lines().chain(blank));
        }
        let mut text = lines.join("\n") + "\n";
        for (name, found) in found.iter().filter(|(name, _)| self.cases.iter().all(|case| case.name != *name)) {
            text += &format!("\n==== {name}\n----\n{}\n", found.trim_end_matches('\n'));
        }
        text
    }
}

/// A text with changes.
fn changed(base: &str, changes: &[&str], place: &str) -> String {
    let mut lines: Vec<&str> = base.lines().collect();
    for change in changes.split(|line| *line == "...") {
        let unmarked = |line: &&str| !(line.is_empty() || ["- ", "+ ", "  "].iter().any(|mark| line.starts_with(mark)));
        let unmarked: Vec<_> =
            change.iter().filter(|line| !["-", "+"].contains(line)).copied().filter(unmarked).collect();
        assert!(unmarked.is_empty(), "{place}: lines that do not begin with `- `, `+ ` or two blanks: {unmarked:?}");
        let without = |mark: char| -> Vec<&str> {
            change.iter().filter(|line| !line.starts_with(mark)).map(|line| line.get(2..).unwrap_or("")).collect()
        };
        let (old, new) = (without('+'), without('-'));
        assert!(!old.is_empty(), "{place}: no line of the base shows where {new:?} is added");
        let places: Vec<usize> = (0..lines.len()).filter(|at| lines[*at..].starts_with(&old)).collect();
        let [at] = places[..] else { panic!("{place}: {} places in the base have {old:?}, expected 1", places.len()) };
        lines.splice(at..at + old.len(), new);
    }
    lines.iter().map(|line| format!("{line}\n")).collect()
}

/// Lines in which two texts differ.
fn difference(expected: &str, found: &str) -> String {
    let (old, new): (Vec<&str>, Vec<&str>) = (expected.lines().collect(), found.lines().collect());
    let head = old.iter().zip(&new).take_while(|(old, new)| old == new).count();
    let pairs = old[head..].iter().rev().zip(new[head..].iter().rev());
    let tail = pairs.take_while(|(old, new)| old == new).count();
    let marked = |mark: char, lines: &[&str]| -> String {
        lines[head..lines.len() - tail].iter().map(|line| format!("{mark} {line}\n")).collect()
    };
    marked('-', &old) + &marked('+', &new)
}

/// Compares outputs with those of the table's cases with the same names.
///
/// # Panics
/// If some differ. With `UPDATE_EMITTED` set, the outputs are written into the table instead.
pub fn check(path: &Path, found: &[(&str, String)]) {
    let update = std::env::var_os(UPDATE).is_some();
    // Tests of one table run at the same time. The lock is released with the variable.
    let file = update.then(|| fs::File::open(path).unwrap());
    file.iter().for_each(|file| file.lock().unwrap());
    let table = Table::read(path);
    let section = |text: &str| text.lines().any(|line| line.starts_with("===="));
    assert!(!found.iter().any(|(_, text)| section(text)), "an output with a line that begins a section: {found:?}");
    let differences = table.differences(found);
    if update && !differences.is_empty() {
        fs::write(path, table.with(found)).unwrap();
    } else {
        let text = differences.join("\n");
        assert!(differences.is_empty(), "{} of {} outputs differ\n\n{text}", differences.len(), found.len());
    }
}
