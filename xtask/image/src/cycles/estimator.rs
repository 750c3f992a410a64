//! The estimate of a stretch of execution, an instruction at a time.

use crate::cycles::memory::Memory;
use crate::cycles::pipeline::Machine;
use crate::cycles::timing::{HIGH, LIKELY, LOW};
use crate::{Class, Instruction, Program};
use std::collections::BTreeMap;

/// Cycles by the three readings of the manuals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Range {
    /// Every choice for the best.
    pub low: u64,
    /// The most probable.
    pub likely: u64,
    /// Every choice for the worst.
    pub high: u64,
}

/// Cycles in which nothing new is begun, by their reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stalls {
    /// Instructions that flash has not yet given.
    pub fetch: u64,
    /// Numbers that flash has not yet given.
    pub literal: u64,
    /// The pipeline filled again behind a branch.
    pub refill: u64,
    /// A register that the instruction before has not yet written.
    pub result: u64,
    /// The float unit, busy.
    pub unit: u64,
    /// Instructions and data over one bus.
    pub bus: u64,
}

/// What a stretch of execution takes: an **estimate**, compared with no silicon.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Estimate {
    /// Instructions executed.
    pub instructions: u64,
    /// Of these, how many the decoder does not know; each is taken as one cycle.
    pub unknown: u64,
    /// Cycles.
    pub cycles: Range,
    /// Where the likely cycles wait.
    pub stalls: Stalls,
    /// Instructions by class.
    pub histogram: BTreeMap<Class, u64>,
}

/// Estimates cycles, an instruction at a time.
///
/// Caches and pipeline go on from one estimate to the next: the second run of the same code finds what the first has left.
///
/// ```
/// use chip_image::Program;
/// use chip_image::cycles::{Estimator, Memory, Placement};
/// // adds r0, r0, r1; adds r0, r0, r1
/// let program = Program::from_halves(0x2000_0000, &[0x1840, 0x1840]);
/// let mut estimator = Estimator::new(&program, Memory::new(Placement::ByAddress));
/// estimator.execute(0x2000_0000);
/// estimator.execute(0x2000_0002);
/// let estimate = estimator.finish();
/// assert_eq!((estimate.instructions, estimate.cycles.likely), (2, 2));
/// ```
#[derive(Clone, Debug)]
pub struct Estimator<'a> {
    program: &'a Program,
    memory: Memory,
    low: Machine,
    likely: Machine,
    high: Machine,
    /// The instruction whose successor is not yet known.
    pending: Option<(u32, Option<Instruction>)>,
    estimate: Estimate,
}

impl<'a> Estimator<'a> {
    /// A core at rest, its caches empty.
    #[must_use]
    pub fn new(program: &'a Program, memory: Memory) -> Self {
        let machine = |reading| Machine::new(reading, memory);
        Self {
            program,
            memory,
            low: machine(LOW),
            likely: machine(LIKELY),
            high: machine(HIGH),
            pending: None,
            estimate: Estimate::default(),
        }
    }

    /// The instruction at this address is executed.
    pub fn execute(&mut self, address: u32) {
        let next = self.program.decode(address);
        if let Some((at, instruction)) = self.pending.replace((address, next)) {
            self.account(at, instruction, Some((address, next)));
        }
    }

    /// What was executed since the start or the last call. Whether the last instruction branched is not known: it did if it
    /// can do nothing else.
    pub fn finish(&mut self) -> Estimate {
        if let Some((at, instruction)) = self.pending.take() {
            self.account(at, instruction, None);
        }
        let mut estimate = std::mem::take(&mut self.estimate);
        let machines = [&mut self.low, &mut self.likely, &mut self.high];
        let [low, likely, high] = machines.map(Machine::lap);
        estimate.cycles = Range { low: low.0, likely: likely.0, high: high.0 };
        estimate.stalls = likely.1;
        estimate
    }

    fn account(&mut self, at: u32, instruction: Option<Instruction>, next: Option<(u32, Option<Instruction>)>) {
        self.estimate.instructions += 1;
        let known = instruction.unwrap_or_else(|| {
            self.estimate.unknown += 1;
            Instruction::unknown(at)
        });
        if instruction.is_some() {
            *self.estimate.histogram.entry(known.class).or_default() += 1;
        }
        let taken = match next {
            Some((address, _)) => instruction.is_some() && address != at.wrapping_add(known.width),
            None => !known.may_fall_through,
        };
        let target = next.and_then(|(_, target)| target);
        for machine in [&mut self.low, &mut self.likely, &mut self.high] {
            machine.step(&known, taken, target.as_ref(), self.memory);
        }
    }
}
