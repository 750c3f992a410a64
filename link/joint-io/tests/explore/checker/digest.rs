//! Hash of the part of a state that determines its future.
//!
//! The board's types have private fields in several packages, and more are added over time. Their `Debug` text shows every field, and
//! floating-point numbers to the last bit (the shortest text that reads back as the same number). So the text is hashed, without some fields. A
//! new field becomes part of the hash without further work; at worst, equivalent states count as different.

use core::fmt::{Debug, Write};
use core::hash::Hasher;
use rustc_hash::FxHasher;
use std::cell::RefCell;

/// Fields that are left out of the hash. This is sound because nothing that is judged here depends on them:
///
/// | fields | reason |
/// |---|---|
/// | `tick`, `taken`, `foreign` | counters for telemetry: they are sent to the host, and nothing else reads them |
/// | `left_live` | read by the firmware's loop around the session, which is not explored |
/// | `number` | numbers of requests: the host counts up, so only their order matters, and which one is the host's last (see its `arrived`) |
/// | `ring`, `next`, `waiting` | the board's memory of requests is written round and round. The host sends none again but its last: that one, the requests of this period and their verdicts are part of the judge, and the request that waits is part of the machine's inputs |
/// | `ranges` | constants of the scene |
///
/// The `Debug` text does not have constants, the black box, and the controller's own memory, which is empty without integral action, hand guiding
/// and collision detection.
const LEFT_OUT: [(&str, &str); 10] = [
    ("Session", "tick"),
    ("Session", "taken"),
    ("Session", "foreign"),
    ("Session", "left_live"),
    ("Requests", "ring"),
    ("Requests", "next"),
    ("Requests", "waiting"),
    ("NumberedRequest", "number"),
    ("Host", "number"),
    ("Electronics", "ranges"),
];

/// Counters that have no further effect above a bound: the text has the same word for all larger values. Each bound is above every limit of the
/// scenes ([`super::scene`]). In so many periods a joint can reach any position at the speed that a jump is judged by.
const BOUNDED: [(&str, &str, u64); 7] = [
    ("Inputs", "live_age", 30),
    ("MachineMemory", "settled", 30),
    ("Inputs", "heartbeat_age", 30),
    ("Inputs", "age_ticks", 30),
    ("CanJoint", "age_ticks", 30),
    ("Sensors", "age", 30),
    ("MachineMemory", "alone", 30),
];

/// Hash of a value's `Debug` text, without the fields that are left out.
#[must_use]
pub fn of(values: &[&dyn Debug]) -> u64 {
    thread_local! {
        static TEXT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    }
    TEXT.with_borrow_mut(|text| {
        text.clear();
        let mut writer = Writer::new(text);
        for value in values {
            // The writer takes everything.
            let _ = write!(writer, "{value:?}");
        }
        let mut hasher = FxHasher::default();
        hasher.write(text);
        hasher.finish()
    })
}

/// The text that [`of`] hashes, for debugging.
#[must_use]
pub fn text(value: &dyn Debug) -> String {
    let mut text = Vec::new();
    let _ = write!(Writer::new(&mut text), "{value:?}");
    String::from_utf8(text).unwrap_or_default()
}

/// Receives `Debug` text in the pieces in which the standard library's builders write it: a field's name is one piece, followed by `": "`;
/// brackets and commas are separate pieces too.
struct Writer<'a> {
    text: &'a mut Vec<u8>,
    /// Start of the last piece in the text: it may turn out to be a field's name.
    last: usize,
    /// Ranges in the text with the names of the enclosing structures.
    within: Vec<(usize, usize)>,
    /// Treatment of the field that is being written, if it is a special one, and the depth of brackets inside it.
    field: Option<(Treatment, u32)>,
}

/// Treatment of a field's value.
#[derive(Clone, Copy)]
enum Treatment {
    LeftOut,
    AtMost(u64),
}

impl Treatment {
    fn of(structure: &[u8], field: &[u8]) -> Option<Self> {
        let is = |a: &str, b: &str| a.as_bytes() == structure && b.as_bytes() == field;
        if LEFT_OUT.iter().any(|(structure, field)| is(structure, field)) {
            Some(Self::LeftOut)
        } else {
            BOUNDED.iter().find(|(structure, field, _)| is(structure, field)).map(|(.., most)| Self::AtMost(*most))
        }
    }
}

impl<'a> Writer<'a> {
    const fn new(text: &'a mut Vec<u8>) -> Self {
        Self { text, last: 0, within: Vec::new(), field: None }
    }

    /// True if this piece ends the value of a field at this depth; otherwise updates the depth.
    fn ends(depth: &mut u32, piece: &str) -> bool {
        match piece {
            " { " | "(" | "[" => *depth += 1,
            " }" | ")" | "]" if *depth == 0 => return true,
            " }" | ")" | "]" => *depth -= 1,
            ", " if *depth == 0 => return true,
            _ => {}
        }
        false
    }
}

impl Write for Writer<'_> {
    fn write_str(&mut self, piece: &str) -> core::fmt::Result {
        if let Some((treatment, depth)) = &mut self.field {
            let treatment = *treatment;
            if Self::ends(depth, piece) {
                self.field = None;
            } else {
                match treatment {
                    Treatment::LeftOut => return Ok(()),
                    Treatment::AtMost(most) if piece.parse::<u64>().is_ok_and(|count| count > most) => {
                        self.text.extend_from_slice(b"more");
                        return Ok(());
                    }
                    Treatment::AtMost(_) => {}
                }
            }
        }
        match piece {
            " { " => self.within.push((self.last, self.text.len())),
            " }" => drop(self.within.pop()),
            ": " => {
                let structure = self.within.last().map_or(&[][..], |(from, to)| &self.text[*from..*to]);
                self.field = Treatment::of(structure, &self.text[self.last..]).map(|treatment| (treatment, 0));
            }
            _ => {}
        }
        self.last = self.text.len();
        self.text.extend_from_slice(piece.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::text;

    #[derive(Debug)]
    #[allow(dead_code, reason = "read by Debug")]
    struct Inputs {
        tick: u16,
        q: [f32; 2],
        state: Option<(u8, u8)>,
        age_ticks: [u32; 2],
        heartbeat_age: u32,
    }

    #[derive(Debug)]
    #[allow(dead_code, reason = "read by Debug")]
    struct Session {
        tick: u32,
        inputs: Inputs,
        foreign: Option<[Inputs; 1]>,
        taken: u8,
        last: u8,
    }

    #[test]
    fn counters_are_left_out_or_bounded_and_everything_else_is_kept() {
        let inputs =
            |age, tick| Inputs { tick, q: [1e38, -0.0], state: Some((1, 2)), age_ticks: [0, age], heartbeat_age: age };
        let session = |age, tick| {
            let foreign = Some([inputs(1, 1)]);
            text(&Session { tick: age, inputs: inputs(age, tick), foreign, taken: 1, last: 3 })
        };
        let said = session(u32::MAX, 7);
        assert_eq!(
            said,
            "Session { tick: , inputs: Inputs { tick: 7, q: [1e38, -0.0], state: Some((1, 2)), age_ticks: [0, more], heartbeat_age: more }, foreign: , taken: , last: 3 }"
        );
        assert_eq!(said, session(77, 7));
        assert_ne!(said, session(29, 7));
        assert_ne!(said, session(77, 8));
    }
}
