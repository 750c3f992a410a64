//! The part of a state that decides its future, as a hash.
//!
//! The board's types hold private fields in several packages, and gain more of them. Their `Debug` text shows every field, and floating-point
//! numbers to the last bit (the shortest text that reads back as the same number). So the text is hashed, less some fields. A new field is part
//! of the hash without further work: at worst, states that are alike are told apart.

use core::fmt::{Debug, Write};
use core::hash::Hasher;
use rustc_hash::FxHasher;
use std::cell::RefCell;

/// Fields that are left out, and why this is sound: nothing that is judged here depends on them.
///
/// | fields | reason |
/// |---|---|
/// | `tick`, `taken`, `counts`, `buses` | counters for telemetry: they are sent to the host, and nothing else reads them |
/// | `own`, `config`, `safety_config`, `drives`, `order`, `ranges`, `observer` | constants of the scene |
/// | `cost` | always absent: no counter runs |
const LEFT_OUT: [&str; 10] =
    ["tick", "taken", "counts", "buses", "own", "drives", "order", "ranges", "cost", "frames"];

/// Counters that act only up to a bound, and count on beyond it: the text has the lower of count and bound. The bounds are above every limit of
/// the scenes ([`crate::scene`]), so a count at its bound acts as any greater one.
const BOUNDED: [(&str, u64); 4] = [("heartbeat_age", 60), ("age_ticks", 24), ("age", 24), ("alone", 60)];

/// Hash of a value's `Debug` text, without the fields that are left out.
#[must_use]
pub fn of(values: &[&dyn Debug]) -> u64 {
    thread_local! {
        static TEXT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    }
    TEXT.with_borrow_mut(|text| {
        text.clear();
        let mut writer = Writer { text, held: String::new(), skip: None, bound: None };
        for value in values {
            // The writer takes everything.
            let _ = write!(writer, "{value:?}");
            writer.release();
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
    let mut writer = Writer { text: &mut text, held: String::new(), skip: None, bound: None };
    let _ = write!(writer, "{value:?}");
    writer.release();
    String::from_utf8(text).unwrap_or_default()
}

/// Receives `Debug` text in the pieces in which the standard library's builders write it: a field's name is a piece of its own, followed by
/// `": "`; so are brackets and commas.
struct Writer<'a> {
    text: &'a mut Vec<u8>,
    /// A piece that may turn out to be a field's name.
    held: String,
    /// Depth of brackets inside of a field that is left out.
    skip: Option<u32>,
    /// Depth of brackets inside of a field with a bound, and the bound.
    bound: Option<(u32, u64)>,
}

impl Writer<'_> {
    fn release(&mut self) {
        if self.skip.is_none() {
            self.text.extend_from_slice(self.held.as_bytes());
        }
        self.held.clear();
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
        if let Some(depth) = &mut self.skip {
            if !Self::ends(depth, piece) {
                return Ok(());
            }
            self.skip = None;
        }
        if let Some((depth, most)) = &mut self.bound {
            let most = *most;
            if Self::ends(depth, piece) {
                self.bound = None;
            } else if let Ok(count) = piece.parse::<u64>() {
                self.release();
                return write!(self.text_writer(), "{}", count.min(most));
            }
        }
        if piece == ": " {
            if LEFT_OUT.contains(&self.held.as_str()) {
                self.held.clear();
                self.skip = Some(0);
                return Ok(());
            }
            self.bound = BOUNDED.iter().find(|(name, _)| *name == self.held).map(|(_, most)| (0, *most)).or(self.bound);
        }
        self.release();
        self.held.push_str(piece);
        Ok(())
    }
}

impl Writer<'_> {
    fn text_writer(&mut self) -> Plain<'_> {
        Plain(self.text)
    }
}

/// Text without any change.
struct Plain<'a>(&'a mut Vec<u8>);

impl Write for Plain<'_> {
    fn write_str(&mut self, piece: &str) -> core::fmt::Result {
        self.0.extend_from_slice(piece.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::text;

    #[derive(Debug)]
    #[allow(dead_code, reason = "read by Debug")]
    struct Inner {
        taken: u16,
        q: [f32; 2],
        state: Option<(u8, u8)>,
        age_ticks: [u32; 2],
        heartbeat_age: u32,
    }

    #[derive(Debug)]
    #[allow(dead_code, reason = "read by Debug")]
    struct Outer {
        tick: u32,
        inner: Inner,
        counts: Option<[Inner; 1]>,
        last: u8,
    }

    #[test]
    fn counters_are_left_out_or_bounded_and_everything_else_is_kept() {
        let inner = |age, taken| Inner {
            taken,
            q: [0.1, -0.0],
            state: Some((1, 2)),
            age_ticks: [0, age],
            heartbeat_age: age,
        };
        let outer = |age, taken| Outer { tick: age, inner: inner(age, taken), counts: Some([inner(1, 1)]), last: 3 };
        let said = text(&outer(u32::MAX, 7));
        assert_eq!(
            said,
            "Outer { , inner: Inner { , q: [0.1, -0.0], state: Some((1, 2)), age_ticks: [0, 24], heartbeat_age: 60 }, , last: 3 }"
        );
        assert_eq!(said, text(&outer(77, 9)));
        assert_ne!(said, text(&outer(23, 9)));
    }
}
