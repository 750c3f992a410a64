//! A decoded instruction: its class, its registers, and its other effects.

use super::registers::{LR, PC, SP};
use super::{Class, Registers};

/// An effect of an instruction other than on registers and memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effect {
    /// No other effect.
    #[default]
    None,
    /// A jump or call to a constant address: B, BL, CBZ, CBNZ.
    Jump(u32),
    /// The lower half of a register set to a constant, the upper to zero: MOVW.
    LowerHalf(u16),
    /// The upper half of a register set to a constant: MOVT.
    UpperHalf(u16),
    /// This many bytes are subtracted from the stack pointer: PUSH, and SUB of a constant.
    Push(u32),
    /// Interrupts are masked (true) or unmasked: CPSID i, CPSIE i.
    Mask(bool),
    /// A special register with this number is written: MSR.
    ToSpecial(u16),
}

/// The address that a load or store forms: the sum of a register, optionally a shifted register, and a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Number of the base register, from 0 to 15.
    pub base: u16,
    /// Number of the register that is added, and the number of bits by which it is shifted left.
    pub index: Option<(u16, u32)>,
    /// The constant, bytes.
    pub offset: i32,
}

impl Place {
    /// Computes the address; `registers` are the values before the instruction, with the instruction's own address as the program counter.
    #[must_use]
    pub fn address(&self, registers: &[u32; 16]) -> u32 {
        let value = |number: u16| {
            let ahead = if number & 15 == PC { 4 } else { 0 };
            registers[usize::from(number & 15)].wrapping_add(ahead)
        };
        let index = self.index.map_or(0, |(number, shift)| value(number) << (shift & 31));
        value(self.base).wrapping_add(index).wrapping_add_signed(self.offset)
    }
}

/// An instruction and its address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// Address of the instruction.
    pub address: u32,
    /// Width in bytes: 2 or 4.
    pub width: u32,
    /// Timing class.
    pub class: Class,
    /// Words moved to or from memory; 0 for instructions that are not loads or stores. A byte counts as a word.
    pub words: u32,
    /// Registers read, without those of `address_registers` and `addend`.
    pub reads: Registers,
    /// Addend of a multiply-add, which is needed one cycle later than the factors.
    pub addend: Registers,
    /// Registers that form a memory address.
    pub address_registers: Registers,
    /// Registers written.
    pub writes: Registers,
    /// Address that a PC-relative load reads.
    pub literal: Option<u32>,
    /// Address that every other load or store forms; the lowest one for several words.
    pub place: Option<Place>,
    /// Its other effect.
    pub effect: Effect,
    /// True for a store with the sum of two registers as its address.
    pub register_offset: bool,
    /// True if execution may continue with the next instruction; false for an unconditional branch.
    pub may_fall_through: bool,
}

impl Instruction {
    /// An unknown instruction: counts as one cycle, with no effect on registers.
    pub(crate) const fn unknown(address: u32) -> Self {
        Self::new(address, 2, Class::System)
    }

    /// An instruction without registers.
    pub(super) const fn new(address: u32, width: u32, class: Class) -> Self {
        let none = Registers::NONE;
        Self {
            address,
            width,
            class,
            words: 0,
            reads: none,
            addend: none,
            address_registers: none,
            writes: none,
            literal: None,
            place: None,
            effect: Effect::None,
            register_offset: false,
            may_fall_through: true,
        }
    }

    /// Lowest address that a load or store accesses, with `registers` before it; `None` for other instructions.
    #[must_use]
    pub fn data_address(&self, registers: &[u32; 16]) -> Option<u32> {
        self.literal.or_else(|| self.place.map(|place| place.address(registers)))
    }

    /// Target of a call or jump to a constant address.
    #[must_use]
    pub const fn jumps_to(&self) -> Option<u32> {
        match self.effect {
            Effect::Jump(goal) => Some(goal),
            _ => None,
        }
    }

    /// True if it calls a function through a register: BLX.
    #[must_use]
    pub fn calls_register(&self) -> bool {
        self.goes_to_register() && self.writes.meets(Registers::core(LR))
    }

    /// True if it jumps to an address from a register or from memory, and is neither a call nor a return: BX, LDR to the program counter.
    #[must_use]
    pub fn jumps_to_register(&self) -> bool {
        let (counter, link) = (Registers::core(PC), Registers::core(LR));
        let loaded = self.class == Class::Load && self.literal.is_some() && self.writes.meets(counter);
        loaded || (self.goes_to_register() && !self.writes.meets(link) && !self.reads.meets(link))
    }

    fn goes_to_register(&self) -> bool {
        self.class == Class::Branch && !self.may_fall_through && self.reads.count() == 1
    }

    /// True if it changes the stack pointer by an amount that is not constant.
    #[must_use]
    pub fn moves_stack_freely(&self) -> bool {
        let pointer = Registers::core(SP);
        let computed = self.class == Class::Integer && self.writes.meets(pointer);
        // 8 and 9 are the two stack pointers, MSP and PSP.
        let special = matches!(self.effect, Effect::ToSpecial(8 | 9));
        special || (computed && self.reads.without(pointer) != Registers::NONE)
    }

    pub(super) fn with(mut self, effect: Effect) -> Self {
        self.effect = effect;
        self
    }

    pub(super) fn reading(mut self, registers: Registers) -> Self {
        self.reads = self.reads | registers;
        self
    }

    pub(super) fn writing(mut self, registers: Registers) -> Self {
        self.writes = self.writes | registers;
        // Every instruction that writes the program counter is a branch.
        if registers.meets(Registers::core(PC)) {
            self.may_fall_through = false;
            if self.class == Class::Integer {
                self.class = Class::Branch;
            }
        }
        self
    }

    pub(super) fn moving(mut self, words: u32) -> Self {
        self.words = words;
        self
    }

    pub(super) fn addressed_by(mut self, registers: Registers) -> Self {
        self.address_registers = self.address_registers | registers;
        self
    }

    /// Sets the address to the sum of a base register and a constant.
    pub(super) fn at(mut self, base: u16, offset: i64) -> Self {
        self.place = Some(Place { base: base & 15, index: None, offset: offset as i32 });
        self
    }

    /// Adds a shifted register to the address.
    pub(super) fn plus(mut self, index: u16, shift: u16) -> Self {
        self.place = self.place.map(|place| Place { index: Some((index & 15, shift.into())), ..place });
        self
    }

    /// Sets the literal at an offset in bytes from the program counter, which is 4 ahead of the instruction and rounded down to a word.
    pub(super) fn of_literal(mut self, offset: i64) -> Self {
        let from = i64::from(self.address.wrapping_add(4) & !3);
        self.literal = Some((from + offset) as u32);
        self
    }

    pub(super) fn never_falls_through(mut self) -> Self {
        self.may_fall_through = false;
        self
    }
}

/// Effect of a PC-relative jump; the program counter is 4 ahead. `bits` is the offset's width, including the sign bit.
pub(super) fn goal(address: u32, offset: u32, bits: u32) -> Effect {
    let signed = (offset << (32 - bits)) as i32 >> (32 - bits);
    Effect::Jump(address.wrapping_add(4).wrapping_add_signed(signed))
}

/// Signed byte offset: `count` times `bytes`, with its direction in bit 7 of the first half.
pub(super) fn offset(first: u16, count: u16, bytes: i64) -> i64 {
    let distance = i64::from(count) * bytes;
    if first & 0x80 == 0 { -distance } else { distance }
}
