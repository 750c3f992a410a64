//! Questions to a reader about one key: files with other values of it, and files without it.

use super::document::{Step, at, inline, text, with};
use crate::describe::diagnostics::FileError;
use crate::read::shown::rounded;
use std::cell::Cell;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// A reader of files.
pub(super) type Reader<T> = fn(&str, &Path) -> Result<T, FileError>;

/// A key of a file that the reader accepts.
pub(super) struct Probe<'a, T> {
    pub(super) read: Reader<T>,
    pub(super) file: &'a PathBuf,
    pub(super) document: &'a Table,
    pub(super) path: &'a [Step],
    /// Files that were read.
    pub(super) count: &'a Cell<usize>,
}

/// A bound of the values that the reader accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bound {
    pub(super) value: f64,
    /// True if the bound itself is accepted.
    pub(super) included: bool,
    /// The nearest value beyond that was rejected.
    rejected: f64,
}

/// Values at which the search for a bound starts.
const GRID: [f64; 29] = [
    -1e12, -1e9, -1e6, -1e5, -1e4, -1e3, -100.0, -10.0, -1.0, -0.1, -1e-2, -1e-3, -1e-4, -1e-6, 0.0, 1e-6, 1e-4, 1e-3,
    1e-2, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6, 1e9, 1e12,
];

impl<T: PartialEq> Probe<'_, T> {
    fn read(&self, value: Option<Value>) -> Result<T, FileError> {
        self.count.set(self.count.get() + 1);
        (self.read)(&text(&with(self.document, self.path, value)), self.file)
    }

    fn value(&self) -> &Value {
        at(self.document, self.path).expect("the path is of this document")
    }

    /// The shipped file's value as TOML.
    pub(super) fn example(&self) -> String {
        inline(self.value())
    }

    /// The reader's own description of a right value: its answer to a date, which no key accepts.
    pub(super) fn expected(&self) -> String {
        let date = "1979-05-27".parse().map(Value::Datetime).expect("a date");
        self.read(Some(date)).err().map_or_else(String::new, |error| error.expected().to_owned())
    }

    /// The answer to a file without the key, if that is an error.
    pub(super) fn missing(&self) -> Option<FileError> {
        self.read(None).err()
    }

    /// The first of some values that means the same as no key.
    pub(super) fn default(&self, candidates: impl Iterator<Item = Value>) -> Option<Value> {
        let absent = self.read(None).ok()?;
        candidates.into_iter().find(|value| self.read(Some(value.clone())).is_ok_and(|given| given == absent))
    }

    /// A number in place of this one, or of the first number of a list.
    fn number(&self, x: f64, whole: bool) -> Value {
        let number = if whole { Value::Integer(x as i64) } else { Value::Float(x) };
        match self.value() {
            Value::Array(entries) => {
                Value::Array(std::iter::once(number).chain(entries.iter().skip(1).cloned()).collect())
            }
            _ => number,
        }
    }

    fn accepts(&self, x: f64, whole: bool) -> bool {
        self.read(Some(self.number(x, whole))).is_ok()
    }

    /// The number, or the first number of the list; and true if it must be whole.
    pub(super) fn start(&self) -> Option<(f64, bool)> {
        let first = match self.value() {
            Value::Array(entries) => entries.first()?,
            value => value,
        };
        match first {
            Value::Integer(x) => {
                Some((*x as f64, !self.accepts(*x as f64 + 0.5, false) && !self.accepts(*x as f64, false)))
            }
            Value::Float(x) if x.is_finite() => Some((*x, false)),
            _ => None,
        }
    }

    /// True if the value is a list of numbers.
    pub(super) fn is_list(&self) -> bool {
        self.value().is_array()
    }

    /// True if the reader accepts the number and its opposite, far away and near zero, and rejects zero.
    pub(super) fn accepts_all_but_zero(&self, start: f64, whole: bool) -> bool {
        let accepted = [start, -start, 1e6, -1e6, 1e-6, -1e-6];
        !whole && !self.accepts(0.0, whole) && accepted.into_iter().all(|x| self.accepts(x, whole))
    }

    /// The bound above or below a number that the reader accepts; `None` without one.
    pub(super) fn bound(&self, start: f64, whole: bool, above: bool) -> Option<Bound> {
        let beyond = |x: &f64| if above { *x > start } else { *x < start };
        let mut grid: Vec<f64> = GRID.into_iter().filter(|x| beyond(x) && (!whole || x.fract() == 0.0)).collect();
        if !above {
            grid.reverse();
        }
        let mut accepted = start;
        let rejected = grid.into_iter().find(|x| {
            let fits = self.accepts(*x, whole);
            accepted = if fits { *x } else { accepted };
            !fits
        })?;
        Some(narrowed(accepted, rejected, whole, |x| self.accepts(x, whole)))
    }

    /// The reader's answer to a value beyond a bound.
    pub(super) fn beyond(&self, bound: Bound, whole: bool) -> String {
        let error = self.read(Some(self.number(bound.rejected, whole))).err();
        error.map_or_else(String::new, |error| error.expected().to_owned())
    }
}

/// The bound between a number that is accepted and one that is not: the roundest number that it may be.
fn narrowed(mut accepted: f64, mut rejected: f64, whole: bool, accepts: impl Fn(f64) -> bool) -> Bound {
    let far = |a: f64, b: f64| {
        if whole { (a - b).abs() > 1.0 } else { (a - b).abs() > 1e-4 * a.abs().max(b.abs()).max(1e-6) }
    };
    while far(accepted, rejected) {
        let middle = if accepted * rejected > 0.0 {
            accepted.signum() * (accepted * rejected).sqrt()
        } else {
            f64::midpoint(accepted, rejected)
        };
        let middle = if whole { f64::midpoint(accepted, rejected).trunc() } else { middle };
        if whole && (middle == accepted || middle == rejected) {
            break;
        }
        if accepts(middle) { accepted = middle } else { rejected = middle }
    }
    if whole {
        return Bound { value: accepted, included: true, rejected };
    }
    let between = |x: &f64| (accepted.min(rejected)..=accepted.max(rejected)).contains(x);
    let middle = f64::midpoint(accepted, rejected);
    let value =
        std::iter::once(0.0).chain((0..7).map(|digits| rounded(middle, digits))).find(between).unwrap_or(accepted);
    Bound { value, included: value == accepted || accepts(value), rejected }
}

#[test]
fn a_bound_is_the_roundest_number_between_accepted_and_rejected() {
    let up = |limit: f64| narrowed(0.1, 1.0, false, move |x| x <= limit);
    assert_eq!((up(0.5).value, up(0.5).included), (0.5, true));
    assert_eq!((up(0.123_45).value, up(0.123_45).included), (0.123_45, true));
    let open = narrowed(0.1, 1.0, false, |x| x < 0.5);
    assert_eq!((open.value, open.included), (0.5, false));
    let positive = narrowed(1e-6, 0.0, false, |x| x > 0.0);
    assert_eq!((positive.value, positive.included), (0.0, false));
    let whole = narrowed(10.0, 1000.0, true, |x| x <= 253.0);
    assert_eq!((whole.value, whole.rejected), (253.0, 254.0));
}
