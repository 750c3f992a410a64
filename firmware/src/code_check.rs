//! Comparison of the tick's code in RAM with its original in flash.
//!
//! Code in RAM can change by mistake: a bit that flips, a DMA that writes to a wrong address. The memory protection unit prevents writes of the program itself
//! ([`memory_protection`](crate::memory_protection)). All of the code is compared at the start of the program and of each session.
//! Meanwhile the lowest task compares a few words in each of its runs. After each tick there is a run, so that every word is compared within seconds. A
//! difference ends the torque as a panic does.
//!
//! Until the changed word is compared, wrong code may run: this check limits for how long.

/// Words compared per run: at 1 kHz the 6 to 18 thousand words of a tick take 2 to 5 s.
pub const WORDS: usize = 4;

/// True if two copies are equal. Cost: 12 instructions per word.
#[inline(never)]
#[must_use]
pub fn are_equal(copy: &[u32], original: &[u32]) -> bool {
    copy.iter().eq(original)
}

/// Compares a few words of two copies, from the place where the last call ended. Returns true if they differ, or if the copies are not of one length.
///
/// Cost: 14 instructions per word.
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
