//! A TOML document, read field by field, so that every error has its location.
//!
//! The parser keeps the location of every value. This layer visits the values together with the path of field names, and turns
//! each mismatch into a [`FileError`]. A derived deserialiser would do the same, but here semantic errors that are found later
//! still have the location available.

use super::shown::{counted, describe, shortened};
use crate::describe::diagnostics::{FileError, Source, one_of};
use crate::describe::draft::Place;
use crate::names::Named;
use nalgebra::Vector3;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A table and its location.
#[derive(Clone)]
pub(crate) struct Table<'a> {
    source: &'a Source,
    /// `None` has no key.
    table: Option<&'a DeTable<'a>>,
    span: Range<usize>,
    path: String,
}

/// A value and its location.
#[derive(Clone)]
pub(crate) struct Value<'a> {
    source: &'a Source,
    value: &'a DeValue<'a>,
    pub(crate) span: Range<usize>,
    pub(crate) path: String,
}

/// Parses a whole document.
pub(crate) fn parse(source: &Source) -> Result<Spanned<DeTable<'_>>, FileError> {
    DeTable::parse(&source.text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        if source.text.trim_start().starts_with('<') {
            let problem = "found XML, such as a URDF has".to_owned();
            return source.error(
                0..1,
                "",
                problem,
                "a robot file or a scene in TOML: `newtau import ARM.urdf --out arm.toml` makes a robot file",
            );
        }
        source.error(span, "", format!("not valid TOML: {}", error.message()), "a TOML document (https://toml.io)")
    })
}

impl<'a> Table<'a> {
    pub(crate) fn root(source: &'a Source, document: &'a Spanned<DeTable<'a>>) -> Self {
        // An empty span, because a missing key is reported at the top; otherwise the whole text would be marked.
        Self { source, table: Some(document.get_ref()), span: 0..0, path: String::new() }
    }

    /// Sets another name for the table in errors, such as a joint's own.
    pub(crate) fn named(mut self, path: String) -> Self {
        self.path = path;
        self
    }

    fn field(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// Rejects every key that is not in the list.
    pub(crate) fn only(&self, known: &[&str]) -> Result<(), FileError> {
        #[cfg(test)]
        super::reference_tests::record(known);
        let unknown =
            self.table.iter().flat_map(|table| table.keys()).filter(|key| !known.contains(&key.get_ref().as_ref()));
        let Some(first) = unknown.min_by_key(|key| key.span().start) else {
            return Ok(());
        };
        let word: &str = first.get_ref();
        Err(self.source.error(first.span(), self.field(word), "unknown key", one_of(word, known)))
    }

    pub(crate) fn get(&self, key: &str) -> Option<Value<'a>> {
        let value = self.table?.get(key)?;
        Some(Value { source: self.source, value: value.get_ref(), span: value.span(), path: self.field(key) })
    }

    /// Every key with its location and value.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (&'a str, Range<usize>, Value<'a>)> {
        let (table, source, path) = (self.table, self.source, self.path.clone());
        table.into_iter().flat_map(|table| table.iter()).map(move |(key, value)| {
            let name: &'a str = key.get_ref().as_ref();
            let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
            (name, key.span(), Value { source, value: value.get_ref(), span: value.span(), path })
        })
    }

    pub(crate) fn require(&self, key: &str, expected: &str) -> Result<Value<'a>, FileError> {
        self.get(key).ok_or_else(|| self.error(key, "missing", expected))
    }

    /// The table under a key, if it exists.
    pub(crate) fn table(&self, key: &str) -> Result<Option<Table<'a>>, FileError> {
        self.get(key).map(|value| value.table()).transpose()
    }

    /// An empty table, as replacement for a missing one.
    pub(crate) fn empty(&self, key: &str) -> Table<'a> {
        Table { source: self.source, table: None, span: self.span.clone(), path: self.field(key) }
    }

    /// The location of a field, or of this table if the field is missing.
    pub(crate) fn place(&self, key: &str) -> Place {
        let value = self.table.and_then(|table| table.get(key));
        Place { span: value.map_or(self.span.clone(), Spanned::span), field: self.field(key), given: value.is_some() }
    }

    /// The location of a field in a table of this one, or of the nearest one present.
    pub(crate) fn place_in(&self, outer: &str, inner: &str) -> Place {
        match self.table(outer) {
            Ok(Some(table)) => table.place(inner),
            _ => self.empty(outer).place(inner),
        }
    }

    /// An error at a field of this table, or at the table if the field is missing.
    pub(crate) fn error(&self, key: &str, problem: impl Into<String>, expected: impl Into<String>) -> FileError {
        let span = self.table.and_then(|table| table.get(key)).map_or(self.span.clone(), Spanned::span);
        self.source.error(span, self.field(key), problem, expected)
    }
}

impl<'a> Value<'a> {
    pub(crate) fn error(&self, problem: impl Into<String>, expected: impl Into<String>) -> FileError {
        self.source.error(self.span.clone(), &self.path, problem, expected)
    }

    pub(crate) fn mismatch(&self, expected: &str) -> FileError {
        self.error(format!("found {}", describe(self.value)), expected)
    }

    pub(crate) fn is_string(&self) -> bool {
        self.value.is_str()
    }

    pub(crate) fn is_table(&self) -> bool {
        self.value.is_table()
    }

    pub(crate) fn is_array(&self) -> bool {
        self.value.is_array()
    }

