//! Memory from which code is fetched (flash with its two caches and its prefetch, or SRAM), and memory from which data come.

use crate::Program;
use crate::cycles::timing::{DATA_LINES, FLASH_LINE_BYTES, FLASH_WAIT_STATES, INSTRUCTION_LINES, Prefetched, Reading};
use std::ops::Range;

/// Location of the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// In flash, at any address.
    Flash,
    /// In SRAM, at any address: as if the same instructions had been linked there.
    Sram,
    /// Decided by each address: SRAM from 0x2000_0000 on.
    ByAddress,
}

/// The memory from which code is fetched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Location of the code.
    pub placement: Placement,
    /// Wait states of flash, cycles.
    pub wait_states: u64,
    /// First address of SRAM that stands in for the core-coupled memory, and the first behind it: the emulator has none.
    pub stand_in: (u32, u32),
}

impl Memory {
    /// Code at this location, with the wait states for 168 MHz.
    #[must_use]
    pub const fn new(placement: Placement) -> Self {
        Self { placement, wait_states: FLASH_WAIT_STATES, stand_in: (0, 0) }
    }

    /// The memory of a program: code where its addresses are, and data in the core-coupled memory where the program has a stand-in for it.
    #[must_use]
    pub fn of(program: &Program) -> Self {
        let Range { start, end } = program.stand_in_for_coupled();
        Self { stand_in: (start, end), ..Self::new(Placement::ByAddress) }
    }

    /// True if an address counts as flash.
    pub(crate) fn is_flash(self, address: u32) -> bool {
        match self.placement {
            Placement::Flash => true,
            Placement::Sram => false,
            Placement::ByAddress => address < SRAM_BEGINS,
        }
    }

    /// The memory of a literal, which is next to the code.
    pub(crate) fn of_literal(self, address: u32) -> Source {
        if self.is_flash(address) { Source::Flash(address) } else { Source::Sram }
    }

    /// The memory of data at an address in a register, by the chip's memory map. Flash is also visible at 0.
    pub(crate) fn of_data(self, address: u32) -> Source {
        let (start, end) = self.stand_in;
        if address < COUPLED_BEGINS {
            Source::Flash(address)
        } else if address < SRAM_BEGINS || (start..end).contains(&address) {
            Source::Coupled
        } else {
            Source::Sram
        }
    }
}

/// First address of SRAM.
const SRAM_BEGINS: u32 = 0x2000_0000;

/// First address of the core-coupled memory (RM0090, 2.3.1).
const COUPLED_BEGINS: u32 = 0x1000_0000;

/// The source of data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// Flash, at this address.
    Flash(u32),
    /// Core-coupled memory: no waiting, and a separate bus.
    Coupled,
    /// SRAM or a device.
    Sram,
}

/// Lines in the order of their use, the most recently used at the end.
#[derive(Clone, Debug)]
struct Lines {
    kept: Vec<u32>,
    room: usize,
}

impl Lines {
    fn new(room: usize) -> Self {
        Self { kept: Vec::with_capacity(room), room }
    }

    /// True if a line is cached; a hit makes it the most recently used.
    fn hit(&mut self, line: u32) -> bool {
        let found = self.kept.iter().position(|kept| *kept == line);
        if let Some(at) = found {
            self.kept.remove(at);
            self.kept.push(line);
        }
        found.is_some()
    }

    fn has(&self, line: u32) -> bool {
        self.kept.contains(&line)
    }

    /// Caches a line; evicts the least recently used one if the cache is full.
    fn keep(&mut self, line: u32) {
        if !self.hit(line) {
            if self.kept.len() == self.room {
                self.kept.remove(0);
            }
            self.kept.push(line);
        }
    }
}

/// Flash, its caches, and the read in progress.
///
/// Time is in cycles since the start. Flash does one read at a time. A read returns one line and takes one cycle and the wait states. There are two
/// line buffers: the line being executed, and the next one, which is fetched at the same time.
#[derive(Clone, Debug)]
pub(crate) struct Flash {
    wait_states: u64,
    instructions: Lines,
    data: Lines,
    present: Option<u32>,
    /// The line being prefetched, and its time of arrival.
    ahead: Option<(u32, u64)>,
    /// End of the present read.
    busy_until: u64,
}

impl Flash {
    pub(crate) fn new(memory: Memory) -> Self {
        Self {
            wait_states: memory.wait_states,
            instructions: Lines::new(INSTRUCTION_LINES),
            data: Lines::new(DATA_LINES),
            present: None,
            ahead: None,
            busy_until: 0,
        }
    }

    /// Cycles for which the core waits for the instruction bytes at an address.
    pub(crate) fn fetch(&mut self, address: u32, now: u64, reading: &Reading) -> u64 {
        let line = address / FLASH_LINE_BYTES;
        if self.present == Some(line) {
            return 0;
        }
        let ahead = self.ahead.filter(|(coming, _)| *coming == line);
        let stall = if self.instructions.hit(line) {
            0
        } else if let Some((_, there)) = ahead {
            // The last of these cycles belongs to the instruction itself.
            let stall = there.saturating_sub(now + 1);
            let kept = match reading.prefetched {
                Prefetched::Kept => true,
                Prefetched::KeptIfWaitedFor => stall > 0,
                Prefetched::Dropped => false,
            };
            if kept {
                self.instructions.keep(line);
            }
            stall
        } else {
            self.instructions.keep(line);
            self.read(now, reading)
        };
        self.present = Some(line);
        let next = line.wrapping_add(1);
        self.ahead = (!self.instructions.has(next)).then(|| {
            let begin = self.busy_until.max(now + stall);
            self.busy_until = begin + 1 + self.wait_states;
            (next, self.busy_until)
        });
        stall
    }

    /// Cycles for which the core waits for a literal at an address.
    pub(crate) fn load(&mut self, address: u32, now: u64, reading: &Reading) -> u64 {
        let line = address / FLASH_LINE_BYTES;
        if self.data.hit(line) {
            return 0;
        }
        self.data.keep(line);
        // The line being prefetched is still needed: its read ends first, or starts again after this one. If both want to begin, data go first.
        let takes = 1 + self.wait_states;
        match self.ahead {
            Some((next, there)) if there > now && (!reading.flash_reads_finish || there - takes >= now) => {
                let begin = if reading.flash_reads_finish { there - takes } else { now };
                let end = begin + takes;
                self.busy_until = end + takes;
                self.ahead = Some((next, self.busy_until));
                end - now - 1
            }
            _ => self.read(now, reading),
        }
    }

    /// Reads a line that is needed at once; returns the cycles until it arrives, without the one of the instruction itself.
    fn read(&mut self, now: u64, reading: &Reading) -> u64 {
        let begin = if reading.flash_reads_finish { self.busy_until.max(now) } else { now };
        self.busy_until = begin + 1 + self.wait_states;
        self.busy_until - now - 1
    }
}
