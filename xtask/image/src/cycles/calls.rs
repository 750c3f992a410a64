//! Cycles of each call of functions, in a program that counts its calls one after another.

use crate::Program;
use crate::cycles::emulator::Error;
use crate::cycles::estimator::{Estimate, Estimator};
use crate::cycles::memory::Memory;
use crate::cycles::trace;
use std::collections::BTreeSet;
use std::path::Path;

/// Runs a program that counts its calls, and estimates each call of the functions at `starts`. Returns, for each function, its calls in the order of
/// execution, and for each call one estimate per memory.
///
/// All calls come from the only call through a register in the function with `counter` in its name. A call lasts from the function's first
/// instruction to its return, and includes everything that the function reaches. Nothing is executed between the calls of a function, so the next
/// call finds the caches as the previous one left them.
///
/// # Errors
/// Nothing in the program counts calls, or no function begins at one of the addresses. Otherwise those of [`trace::run`].
pub fn calls<const N: usize>(
    elf: &Path,
    program: &Program,
    counter: &str,
    starts: &[u32],
    memories: [Memory; N],
) -> Result<Vec<Vec<[Estimate; N]>>, Error> {
    let back = program.behind_call_in(counter).ok_or(Error::CountsNothing)?;
    let mut ranges = BTreeSet::from([(back, back + 2)]);
    for start in starts {
        ranges.extend(program.reached_from(*start)?.ranges().into_iter().map(|range| (range.start, range.end)));
    }
    let ranges: Vec<_> = ranges.into_iter().map(|(start, end)| start..end).collect();
    let between: Vec<_> = starts.iter().map(|start| (*start, back)).collect();
    let mut functions: Vec<Calls<'_, N>> = starts.iter().map(|start| Calls::new(program, *start, memories)).collect();
    trace::run(elf, &between, &ranges, |function, step| functions[function].execute(step.address, &step.registers))?;
    Ok(functions.into_iter().map(Calls::finish).collect())
}

/// The calls of a function.
struct Calls<'a, const N: usize> {
    start: u32,
    estimators: [Estimator<'a>; N],
    begun: bool,
    estimates: Vec<[Estimate; N]>,
}

impl<'a, const N: usize> Calls<'a, N> {
    fn new(program: &'a Program, start: u32, memories: [Memory; N]) -> Self {
        let estimators = memories.map(|memory| Estimator::new(program, memory));
        Self { start, estimators, begun: false, estimates: Vec::new() }
    }

    fn execute(&mut self, address: u32, registers: &[u32; 16]) {
        // No instruction inside jumps back to the function's start, so this is a new call.
        if address == self.start && std::mem::replace(&mut self.begun, true) {
            self.end();
        }
        for estimator in &mut self.estimators {
            estimator.execute_with(address, registers);
        }
    }

    fn end(&mut self) {
        self.estimates.push(self.estimators.each_mut().map(Estimator::finish));
    }

    fn finish(mut self) -> Vec<[Estimate; N]> {
        if self.begun {
            self.end();
        }
        self.estimates
    }
}
