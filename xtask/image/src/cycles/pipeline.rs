//! Pipeline model: cycles of an instruction, depending on those before it.

use crate::cycles::memory::{Flash, Memory, Source};
use crate::cycles::timing::{
    BusConflict, FLASH_LINE_BYTES, FLOAT_DIVIDE, FLOAT_MULTIPLY_ADD, FLOAT_TRANSFER, IfThen, REFILL_MOST, Reading,
    Refill, Transfer,
};
use crate::{Class, Instruction, Registers};

/// Cycles in which no new instruction starts, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stalls {
    /// Waiting for instructions from flash.
    pub fetch: u64,
    /// Waiting for literals from flash.
    pub literal: u64,
    /// Refill of the pipeline after a branch.
    pub refill: u64,
    /// Waiting for a result of the previous instruction.
    pub result: u64,
    /// Waiting for the busy float unit.
    pub unit: u64,
    /// Conflict of instructions and data on one bus.
    pub bus: u64,
}

/// Model of the core for one interpretation of the manuals.
#[derive(Clone, Debug)]
pub(super) struct Machine {
    reading: Reading,
    flash: Flash,
    now: u64,
    lap: u64,
    stalls: Stalls,
    /// Time from which each register can be read.
    ready: [u64; Registers::COUNT],
    /// Time from which the float unit is free.
    unit: u64,
    previous: Option<Instruction>,
}

impl Machine {
    pub(super) fn new(reading: Reading, memory: Memory) -> Self {
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

    /// Cycles and stalls since the previous call.
    pub(super) fn lap(&mut self) -> (u64, Stalls) {
        let cycles = self.now - self.lap;
        self.lap = self.now;
        (cycles, std::mem::take(&mut self.stalls))
    }

    /// Executes an instruction; `data` is the address that it loads from or stores to, if it is known.
    pub(super) fn step(
        &mut self,
        i: &Instruction,
        taken: bool,
        target: Option<&Instruction>,
        data: Option<u32>,
        memory: Memory,
    ) {
        self.fetch(i, memory);
        self.wait_for_registers(i);
        self.data(i, data, memory);
        let begin = self.now;
        self.now += self.issue(i);
        self.write_floats(i, begin);
        if taken && !matches!(i.class, Class::IfThen) {
            let mut refill = self.refill(i, target);
            if !memory.is_flash(target.map_or(i.address, |target| target.address)) {
                refill += self.reading.refill_from_sram;
            }
            self.stalls.refill += refill;
            self.now += refill;
        }
        self.previous = Some(*i);
    }

    /// Waits for all lines that contain the instruction.
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
        // Results are not forwarded to addresses. For a loaded value, the load's own time covers the wait.
        let address = self.previous.is_some_and(|before| {
            !before.class.is_memory() && before.writes.meets(i.address_registers) && !before.class.is_float()
        });
        let stall = needed.saturating_sub(self.now).max(u64::from(address));
        self.stalls.result += stall;
        self.now += stall;
    }

    /// Waits for the memory that a load reads, and for the bus.
    fn data(&mut self, i: &Instruction, data: Option<u32>, memory: Memory) {
        let source = match i.literal {
            Some(at) => memory.of_literal(at),
            None => data.map_or(Source::Sram, |at| memory.of_data(at)),
        };
        if let Source::Flash(at) = source
            && i.class.loads()
        {
            let mut stall = self.reading.literal;
            let words = i.words.max(1);
            // Each line that contains one of the words.
            let mut line = None;
            for word in (0..words).map(|word| at.wrapping_add(4 * word)) {
                if line.replace(word / FLASH_LINE_BYTES) != Some(word / FLASH_LINE_BYTES) {
                    stall += self.flash.load(word, self.now + stall, &self.reading);
                }
            }
            self.stalls.literal += stall;
            self.now += stall;
        }
        // Only SRAM and devices share the bus of code in SRAM.
        let shared = !memory.is_flash(i.address) && source == Source::Sram;
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

    /// Cycles until the next instruction may start, without stalls.
    fn issue(&self, i: &Instruction) -> u64 {
        let words = u64::from(i.words);
        let beside = |all| if self.reading.float_unit_runs_beside { 1 } else { all };
        match i.class {
            Class::Divide => self.reading.divide,
            Class::Load => 2 - self.pipelined(i),
            Class::Store if i.register_offset => 2 - self.pipelined(i),
            Class::Store => 1,
            Class::LoadMultiple if self.reading.loads_follow_all => 1 + words - u64::from(self.follows_any()),
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
            Class::FloatTransfer | Class::FloatTransferPair => match self.reading.transfer {
                Transfer::Quick => 1,
                Transfer::Beside if !is_pair_to_core(i) => 1,
                Transfer::Beside | Transfer::Whole => FLOAT_TRANSFER,
            },
            Class::FloatLoad if self.reading.float_memory_is_pipelined => 1 + words - self.pipelined(i),
            Class::FloatStore if self.reading.float_memory_is_pipelined => words,
            Class::FloatLoad | Class::FloatStore => 1 + words,
            Class::Barrier => 1 + self.reading.barrier,
            _ => 1,
        }
    }

    /// The cycle that a load or store saves after a load that does not supply its address.
    fn pipelined(&self, i: &Instruction) -> u64 {
        let behind_all = i.class == Class::Load && self.reading.loads_follow_all && self.follows_any();
        u64::from(self.previous.is_some_and(|before| {
            let single = before.class == Class::Load && before.may_fall_through
                || before.class == Class::FloatLoad && self.reading.float_memory_is_pipelined
                || behind_all;
            single && !before.writes.meets(i.address_registers)
        }))
    }

    /// True if the previous instruction moved core registers to or from memory.
    fn follows_any(&self) -> bool {
        self.previous.is_some_and(|before| {
            let moves = matches!(before.class, Class::Load | Class::Store | Class::LoadMultiple | Class::StoreMultiple);
            moves && before.may_fall_through
        })
    }

    /// Sets the times of the float unit's results, and the end of its work.
    fn write_floats(&mut self, i: &Instruction, begin: u64) {
        let beside = self.reading.transfer == Transfer::Beside;
        // Cycles in the unit, and from the unit to the registers.
        let (busy, late) = match i.class {
            Class::FloatArithmetic | Class::FloatConvert => (1, 1),
            Class::FloatMultiplyAdd => (FLOAT_MULTIPLY_ADD, 1),
            Class::FloatDivide | Class::FloatSquareRoot => (FLOAT_DIVIDE, 1),
            Class::FloatTransfer | Class::FloatTransferPair if beside => (FLOAT_TRANSFER, 0),
            _ => {
                for number in i.writes.numbers() {
                    self.ready[number] = self.now;
                }
                return;
            }
        };
        self.unit = begin + busy;
        for number in i.writes.numbers() {
            self.ready[number] = self.unit + late;
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

/// True if two float registers move to the core.
fn is_pair_to_core(i: &Instruction) -> bool {
    i.class == Class::FloatTransferPair && i.writes.numbers().any(|number| number < 16)
}
