//! Numbers of a series, and their text.

/// Root mean square of the values; zero if there are none.
pub fn rms(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count();
    libm::sqrt(ratio(values.map(|x| x * x).sum(), count as f64))
}

pub(super) fn peak(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, x| f64::max(most, x.abs()))
}

/// `part / whole`; zero if `whole` is not positive.
pub(super) fn ratio(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// Magnitude below which a number is a rounding error, in any unit.
pub(super) const NOISE: f64 = 1e-12;

/// Formats a value with three digits and a prefix from pico to kilo: `12.3 mrad`. A magnitude below 1e-12 is a rounding error: `< 1e-12 rad`.
#[must_use]
pub fn engineering(value: f64, unit: &str) -> String {
    let scales = [(1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "\u{b5}"), (1e-9, "n"), (1e-12, "p")];
    let size = value.abs();
    // The value is rounded to three digits first: 999.96e-6 becomes 1.00e-3.
    let Some((scale, prefix)) = scales.iter().find(|(scale, _)| size >= 0.999_5 * scale) else {
        return if value == 0.0 { format!("0 {unit}") } else { format!("< {NOISE:e} {unit}") };
    };
    let scaled = value / scale;
    let digits = if scaled.abs() < 9.995 { 2 } else { usize::from(scaled.abs() < 99.95) };
    format!("{scaled:.digits$} {prefix}{unit}")
}

#[cfg(test)]
mod tests {
    use super::engineering;

    #[test]
    fn numbers_read_with_three_digits_and_a_prefix() {
        let found = [0.0, 1.0, 0.012_34, 0.000_999_96, 56.78, 1234.0, -3.21e-7, 4e-15].map(|x| engineering(x, "m"));
        let expected = ["0 m", "1.00 m", "12.3 mm", "1.00 mm", "56.8 m", "1.23 km", "-321 nm", "< 1e-12 m"];
        assert_eq!(found, expected);
    }
}
