//! What each call of a function takes in a program that counts its calls one after another.

use crate::Program;
use crate::cycles::estimator::{Estimate, Estimator};
use crate::cycles::memory::Memory;
use crate::cycles::trace::{self, Error};
use std::ops::Range;
use std::path::Path;

/// Letters in the linker's name of the function that counts a call.
const COUNTER: &str = "Counter4call";

/// Run a program that counts its calls with `probe::Counter`, and estimate each call of the function that begins at `start`, in the
/// order of execution: from its first instruction to where it returns to, with all of it that lies in the ranges `within`. The caches
/// are as the calls before left them.
///
/// # Errors
/// Nothing in the program counts calls; else as [`trace::run`].
pub fn calls(
    elf: &Path,
    program: &Program,
    start: u32,
    within: &[Range<u32>],
    memory: Memory,
) -> Result<Vec<Estimate>, Error> {
    let back = program.behind_call_in(COUNTER).ok_or(Error::CountsNothing)?;
    let mut ranges = within.to_vec();
    ranges.push(back..back + 2);
    let mut estimator = Estimator::new(program, memory);
    let mut estimates = Vec::new();
    let mut begun = false;
    trace::run(elf, &[(start, back)], &ranges, |_, address| {
        // No instruction inside jumps back to the function's start.
        if address == start && std::mem::replace(&mut begun, true) {
            estimates.push(estimator.finish());
        }
        estimator.execute(address);
    })?;
    if begun {
        estimates.push(estimator.finish());
    }
    Ok(estimates)
}
