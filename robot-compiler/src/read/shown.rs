//! Values of a TOML document, in the words of an error.

use toml::de::DeValue;

/// Returns "1 entry", "2 entries".
pub(crate) fn counted(count: usize, one: &str, many: &str) -> String {
    if count == 1 { format!("1 {one}") } else { format!("{count} {many}") }
}

pub(super) fn describe(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("the string {:?}", shortened(text)),
        DeValue::Integer(integer) => format!("the integer {}", shortened(integer.as_str())),
        DeValue::Float(float) => format!("the number {}", shortened(float.as_str())),
        DeValue::Boolean(value) => format!("{value}"),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(array) => format!("an array of {}", counted(array.len(), "entry", "entries")),
        DeValue::Table(_) => "a table".to_owned(),
    }
}

pub(super) fn shortened(text: &str) -> String {
    const SHOWN: usize = 40;
    if text.chars().count() <= SHOWN {
        text.to_owned()
    } else {
        text.chars().take(SHOWN).chain("...".chars()).collect()
    }
}

/// A number with at most six digits.
pub(crate) fn short(x: f64) -> String {
    rounded(x, 5).to_string()
}

/// A number with at most so many digits after its first.
pub(crate) fn rounded(x: f64, digits: usize) -> f64 {
    format!("{x:.digits$e}").parse().unwrap_or(x)
}
