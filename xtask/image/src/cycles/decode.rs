//! Instructions of Thumb-2 with FPv4-SP, by class, registers and words.
//!
//! From the encodings of the ARMv7-M Architecture Reference Manual, chapters A5 to A7. Own code: the decoders on the crates
//! registry leave out the float unit's instructions in Thumb, and these are most of a kernel.

mod float;
mod narrow;
mod wide;

use crate::cycles::instruction::{Class, Instruction, Registers};

/// The stack pointer.
const SP: u16 = 13;
/// The link register.
const LR: u16 = 14;
/// The program counter.
const PC: u16 = 15;

/// The instruction that begins with this half; a wide one has a second.
pub(crate) fn decode(address: u32, first: u16, second: Option<u16>) -> Option<Instruction> {
    // 11101, 11110 and 11111 begin an instruction of two halves.
    if first < 0xe800 { narrow::decode(address, first) } else { wide::decode(address, first, second?) }
}

impl Instruction {
    /// An instruction that touches nothing.
    fn new(address: u32, width: u32, class: Class) -> Self {
        Self { width, class, ..Self::unknown(address) }
    }

    fn reading(mut self, registers: Registers) -> Self {
        self.reads = self.reads | registers;
        self
    }

    fn writing(mut self, registers: Registers) -> Self {
        self.writes = self.writes | registers;
        // Whatever writes the program counter branches.
        if registers.meets(Registers::core(PC)) {
            self.may_fall_through = false;
            if self.class == Class::Integer {
                self.class = Class::Branch;
            }
        }
        self
    }

    fn moving(mut self, words: u32) -> Self {
        self.words = words;
        self
    }

    fn addressed_by(mut self, registers: Registers) -> Self {
        self.address_registers = self.address_registers | registers;
        self
    }

    /// Of a place so many bytes after (or before) the program counter, which is 4 ahead and rounded down to a word.
    fn of_literal(mut self, offset: i64) -> Self {
        let from = i64::from(self.address.wrapping_add(4) & !3);
        self.literal = Some((from + offset) as u32);
        self
    }

    fn never_falls_through(mut self) -> Self {
        self.may_fall_through = false;
        self
    }
}
