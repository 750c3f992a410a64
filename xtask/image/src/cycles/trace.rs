//! Trace of single instructions between given addresses.
//!
//! QEMU runs blocks of instructions and can log each block that it executes. With one instruction per block, the log has each instruction, with the
//! core's registers before it. The log goes through a pipe and is never stored, because it has about 350 bytes per instruction.

use crate::cycles::emulator::{Error, one_instruction_a_block, start};
use crate::cycles::steps::{Event, Step, read_saying};
use std::io::BufReader;
use std::ops::Range;
use std::path::Path;

/// Runs a program that ends, and calls back for each instruction between two addresses, in the order of execution.
///
/// A stretch `(start, end)` begins with the instruction at `start` and ends before the one at `end`. No other stretch begins while one lasts. The
/// number in the callback is the stretch's index in `between`.
///
/// `ranges` must contain the starts and ends, and all code in between that is to be reported. This is about ten times faster than logging the whole
/// program, because the emulator does not log the rest.
///
/// # Errors
/// The emulator cannot be started, or the program fails.
pub fn run(
    elf: &Path,
    between: &[(u32, u32)],
    ranges: &[Range<u32>],
    mut on_instruction: impl FnMut(usize, &Step),
) -> Result<(), Error> {
    let ranges: Vec<String> = ranges.iter().map(|range| format!("{:#x}+{:#x}", range.start, range.len())).collect();
    let mut options = one_instruction_a_block()?.to_vec();
    let filter = ranges.join(",");
    options.extend(["-d", "exec,cpu,nochain", "-dfilter", &filter]);
    let mut process = start(elf, &options)?;
    let mut sorter = Sorter::new(between);
    let mut said = String::new();
    if let Some(log) = process.child().stderr.take() {
        said = read_saying(BufReader::with_capacity(1 << 16, log), |event| {
            if let Event::Step(step) = event
                && let Some(stretch) = sorter.stretch(step.address)
            {
                on_instruction(stretch, &step);
            }
        })?;
    }
    let status = process.child().wait().map_err(Error::Log)?;
    if !status.success() {
        return Err(Error::GaveUp { status, said });
    }
    Ok(())
}

/// Assigns executed instructions to stretches.
struct Sorter<'a> {
    between: &'a [(u32, u32)],
    inside: Option<usize>,
}

impl<'a> Sorter<'a> {
    fn new(between: &'a [(u32, u32)]) -> Self {
        Self { between, inside: None }
    }

    /// Index of the stretch to which the next executed instruction belongs.
    fn stretch(&mut self, address: u32) -> Option<usize> {
        if let Some((_, end)) = self.inside.and_then(|inside| self.between.get(inside))
            && *end == address
        {
            self.inside = None;
        }
        if self.inside.is_none() {
            self.inside = self.between.iter().position(|(start, _)| *start == address);
        }
        self.inside
    }
}

#[cfg(test)]
mod tests {
    use super::Sorter;

    #[test]
    fn stretches_begin_with_their_start_and_end_before_their_end() {
        let between = [(10, 30), (40, 50)];
        let mut sorter = Sorter::new(&between);
        let seen = [8, 10, 12, 40, 30, 32, 40, 50, 10].map(|address| sorter.stretch(address));
        assert_eq!(seen, [None, Some(0), Some(0), Some(0), None, None, Some(1), None, Some(0)]);
    }
}
