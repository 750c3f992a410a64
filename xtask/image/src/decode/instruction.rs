//! An instruction: its class, its registers, and what else it does.

use super::{Class, LR, PC, Registers, SP};

/// The effect of an instruction beside its registers and memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effect {
    /// None.
    #[default]
    None,
    /// A jump or call to an address that is a constant: B, BL, CBZ, CBNZ.
    Jump(u32),
    /// The lower half of a register set to a constant, the upper to zero: MOVW.
    LowerHalf(u16),
    /// The upper half of a register set to a constant: MOVT.
    UpperHalf(u16),
    /// So many bytes taken off the stack pointer: PUSH, and SUB of a constant.
    Push(u32),
    /// Interrupts masked, or no longer: CPSID i, CPSIE i.
    Mask(bool),
    /// A special register written, by its number: MSR.
    ToSpecial(u16),
}

/// An instruction at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// Where it is.
    pub address: u32,
    /// Its bytes: 2 or 4.
    pub width: u32,
    /// What it is.
    pub class: Class,
    /// Words moved to or from memory; 0 for what is no load or store. A byte counts as a word.
    pub words: u32,
    /// Registers read, without those of `address_registers` and `addend`.
    pub reads: Registers,
    /// The addend of a multiply-add, which is needed a cycle later than its factors.
    pub addend: Registers,
    /// Registers that a memory address is made of.
    pub address_registers: Registers,
    /// Registers written.
    pub writes: Registers,
    /// Where a load relative to the program counter reads.
    pub literal: Option<u32>,
    /// What else it does.
    pub effect: Effect,
    /// A store whose address is the sum of two registers.
    pub register_offset: bool,
    /// Whether the program counter may go on to the next instruction: false for a branch without a condition.
    pub may_fall_through: bool,
}

impl Instruction {
    /// Something at an address that is not known: taken as one cycle, touching nothing.
    pub(crate) const fn unknown(address: u32) -> Self {
        Self::new(address, 2, Class::System)
    }

    /// An instruction that touches nothing.
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
            effect: Effect::None,
            register_offset: false,
            may_fall_through: true,
        }
    }

    /// Where a call or jump to a constant address goes.
    #[must_use]
    pub const fn jumps_to(&self) -> Option<u32> {
        match self.effect {
            Effect::Jump(goal) => Some(goal),
            _ => None,
        }
    }

    /// Whether it calls a function whose address is in a register: BLX.
    #[must_use]
    pub fn calls_register(&self) -> bool {
        self.goes_to_register() && self.writes.meets(Registers::core(LR))
    }

    /// Whether it goes on where a register or a number in memory says, and is neither call nor return: BX, LDR to the program counter.
    #[must_use]
    pub fn jumps_to_register(&self) -> bool {
        let (counter, link) = (Registers::core(PC), Registers::core(LR));
        let loaded = self.class == Class::Load && self.literal.is_some() && self.writes.meets(counter);
        loaded || (self.goes_to_register() && !self.writes.meets(link) && !self.reads.meets(link))
    }

    fn goes_to_register(&self) -> bool {
        self.class == Class::Branch && !self.may_fall_through && self.reads.count() == 1
    }

    /// Whether the stack pointer gets a value that is not the old one and a constant.
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
        // Whatever writes the program counter branches.
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

    /// Of a place so many bytes after (or before) the program counter, which is 4 ahead and rounded down to a word.
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
