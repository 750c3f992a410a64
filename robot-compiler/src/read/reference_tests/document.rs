//! A TOML document as a tree of values, to be changed at one key.

use std::fmt::Write as _;
use toml::{Table, Value};

/// A step from a table or a list to a value in it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    Key(String),
    Entry(usize),
}

/// Path of a value.
pub(super) type Path = Vec<Step>;

/// Name of a key in the reference: `joint[].drive.id`.
pub(super) fn name(path: &[Step]) -> String {
    path.iter().fold(String::new(), |mut name, step| {
        match step {
            Step::Key(key) if name.is_empty() => name.push_str(key),
            Step::Key(key) => _ = write!(name, ".{key}"),
            Step::Entry(_) => name.push_str("[]"),
        }
        name
    })
}

/// Paths of all values that are not tables; a list of numbers or words is one value.
pub(super) fn leaves(table: &Table) -> Vec<Path> {
    let mut found = Vec::new();
    table.iter().for_each(|(key, value)| below(value, &mut vec![Step::Key(key.clone())], &mut found));
    found
}

fn below(value: &Value, path: &mut Path, found: &mut Vec<Path>) {
    let mut enter = |step: Step, value: &Value| {
        path.push(step);
        below(value, path, found);
        path.pop();
    };
    match value {
        Value::Table(table) => table.iter().for_each(|(key, value)| enter(Step::Key(key.clone()), value)),
        Value::Array(entries) if entries.iter().any(Value::is_table) => {
            entries.iter().enumerate().for_each(|(index, entry)| enter(Step::Entry(index), entry));
        }
        _ => found.push(path.clone()),
    }
}

/// The value at a path.
pub(super) fn at<'a>(table: &'a Table, path: &[Step]) -> Option<&'a Value> {
    let [Step::Key(first), rest @ ..] = path else { return None };
    rest.iter().try_fold(table.get(first)?, |value, step| match step {
        Step::Key(key) => value.get(key),
        Step::Entry(index) => value.get(index),
    })
}

/// The document with another value at a path, or without the key.
pub(super) fn with(table: &Table, path: &[Step], value: Option<Value>) -> Table {
    let (mut changed, Some((Step::Key(last), outer))) = (table.clone(), path.split_last()) else {
        return table.clone();
    };
    let mut place = &mut changed;
    let mut steps = outer.iter();
    while let Some(Step::Key(key)) = steps.next() {
        let mut inner = &mut place[key.as_str()];
        while let Value::Array(entries) = inner {
            let Some(Step::Entry(index)) = steps.next() else { return table.clone() };
            inner = &mut entries[*index];
        }
        let Value::Table(inner) = inner else { return table.clone() };
        place = inner;
    }
    match value {
        Some(value) => _ = place.insert(last.clone(), value),
        None => _ = place.remove(last),
    }
    changed
}

/// The document as TOML.
pub(super) fn text(table: &Table) -> String {
    table.iter().fold(String::new(), |mut text, (key, value)| {
        let _ = writeln!(text, "{key:?} = {}", inline(value));
        text
    })
}

/// A value as TOML.
pub(super) fn inline(value: &Value) -> String {
    match value {
        Value::String(x) => format!("{x:?}"),
        Value::Integer(x) => x.to_string(),
        Value::Float(x) if x.is_finite() => format!("{x:?}"),
        Value::Float(x) => format!("{x}").replace("NaN", "nan"),
        Value::Boolean(x) => x.to_string(),
        Value::Datetime(x) => x.to_string(),
        Value::Array(entries) => format!("[{}]", entries.iter().map(inline).collect::<Vec<_>>().join(", ")),
        Value::Table(table) => {
            let fields = table.iter().map(|(key, value)| format!("{key} = {}", inline(value)));
            format!("{{ {} }}", fields.collect::<Vec<_>>().join(", "))
        }
    }
}
