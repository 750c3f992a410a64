//! The pipeline: what an instruction takes behind those before it.

use crate::cycles::code::Code;
use crate::cycles::instruction::{Class, Instruction, Registers};
use crate::cycles::memory::{Flash, Memory};
use crate::cycles::timing::{
    BusConflict, FLOAT_DIVIDE, FLOAT_MULTIPLY_ADD, HIGH, IfThen, LIKELY, LOW, REFILL_MOST, Reading, Refill,
};
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

impl Stalls {
    /// All together.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.fetch + self.literal + self.refill + self.result + self.unit + self.bus
    }
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
/// use chip_image::cycles::{Code, Estimator, Memory, Placement};
/// // adds r0, r0, r1; adds r0, r0, r1
/// let code = Code::from_halves(0x2000_0000, &[0x1840, 0x1840]);
/// let mut estimator = Estimator::new(&code, Memory::new(Placement::ByAddress));
/// estimator.execute(0x2000_0000);
/// estimator.execute(0x2000_0002);
/// let estimate = estimator.finish();
/// assert_eq!((estimate.instructions, estimate.cycles.likely), (2, 2));
/// ```
#[derive(Clone, Debug)]
pub struct Estimator<'a> {
    code: &'a Code,
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
    pub fn new(code: &'a Code, memory: Memory) -> Self {
        let machine = |reading| Machine::new(reading, memory);
        Self {
            code,
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
        let next = self.code.decode(address);
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

/// The core under one reading of the manuals.
#[derive(Clone, Debug)]
struct Machine {
    reading: Reading,
    flash: Flash,
    now: u64,
    lap: u64,
    stalls: Stalls,
    /// When each register may be read.
    ready: [u64; Registers::COUNT],
    /// When the float unit is free.
    unit: u64,
    previous: Option<Instruction>,
}

impl Machine {
    fn new(reading: Reading, memory: Memory) -> Self {
        Self {
            reading,
            flash: Flash::new(memory),
            now: 0,
            lap: 0,
            stalls: Stalls::default(),
            ready: [0; Registers::COUNT],
            unit: 0,
            previous: None,
        }
    }

    /// Cycles and stalls since the last lap.
    fn lap(&mut self) -> (u64, Stalls) {
        let cycles = self.now - self.lap;
        self.lap = self.now;
        (cycles, std::mem::take(&mut self.stalls))
    }

    fn step(&mut self, i: &Instruction, taken: bool, target: Option<&Instruction>, memory: Memory) {
        self.fetch(i, memory);
        self.wait_for_registers(i);
        self.data(i, memory);
        let begin = self.now;
        self.now += self.issue(i);
        self.write_floats(i, begin);
        if taken && !matches!(i.class, Class::IfThen) {
            let refill = self.refill(i, target);
            self.stalls.refill += refill;
            self.now += refill;
        }
        self.previous = Some(*i);
    }

    /// Wait for all lines that the instruction lies in.
    fn fetch(&mut self, i: &Instruction, memory: Memory) {
        for half in [i.address, i.address.wrapping_add(i.width - 2)] {
            if memory.is_flash(half) {
                let stall = self.flash.fetch(half, self.now, &self.reading);
                self.stalls.fetch += stall;
                self.now += stall;
            }
        }
    }

    fn wait_for_registers(&mut self, i: &Instruction) {
        if i.class.is_float() {
            let stall = self.unit.saturating_sub(self.now);
            self.stalls.unit += stall;
            self.now += stall;
        }
        let when = |registers: Registers| registers.numbers().map(|number| self.ready[number]).max().unwrap_or(0);
        let addend = when(i.addend).saturating_sub(1);
        let needed = when(i.reads | i.address_registers).max(addend);
        // No way forward from a result to an address, but for what was loaded, whose own time covers it.
        let address = self.previous.is_some_and(|before| {
            !before.class.is_memory() && before.writes.meets(i.address_registers) && !before.class.is_float()
        });
        let stall = needed.saturating_sub(self.now).max(u64::from(address));
        self.stalls.result += stall;
        self.now += stall;
    }

    /// Wait for the memory that a load reads, and for the bus.
    fn data(&mut self, i: &Instruction, memory: Memory) {
        if let Some(at) = i.literal
            && memory.is_flash(at)
        {
            let first = self.flash.load(at, self.now, &self.reading);
            let last = at.wrapping_add(4 * i.words.saturating_sub(1));
            let second = self.flash.load(last, self.now + first, &self.reading);
            let stall = first + second + self.reading.literal;
            self.stalls.literal += stall;
            self.now += stall;
        }
        // Data of the flash come over a bus of their own.
        let shared = !memory.is_flash(i.address) && i.literal.is_none_or(|at| !memory.is_flash(at));
        if i.words > 0 && shared {
            let stall = match self.reading.bus_conflict {
                BusConflict::Hidden => 0,
                BusConflict::EachInstruction => 1,
                BusConflict::EachWord => u64::from(i.words),
            };
            self.stalls.bus += stall;
            self.now += stall;
        }
    }

    /// Cycles until the next instruction may begin, if nothing holds it up.
    fn issue(&self, i: &Instruction) -> u64 {
        let words = u64::from(i.words);
        let beside = |all| if self.reading.float_unit_runs_beside { 1 } else { all };
        match i.class {
            Class::Divide => self.reading.divide,
            Class::Load => 2 - self.pipelined(i),
            Class::Store if i.register_offset => 2 - self.pipelined(i),
            Class::Store => 1,
            Class::LoadMultiple | Class::StoreMultiple | Class::FloatLoadMultiple | Class::FloatStoreMultiple => {
                1 + words
            }
            Class::TableBranch => 3,
            Class::IfThen => {
                let narrow = self.previous.is_some_and(|before| before.width == 2);
                match self.reading.if_then {
                    IfThen::Folded => 0,
                    IfThen::BehindNarrow if narrow => 0,
                    _ => 1,
                }
            }
            Class::FloatMultiplyAdd => beside(FLOAT_MULTIPLY_ADD),
            Class::FloatDivide | Class::FloatSquareRoot => beside(FLOAT_DIVIDE),
            Class::FloatTransfer => self.reading.transfer,
            Class::FloatLoad if self.reading.float_memory_is_pipelined => 1 + words - self.pipelined(i),
            Class::FloatStore if self.reading.float_memory_is_pipelined => words,
            Class::FloatLoad | Class::FloatStore => 1 + words,
            Class::Barrier => 1 + self.reading.barrier,
            _ => 1,
        }
    }

    /// The cycle that a load or store saves behind a load that does not give its address.
    fn pipelined(&self, i: &Instruction) -> u64 {
        u64::from(self.previous.is_some_and(|before| {
            let single = before.class == Class::Load && before.may_fall_through
                || before.class == Class::FloatLoad && self.reading.float_memory_is_pipelined;
            single && !before.writes.meets(i.address_registers)
        }))
    }

    /// The float unit's results, and until when it is busy.
    fn write_floats(&mut self, i: &Instruction, begin: u64) {
        let busy = match i.class {
            Class::FloatArithmetic | Class::FloatConvert => 1,
            Class::FloatMultiplyAdd => FLOAT_MULTIPLY_ADD,
            Class::FloatDivide | Class::FloatSquareRoot => FLOAT_DIVIDE,
            _ => {
                for number in i.writes.numbers() {
                    self.ready[number] = self.now;
                }
                return;
            }
        };
        self.unit = begin + busy;
        for number in i.writes.numbers() {
            self.ready[number] = self.unit + 1;
        }
    }

    fn refill(&self, i: &Instruction, target: Option<&Instruction>) -> u64 {
        if i.class.is_memory() {
            return REFILL_MOST;
        }
        match self.reading.refill {
            Refill::Always(cycles) => cycles,
            Refill::ByTarget => {
                let two_fetches = target.is_some_and(|target| target.width == 4 && target.address & 2 != 0);
                2 + u64::from(two_fetches)
            }
        }
    }
}
