//! Comparison of the tick's code in RAM with its original in flash.
//!
//! Code in RAM can change by mistake: a write to a wrong address, a bit that flips. All of it is compared at the start of the program and of each session.
//! Meanwhile the lowest task compares a few words in each of its runs. After each tick there is a run, so that every word is compared within seconds. A
//! difference ends the torque as a panic does.
//!
//! Until the changed word is compared, wrong code may run: this check limits for how long.

/// Words compared per run: at 1 kHz the 10 to 17 thousand words of a tick take 3 to 4 s.
pub const WORDS: usize = 4;

/// True if two copies are equal. Cost: 6 instructions per word.
#[inline(never)]
#[must_use]
pub fn are_equal(copy: &[u32], original: &[u32]) -> bool {
    copy.iter().eq(original)
}

/// Compares a few words of two copies, from the place where the last call ended. Returns true if they differ, or if the copies are not of one length.
///
/// Cost: 12 instructions per word.
#[inline]
pub fn differs(place: &mut usize, copy: &[u32], original: &[u32]) -> bool {
    for _ in 0..WORDS {
        // An index beyond either end is `None`.
        if copy.get(*place) != original.get(*place) {
            return true;
        }
        *place = if *place + 1 < copy.len().max(original.len()) { *place + 1 } else { 0 };
    }
    false
}

#[cfg(test)]
mod tests {
    use super::{WORDS, are_equal, differs};

    /// Number of calls after which a difference is found; `None` if there is none in twice as many as all words need.
    fn found_after(copy: &[u32], original: &[u32]) -> Option<usize> {
        let mut place = 0;
        (0..2 * original.len().div_ceil(WORDS)).find(|_| differs(&mut place, copy, original))
    }

    #[test]
    fn each_bit_of_each_word_is_compared_in_one_round() {
        let original: Vec<u32> = (0..10).map(|i| 0x0101_0101 * i).collect();
        assert_eq!(found_after(&original, &original), None);
        assert!(are_equal(&original, &original) && !are_equal(&original, &original[1..]));
        for (place, bit) in (0..10).flat_map(|place| (0..32).map(move |bit| (place, bit))) {
            let mut copy = original.clone();
            copy[place] ^= 1 << bit;
            assert_eq!(found_after(&copy, &original), Some(place / WORDS), "bit {bit} of word {place}");
            assert!(!are_equal(&copy, &original), "bit {bit} of word {place}");
        }
    }

    #[test]
    fn copies_of_two_lengths_differ_and_no_code_is_equal_to_itself() {
        assert!(found_after(&[1, 2, 3], &[1, 2, 3, 4]).is_some() && found_after(&[1, 2, 3, 4], &[1, 2, 3]).is_some());
        let mut place = 0;
        assert!((0..3).all(|_| !differs(&mut place, &[], &[])) && place == 0);
    }
}
