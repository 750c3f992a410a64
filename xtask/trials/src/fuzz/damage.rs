//! Damaged inputs made from good ones. The same seed gives the same inputs.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Generator of damaged inputs.
pub struct Damage {
    random: ChaCha8Rng,
    words: Vec<Vec<u8>>,
}

/// Nested brackets, tables, names and elements of this depth. The parsers that our readers use are recursive, so too deep a nesting must be rejected
/// before it reaches them.
#[must_use]
pub fn nested(depth: usize) -> [Vec<u8>; 4] {
    [
        format!("name = {}{}", "[".repeat(depth), "]".repeat(depth)),
        format!("name = {}{}", "{a=".repeat(depth), "}".repeat(depth)),
        format!("{} = 1", "a.".repeat(depth) + "a"),
        format!("<robot>{}{}</robot>", "<a>".repeat(depth), "</a>".repeat(depth)),
    ]
    .map(String::into_bytes)
}

/// Kind of damage to the bytes of an input.
enum Kind {
    Flip,
    Truncate,
    Delete,
    Repeat,
    Word,
    Number,
}

/// The kinds with their frequencies. Small changes are more frequent, because readers get further into such an input.
const KINDS: [Kind; 14] = [
    Kind::Flip,
    Kind::Flip,
    Kind::Flip,
    Kind::Truncate,
    Kind::Delete,
    Kind::Delete,
    Kind::Repeat,
    Kind::Repeat,
    Kind::Word,
    Kind::Word,
    Kind::Word,
    Kind::Number,
    Kind::Number,
    Kind::Number,
];

/// Longest stretch that is deleted or repeated, and longest noise.
const STRETCH: usize = 60;
const NOISE: usize = 600;

impl Damage {
    /// Creates a generator that also inserts words of a dictionary.
    #[must_use]
    pub fn new(seed: u64, dictionary: &str) -> Self {
        let words = dictionary.lines().filter_map(|line| Some(plain(line.strip_prefix('"')?.strip_suffix('"')?)));
        Self { random: ChaCha8Rng::seed_from_u64(seed), words: words.collect() }
    }

    /// One of the examples with one to four kinds of damage; every sixteenth input is pure noise.
    pub fn next_input(&mut self, examples: &[Vec<u8>]) -> Vec<u8> {
        if examples.is_empty() || self.below(16) == 0 {
            return (0..self.below(NOISE)).map(|_| self.random.next_u32() as u8).collect();
        }
        let mut bytes = examples[self.below(examples.len())].clone();
        for _ in 0..=self.below(4) {
            self.apply(&mut bytes);
        }
        bytes
    }

    fn apply(&mut self, bytes: &mut Vec<u8>) {
        let at = self.below(bytes.len().max(1)).min(bytes.len());
        let stretch = at..(at + 1 + self.below(STRETCH)).min(bytes.len());
        match KINDS[self.below(KINDS.len())] {
            Kind::Flip => {
                let byte = self.random.next_u32() as u8;
                bytes.splice(at..(at + 1).min(bytes.len()), [byte]);
            }
            Kind::Truncate => bytes.truncate(at),
            Kind::Delete => drop(bytes.drain(at.min(stretch.end)..stretch.end)),
            Kind::Repeat => {
                let again = bytes[at.min(stretch.end)..stretch.end].to_vec();
                bytes.splice(stretch.end..stretch.end, again);
            }
            Kind::Word if self.words.is_empty() => {}
            Kind::Word => {
                let number = self.below(self.words.len());
                bytes.splice(at..at, self.words[number].iter().copied());
            }
            Kind::Number => {
                // All bit patterns of a double are equally likely, so tiny, huge, infinite and NaN values come often.
                let number = format!("{:?}", f64::from_bits(self.random.next_u64()));
                let digit = |byte: &u8| byte.is_ascii_digit();
                let Some(start) = bytes[at..].iter().position(digit).map(|from| at + from) else { return };
                let more = |byte: &u8| !byte.is_ascii_digit() && !b".-e".contains(byte);
                let end = bytes[start..].iter().position(more).map_or(bytes.len(), |length| start + length);
                bytes.splice(start..end, number.bytes());
            }
        }
    }

    fn below(&mut self, bound: usize) -> usize {
        // The distribution is uneven by less than 1 in 2^32, which is negligible here.
        (self.random.next_u64() % bound as u64) as usize
    }
}

/// Bytes of a dictionary word: `\\xNN` is a byte, and any other character after a backslash is itself.
fn plain(mut word: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    while let Some((before, behind)) = word.split_once('\\') {
        let hex = behind.strip_prefix('x').and_then(|digits| digits.split_at_checked(2));
        let (byte, rest) = match hex.and_then(|(digits, rest)| Some((u8::from_str_radix(digits, 16).ok()?, rest))) {
            Some((byte, rest)) => (Some(byte), rest),
            None => (behind.bytes().next(), behind.get(1..).unwrap_or_default()),
        };
        bytes.extend(before.bytes().chain(byte));
        word = rest;
    }
    bytes.extend(word.bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::Damage;

    #[test]
    fn a_dictionary_is_read_as_libfuzzer_reads_it() {
        let words = Damage::new(0, "\"a\\x0ab\"\n# a remark\n\"\\\"\"\n\"\\\\u0000\"\n").words;
        assert_eq!(words, ["a\nb", "\"", "\\u0000"].map(|word| word.as_bytes().to_vec()));
    }
}