    pub(crate) fn string(&self, expected: &str) -> Result<&'a str, FileError> {
        self.value.as_str().ok_or_else(|| self.mismatch(expected))
    }

    pub(crate) fn boolean(&self) -> Result<bool, FileError> {
        self.value.as_bool().ok_or_else(|| self.mismatch("true or false"))
    }

    /// A number; infinities and NaN are accepted.
    pub(crate) fn number(&self, expected: &str) -> Result<f64, FileError> {
        let number = match self.value {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(integer) => integer_value(integer.as_str(), integer.radix()),
            _ => None,
        };
        number.ok_or_else(|| self.mismatch(expected))
    }

    pub(crate) fn finite(&self, expected: &str) -> Result<f64, FileError> {
        let number = self.number(expected)?;
        if !number.is_finite() {
            return Err(self.error(format!("found {number}, which is not finite"), expected));
        }
        // Numbers that overflow single precision on the chip are rejected here, where the field is known.
        if !(number as f32).is_finite() {
            return Err(self.error(format!("found {number:e}, too large for single precision"), expected));
        }
        Ok(number)
    }

    /// A finite number from `lo` to `hi`.
    pub(crate) fn within(&self, lo: f64, hi: f64, expected: &str) -> Result<f64, FileError> {
        let number = self.finite(expected)?;
        if (lo..=hi).contains(&number) { Ok(number) } else { Err(self.error(format!("found {number}"), expected)) }
    }

    pub(crate) fn at_least(&self, lo: f64, expected: &str) -> Result<f64, FileError> {
        self.within(lo, f64::INFINITY, expected)
    }

    /// A finite number above zero, at most `max`.
    pub(crate) fn positive_up_to(&self, max: f64, expected: &str) -> Result<f64, FileError> {
        self.within(f64::MIN_POSITIVE, max, expected)
    }

    /// A finite number above zero.
    pub(crate) fn positive(&self, expected: &str) -> Result<f64, FileError> {
        let number = self.finite(expected)?;
        if number > 0.0 { Ok(number) } else { Err(self.error(format!("found {number}"), expected)) }
    }

    /// A finite number that is zero or more.
    pub(crate) fn not_negative(&self, expected: &str) -> Result<f64, FileError> {
        let number = self.finite(expected)?;
        if number >= 0.0 { Ok(number) } else { Err(self.error(format!("found {number}"), expected)) }
    }

    /// A whole number from 0 up to `max`.
    pub(crate) fn whole(&self, max: u64, expected: &str) -> Result<u64, FileError> {
        let DeValue::Integer(integer) = self.value else {
            return Err(self.mismatch(expected));
        };
        match u64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(number) if number <= max => Ok(number),
            _ => Err(self.mismatch(expected)),
        }
    }

    /// A whole number from 1 up to `max`.
    pub(crate) fn count(&self, max: u32, expected: &str) -> Result<u32, FileError> {
        match self.whole(max.into(), expected)? {
            0 => Err(self.mismatch(expected)),
            number => Ok(number as u32),
        }
    }

    pub(crate) fn table(&self) -> Result<Table<'a>, FileError> {
        let table = self.value.as_table().ok_or_else(|| self.mismatch("a table"))?;
        Ok(Table { source: self.source, table: Some(table), span: self.span.clone(), path: self.path.clone() })
    }

    pub(crate) fn array(&self, expected: &str) -> Result<Vec<Value<'a>>, FileError> {
        let array = self.value.as_array().ok_or_else(|| self.mismatch(expected))?;
        let item = |(index, value): (usize, &'a Spanned<DeValue<'a>>)| Value {
            source: self.source,
            value: value.get_ref(),
            span: value.span(),
            path: format!("{}[{index}]", self.path),
        };
        Ok(array.iter().enumerate().map(item).collect())
    }

    /// Exactly `count` finite numbers.
    pub(crate) fn numbers(&self, count: usize, expected: &str) -> Result<Vec<f64>, FileError> {
        let items = self.array(expected)?;
        if items.len() != count {
            return Err(self.error(format!("found {}", counted(items.len(), "entry", "entries")), expected));
        }
        items.iter().map(|item| item.finite("a finite number")).collect()
    }

    pub(crate) fn vector(&self, expected: &str) -> Result<Vector3<f64>, FileError> {
        Ok(Vector3::from_column_slice(&self.numbers(3, expected)?))
    }

    /// One of a list of words, each with its value.
    pub(crate) fn choice<T: Clone>(&self, choices: &[(&str, T)]) -> Result<T, FileError> {
        self.choice_or(choices, "")
    }

    /// One of the names of a type.
    pub(crate) fn named<T: Named>(&self) -> Result<T, FileError> {
        let choices: Vec<(&str, T)> = T::NAMES.iter().map(|(name, _, value)| (*name, *value)).collect();
        self.choice(&choices)
    }

    /// One of a list of words; `otherwise` names what is accepted instead of a word.
    pub(crate) fn choice_or<T: Clone>(&self, choices: &[(&str, T)], otherwise: &str) -> Result<T, FileError> {
        let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        let found = self.string(&format!("one of {}", words.join(", ")))?;
        choices.iter().find(|(word, _)| *word == found).map(|(_, meaning)| meaning.clone()).ok_or_else(|| {
            let expected = one_of(found, &words);
            let expected = if otherwise.is_empty() { expected } else { format!("{otherwise}, or {expected}") };
            self.error(format!("found {:?}", shortened(found)), expected)
        })
    }
}

fn integer_value(digits: &str, radix: u32) -> Option<f64> {
    if radix == 10 { digits.parse().ok() } else { i64::from_str_radix(digits, radix).ok().map(|x| x as f64) }
}
