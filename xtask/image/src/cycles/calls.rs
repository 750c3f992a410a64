//! Cycles of each call of a function, in a program that counts its calls one after another.

use crate::Program;
use crate::cycles::estimator::{Estimate, Estimator};
use crate::cycles::memory::Memory;
use crate::cycles::trace::{self, Error};
use std::ops::Range;
use std::path::Path;

/// Part of the linker's name of the function that counts a call.
const COUNTER: &str = "Counter4call";

/// Runs a program that counts its calls with `probe::Counter`, and estimates each call of the function at `start`, in the
/// order of execution. A call lasts from the function's first instruction to its return address, and includes all of it
/// that lies in the ranges `within`. The caches start as the calls before left them.
///
/// # Errors
/// Nothing in the program counts calls; otherwise as [`trace::run`].
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
        // No instruction inside jumps back to the function's start, so this is a new call.
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
