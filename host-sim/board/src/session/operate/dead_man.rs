//! A dead-man key: the arm moves only while a person holds it.
//!
//! A terminal reports a key that is held as presses that repeat: the second one comes after about half a second, the next ones about thirty times a second.
//! The key counts as held only while it repeats, so that one tap moves nothing and letting go is seen at once.

use super::keys::Presses;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Longest time between two presses of a key that is held.
const REPEATED: Duration = Duration::from_millis(250);

/// A key repeats if its last two presses are not farther apart.
const REPEATS: Duration = Duration::from_millis(200);

/// The key, as seen at the last look.
#[derive(Clone, Debug)]
pub struct DeadMan {
    presses: Presses,
    seen: u32,
    last: Option<Instant>,
    repeats: bool,
}

impl DeadMan {
    /// A key that is not held, with the counter of its presses.
    #[must_use]
    pub fn new(presses: Presses) -> Self {
        let seen = presses.load(Ordering::Relaxed);
        Self { presses, seen, last: None, repeats: false }
    }

    /// True if the key is held now.
    pub fn is_held(&mut self, now: Instant) -> bool {
        let presses = self.presses.load(Ordering::Relaxed);
        if presses != self.seen {
            let gap = self.last.map(|last| now.saturating_duration_since(last));
            self.repeats = gap.is_some_and(|gap| gap <= REPEATS);
            (self.seen, self.last) = (presses, Some(now));
        }
        self.repeats && self.last.is_some_and(|last| now.saturating_duration_since(last) <= REPEATED)
    }
}

#[cfg(test)]
mod tests {
    use super::{DeadMan, Presses};
    use std::sync::atomic::Ordering;
    use std::time::{Duration, Instant};

    #[test]
    fn a_key_is_held_while_it_repeats_and_not_longer() {
        let presses = Presses::default();
        let press = || presses.fetch_add(1, Ordering::Relaxed);
        let mut key = DeadMan::new(Presses::clone(&presses));
        let begun = Instant::now();
        let at = |ms| begun + Duration::from_millis(ms);
        assert!(!key.is_held(at(0)));
        press();
        assert!(!key.is_held(at(10)), "one press is no holding");
        press();
        assert!(!key.is_held(at(510)), "two slow ones are none either");
        for ms in (1500..2500).step_by(33) {
            press();
            assert_eq!(key.is_held(at(ms)), ms > 1500, "{ms}");
        }
        assert!(key.is_held(at(2700)) && !key.is_held(at(2760)), "it was let go");
    }
}
