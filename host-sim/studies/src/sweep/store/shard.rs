//! A part of a study's runs.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Part `number` of `of`, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: u64,
    of: u64,
}

/// Largest number of shards of a study.
const SHARDS_MAX: u64 = 1_000_000;

impl Shard {
    /// The whole study as a single part.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Creates part `number` of `of`; `None` if there is no such part.
    #[must_use]
    pub fn new(number: u64, of: u64) -> Option<Self> {
        (1..=of.min(SHARDS_MAX)).contains(&number).then_some(Self { number, of }).filter(|_| of <= SHARDS_MAX)
    }

    /// Indices of this part, out of `count` runs. The parts are consecutive, and their sizes differ by at most one.
    #[must_use]
    pub fn indices(self, count: u64) -> Range<u64> {
        let end = |number: u64| (u128::from(count) * u128::from(number) / u128::from(self.of)) as u64;
        end(self.number - 1)..end(self.number)
    }

    /// True if the part is the whole.
    #[must_use]
    pub const fn is_whole(self) -> bool {
        self.of == 1
    }

    /// Its number, counted from 1, and the number of parts.
    #[must_use]
    pub const fn numbers(self) -> [u64; 2] {
        [self.number, self.of]
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        parts
            .and_then(|(number, of)| Self::new(number, of))
            .ok_or_else(|| format!("expected K/N with K from 1 to N, such as 3/50, and N at most {SHARDS_MAX}"))
    }
}

#[cfg(test)]
mod tests {
    use super::Shard;

    #[test]
    fn shards_follow_each_other_without_holes() {
        for (count, of) in [(1, 1), (10, 3), (7, 50), (1_000_000_000_000, 999_983)] {
            let mut next = 0;
            for number in 1..=of {
                let indices = Shard::new(number, of).unwrap().indices(count);
                assert!(indices.start == next && indices.end - indices.start <= count / of + 1, "{number}/{of}");
                next = indices.end;
            }
            assert_eq!(next, count);
        }
    }

    #[test]
    fn a_shard_is_read_as_it_is_written() {
        assert_eq!("3/50".parse::<Shard>().unwrap().to_string(), "3/50");
        for wrong in ["", "3", "0/5", "6/5", "-1/5", "1/0", "1/1000001", "a/b"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
