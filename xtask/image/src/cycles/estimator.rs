//! Cycle estimate of a sequence of instructions.

use crate::cycles::memory::Memory;
use crate::cycles::pipeline::{Machine, Stalls};
use crate::cycles::timing::{HIGH, LIKELY, LOW, Reading};
use crate::{Class, Instruction, Program};
use std::collections::BTreeMap;

/// Cycles for the three interpretations of the manuals, from the quickest to the slowest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Range {
    /// Fewest cycles: nearly always from the best case of every choice.
    pub low: u64,
    /// Most probable cycles.
    pub likely: u64,
    /// Most cycles: nearly always from the worst case of every choice.
    pub high: u64,
}

/// Cycles of a sequence of instructions: an **estimate**, close to published cycles of other programs on silicon.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Estimate {
    /// Instructions executed.
    pub instructions: u64,
    /// Number of these that the decoder does not know; each counts as one cycle.
    pub unknown: u64,
    /// Estimated cycles.
    pub cycles: Range,
    /// Stalls within the likely cycles.
    pub stalls: Stalls,
    /// Instructions by class.
    pub histogram: BTreeMap<Class, u64>,
}

/// An instruction, and the address of its data if it is known.
#[derive(Clone, Copy, Debug)]
struct Pending {
    address: u32,
    instruction: Option<Instruction>,
    data: Option<u32>,
}

/// Estimates cycles, one instruction at a time.
///
/// Caches and pipeline carry over from one estimate to the next: a second run of the same code finds the cache as the first left it.
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
    pending: Option<Pending>,
    estimate: Estimate,
}

impl<'a> Estimator<'a> {
    /// Creates a core at rest with empty caches.
    #[must_use]
    pub fn new(program: &'a Program, memory: Memory) -> Self {
        Self::with_readings(program, memory, [LOW, LIKELY, HIGH])
    }

    /// Creates an estimator with other interpretations in place of low, likely and high, to compare them with each other.
    #[must_use]
    pub fn with_readings(program: &'a Program, memory: Memory, readings: [Reading; 3]) -> Self {
        let [low, likely, high] = readings.map(|reading| Machine::new(reading, memory));
        Self { program, memory, low, likely, high, pending: None, estimate: Estimate::default() }
    }

    /// Executes the instruction at this address. Its data are assumed to be in SRAM, unless they are a literal.
    pub fn execute(&mut self, address: u32) {
        let instruction = self.program.decode(address);
        self.start(Pending { address, instruction, data: None });
    }

    /// Executes the instruction at this address; `registers` are the core registers before it, from which the address of its data follows.
    ///
    /// ```
    /// use chip_image::Program;
    /// use chip_image::cycles::{Estimator, Memory, Placement};
    /// // ldr r5, [r4, #4]: from flash, which has 5 wait states, and from SRAM.
    /// let program = Program::from_halves(0x2000_0000, &[0x6865]);
    /// let cycles = [0x0800_0000, 0x2001_0000].map(|r4| {
    ///     let mut estimator = Estimator::new(&program, Memory::new(Placement::ByAddress));
    ///     let mut registers = [0; 16];
    ///     registers[4] = r4;
    ///     estimator.execute_with(0x2000_0000, &registers);
    ///     estimator.finish().cycles.low
    /// });
    /// assert_eq!(cycles, [2 + 5, 2]);
    /// ```
    pub fn execute_with(&mut self, address: u32, registers: &[u32; 16]) {
        let instruction = self.program.decode(address);
        let data = instruction.and_then(|instruction| instruction.data_address(registers));
        self.start(Pending { address, instruction, data });
    }

    fn start(&mut self, next: Pending) {
        if let Some(before) = self.pending.replace(next) {
            self.account(&before, Some(&next));
        }
    }

    /// Returns the estimate of everything executed since the start or the last call. It is unknown if the last instruction branched, so it counts as
    /// a branch only if it always branches.
    pub fn finish(&mut self) -> Estimate {
        if let Some(last) = self.pending.take() {
            self.account(&last, None);
        }
        let mut estimate = std::mem::take(&mut self.estimate);
        let machines = [&mut self.low, &mut self.likely, &mut self.high];
        let [low, likely, high] = machines.map(Machine::lap);
        // The best choices may give more cycles in total, because a line that is kept evicts another. So the range is taken over all three.
        let all = [low.0, likely.0, high.0];
        let (least, most) =
            all.iter().fold((likely.0, likely.0), |(least, most), cycles| (least.min(*cycles), most.max(*cycles)));
        estimate.cycles = Range { low: least, likely: likely.0, high: most };
        estimate.stalls = likely.1;
        estimate
    }

    fn account(&mut self, this: &Pending, next: Option<&Pending>) {
        let Pending { address, instruction, data } = *this;
        self.estimate.instructions += 1;
        let known = instruction.unwrap_or_else(|| {
            self.estimate.unknown += 1;
            Instruction::unknown(address)
        });
        if instruction.is_some() {
            *self.estimate.histogram.entry(known.class).or_default() += 1;
        }
        let taken = match next {
            Some(next) => instruction.is_some() && next.address != address.wrapping_add(known.width),
            None => !known.may_fall_through,
        };
        let target = next.and_then(|next| next.instruction);
        for machine in [&mut self.low, &mut self.likely, &mut self.high] {
            machine.step(&known, taken, target.as_ref(), data, self.memory);
        }
    }
}
