//! Rust expressions, laid out as rustfmt lays them out.

use dynamics_core::Real;
use std::fmt::Debug;

/// A float whose values can be written as source.
pub(crate) trait Float: Real + Debug {
    /// The name of its type.
    const NAME: &'static str;
}

impl Float for f32 {
    const NAME: &'static str = "f32";
}

impl Float for f64 {
    const NAME: &'static str = "f64";
}

/// Widest line.
const WIDTH: usize = 120;

/// An expression.
pub(crate) enum Item {
    /// An expression without parts.
    Word(String),
    /// `open part, part close`, on one line if it fits, otherwise one part a line.
    Group { open: String, close: &'static str, spaced: bool, parts: Vec<Item> },
    /// `name: value` inside a group.
    Field(&'static str, Box<Item>),
}

pub(crate) fn word(text: &str) -> Item {
    Item::Word(text.to_owned())
}

pub(super) fn integer(x: i64) -> Item {
    Item::Word(x.to_string())
}

pub(super) fn number<S: Float>(x: S) -> Item {
    Item::Word(literal(x))
}

pub(super) fn call(function: &str, arguments: Vec<Item>) -> Item {
    Item::Group { open: format!("{function}("), close: ")", spaced: false, parts: arguments }
}

pub(crate) fn list(parts: Vec<Item>) -> Item {
    Item::Group { open: "[".to_owned(), close: "]", spaced: false, parts }
}

pub(crate) fn record(name: &str, fields: Vec<(&'static str, Item)>) -> Item {
    let parts = fields.into_iter().map(|(name, value)| Item::Field(name, Box::new(value))).collect();
    Item::Group { open: format!("{name} {{"), close: "}", spaced: true, parts }
}

/// The shortest decimal that reads back as the same number; infinities by name.
pub(super) fn literal<S: Float>(x: S) -> String {
    if x.is_finite() {
        return format!("{x:?}");
    }
    let value = if x > S::zero() {
        "INFINITY"
    } else if x < S::zero() {
        "NEG_INFINITY"
    } else {
        "NAN"
    };
    format!("{}::{value}", S::NAME)
}

impl Item {
    /// The expression as source, starting at column `indent`.
    pub(crate) fn print(&self, indent: usize) -> String {
        self.lay_out(indent, 0, 0)
    }

    /// Lays the expression out. On its line, `before` columns are used before it, and `after` columns follow it.
    fn lay_out(&self, indent: usize, before: usize, after: usize) -> String {
        let flat = self.flat();
        if indent + before + flat.len() + after <= WIDTH {
            return flat;
        }
        let (open, close, parts) = match self {
            Self::Word(text) => return text.clone(),
            Self::Field(name, value) => {
                return format!("{name}: {}", value.lay_out(indent, before + name.len() + 2, after));
            }
            Self::Group { open, close, parts, .. } => (open, close, parts),
        };
        // A single list or record keeps its brackets on the line of the call around it.
        if let ([only @ Self::Group { .. }], false) = (parts.as_slice(), open == "[") {
            return format!("{open}{}{close}", only.lay_out(indent, before + open.len(), after + close.len()));
        }
        let pad = " ".repeat(indent);
        let mut text = format!("{open}\n");
        if self.is_short_list() {
            text += &filled(parts, indent + 4);
        } else {
            for part in parts {
                text += &format!("{pad}    {},\n", part.lay_out(indent + 4, 0, 1));
            }
        }
        text + &pad + close
    }

    fn flat(&self) -> String {
        match self {
            Self::Word(text) => text.clone(),
            Self::Field(name, value) => format!("{name}: {}", value.flat()),
            Self::Group { open, close, spaced, parts } => {
                let inner: Vec<String> = parts.iter().map(Self::flat).collect();
                let space = if *spaced && !parts.is_empty() { " " } else { "" };
                format!("{open}{space}{}{space}{close}", inner.join(", "))
            }
        }
    }

    /// rustfmt fills lines with the entries of a list or the arguments of a call when none is longer than ten characters.
    fn is_short_list(&self) -> bool {
        const SHORT: usize = 10;
        match self {
            Self::Group { spaced: false, parts, .. } => {
                parts.iter().all(|part| matches!(part, Self::Word(text) if text.len() <= SHORT))
            }
            _ => false,
        }
    }
}

fn filled(parts: &[Item], indent: usize) -> String {
    let pad = " ".repeat(indent);
    let mut lines = vec![String::new()];
    for part in parts {
        let entry = part.flat() + ",";
        match lines.last_mut() {
            Some(line) if line.is_empty() => *line = entry,
            Some(line) if indent + line.len() + 1 + entry.len() < WIDTH => *line += &format!(" {entry}"),
            _ => lines.push(entry),
        }
    }
    lines.iter().map(|line| format!("{pad}{line}\n")).collect()
}
