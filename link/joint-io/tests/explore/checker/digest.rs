//! The part of a state that decides its future, as a hash.
//!
//! The board's types hold private fields in several packages, and gain more of them. Their `Debug` text shows every field, and floating-point
//! numbers to the last bit (the shortest text that reads back as the same number). So the text is hashed, less some fields. A new field is part
//! of the hash without further work: at worst, states that are alike are told apart.

use core::fmt::{Debug, Write};
use core::hash::Hasher;
use rustc_hash::FxHasher;
use std::cell::RefCell;

/// Fields of structures that are left out, and why this is sound: nothing that is judged here depends on them.
///
/// | fields | reason |
/// |---|---|
/// | `tick`, `taken`, `foreign`, `counts`, `buses` | counters for telemetry: they are sent to the host, and nothing else reads them |
/// | `left_live` | read by the firmware's loop around the session, which is not explored |
/// | `number` | numbers of requests: the host's count up, so only their order acts, and which of them is the host's last, which the host's `arrived` tells |
/// | `ring`, `next`, `waiting` | the board's memory of requests is written round and round. The host sends none again but its last: that one, the requests of this period and their verdicts are part of the judge, and the request that waits is part of the machine's inputs |
/// | `ranges` | constants of the scene |
///
/// Not in the text at all: constants, the black box, and the controller's own memory, which is empty without integral action, hand guiding and
/// collision detection.
const LEFT_OUT: [(&str, &str); 12] = [
    ("Session", "tick"),
    ("Session", "taken"),
    ("Session", "foreign"),
    ("Session", "left_live"),
    ("Requests", "ring"),
    ("Requests", "next"),
    ("Requests", "waiting"),
    ("NumberedRequest", "number"),
    ("Host", "number"),
    ("CanJoints", "buses"),
    ("Joint", "counts"),
    ("Electronics", "ranges"),
];

/// Counters that act only up to a bound, and count on beyond it: the text has a word for all beyond. Each bound is above every limit of the
/// scenes ([`super::scene`]), and in so many periods a joint can go anywhere at the speed that a jump is judged by.
const BOUNDED: [(&str, &str, u64); 7] = [
    ("Inputs", "live_age", 30),
    ("Memory", "settled", 30),
    ("Inputs", "heartbeat_age", 30),
    ("Inputs", "age_ticks", 30),
    ("Joint", "age_ticks", 30),
    ("Sensors", "age", 30),
    ("Memory", "alone", 30),
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

/// The text that [`of`] hashes, for a person.
#[must_use]
pub fn text(value: &dyn Debug) -> String {
    let mut text = Vec::new();
    let _ = write!(Writer::new(&mut text), "{value:?}");
    String::from_utf8(text).unwrap_or_default()
}

/// Receives `Debug` text in the pieces in which the standard library's builders write it: a field's name is a piece of its own, followed by
/// `": "`; so are brackets and commas.
struct Writer<'a> {
    text: &'a mut Vec<u8>,
    /// Where the last piece begins in the text: it may turn out to be a field's name.
    last: usize,
    /// Where in the text the names of the structures are that the writer is inside of.
    within: Vec<(usize, usize)>,
    /// The field whose value is being written, where it is treated differently, and the depth of brackets inside of it.
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

    /// True where this piece ends the value of a field at the depth; else the depth is updated.
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
