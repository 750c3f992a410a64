//! Time series as base64 of f32.
//!
//! A page draws these series and shows single values with three digits. f32 is precise enough for that (relative error 6e-8) at half the size. The
//! numbers of a summary are stored separately, in full.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

/// Base64 of the values as little-endian f32. Values that f32 cannot hold become infinite; NaN is a gap.
#[must_use]
pub fn encode(values: impl IntoIterator<Item = f64>) -> String {
    let bytes: Vec<u8> = values.into_iter().flat_map(|value| (value as f32).to_le_bytes()).collect();
    STANDARD.encode(bytes)
}

/// Decodes the values of a column; `None` if the text is not base64 of whole values.
#[must_use]
pub fn decode(text: &str) -> Option<Vec<f64>> {
    let bytes = STANDARD.decode(text).ok()?;
    let (values, rest) = bytes.as_chunks::<4>();
    rest.is_empty().then(|| values.iter().map(|value| f64::from(f32::from_le_bytes(*value))).collect())
}

/// Length in characters of a column of `rows` values.
#[must_use]
pub const fn length(rows: usize) -> usize {
    (4 * rows).div_ceil(3) * 4
}

#[cfg(test)]
mod tests {
    use super::{decode, encode, length};

    #[test]
    fn a_column_is_the_base64_of_its_bytes() {
        // 1.0 is 00 00 80 3f, and -2.0 is 00 00 00 c0.
        assert_eq!(encode([1.0, -2.0]), "AACAPwAAAMA=");
        assert_eq!(encode([]), "");
        assert_eq!(decode("AACAPwAAAMA="), Some(vec![1.0, -2.0]));
        assert_eq!((decode("AACAPw="), decode("AAA="), decode("?")), (None, None, None));
        for rows in 0..9 {
            assert_eq!(encode(vec![0.5; rows]).len(), length(rows), "{rows}");
        }
    }
}
