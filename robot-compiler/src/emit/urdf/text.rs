//! Numbers and names in the form of an attribute.

/// The shortest decimals that read back as the same numbers; no negative zero.
pub(super) fn numbers(numbers: &[f64]) -> String {
    numbers.iter().map(|x| number(*x)).collect::<Vec<_>>().join(" ")
}

pub(super) fn number(x: f64) -> String {
    format!("{:?}", x + 0.0)
}

/// Text of an attribute in double quotes.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
