//! What timing needs to know of an instruction.

use std::fmt;
use std::ops::BitOr;

/// What an instruction is, as far as it matters how long it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// Moves, sums, logic, shifts, bit fields, comparisons of integers.
    Integer,
    /// MUL, MLA, MLS and the long and signal-processing multiplications.
    Multiply,
    /// SDIV, UDIV.
    Divide,
    /// One core register loaded.
    Load,
    /// One core register stored.
    Store,
    /// LDM, POP, LDRD.
    LoadMultiple,
    /// STM, PUSH, STRD.
    StoreMultiple,
    /// Whatever is there to change the program counter, taken or not.
    Branch,
    /// TBB, TBH.
    TableBranch,
    /// IT.
    IfThen,
    /// VADD, VSUB, VMUL, VNMUL, VABS, VNEG.
    FloatArithmetic,
    /// VMLA, VMLS, VNMLA, VNMLS and their fused siblings.
    FloatMultiplyAdd,
    /// VDIV.
    FloatDivide,
    /// VSQRT.
    FloatSquareRoot,
    /// VCVT.
    FloatConvert,
    /// VMOV between float registers, or of a constant.
    FloatMove,
    /// VMOV between core and float registers.
    FloatTransfer,
    /// VCMP.
    FloatCompare,
    /// VMRS, VMSR.
    FloatStatus,
    /// VLDR.
    FloatLoad,
    /// VSTR.
    FloatStore,
    /// VLDM, VPOP.
    FloatLoadMultiple,
    /// VSTM, VPUSH.
    FloatStoreMultiple,
    /// DMB, DSB, ISB.
    Barrier,
    /// No operation, hints, special registers, calls of the supervisor or the debugger.
    System,
}

impl Class {
    /// Whether the float unit does it.
    #[must_use]
    pub const fn is_float(self) -> bool {
        matches!(
            self,
            Self::FloatArithmetic
                | Self::FloatMultiplyAdd
                | Self::FloatDivide
                | Self::FloatSquareRoot
                | Self::FloatConvert
                | Self::FloatMove
                | Self::FloatTransfer
                | Self::FloatCompare
                | Self::FloatStatus
                | Self::FloatLoad
                | Self::FloatStore
                | Self::FloatLoadMultiple
                | Self::FloatStoreMultiple
        )
    }

    /// Whether it reads or writes memory.
    #[must_use]
    pub const fn is_memory(self) -> bool {
        matches!(
            self,
            Self::Load
                | Self::Store
                | Self::LoadMultiple
                | Self::StoreMultiple
                | Self::TableBranch
                | Self::FloatLoad
                | Self::FloatStore
                | Self::FloatLoadMultiple
                | Self::FloatStoreMultiple
        )
    }

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Integer => "integer arithmetic, moves, comparisons",
            Self::Multiply => "integer multiplication",
            Self::Divide => "integer division",
            Self::Load => "load",
            Self::Store => "store",
            Self::LoadMultiple => "load of several registers",
            Self::StoreMultiple => "store of several registers",
            Self::Branch => "branch",
            Self::TableBranch => "branch by a table",
            Self::IfThen => "IT",
            Self::FloatArithmetic => "float sum, product, sign",
            Self::FloatMultiplyAdd => "float multiply and add",
            Self::FloatDivide => "float division",
            Self::FloatSquareRoot => "float square root",
            Self::FloatConvert => "conversion to or from float",
            Self::FloatMove => "move between float registers",
            Self::FloatTransfer => "move between core and float registers",
            Self::FloatCompare => "float comparison",
            Self::FloatStatus => "float status",
            Self::FloatLoad => "float load",
            Self::FloatStore => "float store",
            Self::FloatLoadMultiple => "load of several floats",
            Self::FloatStoreMultiple => "store of several floats",
            Self::Barrier => "barrier",
            Self::System => "no operation, special registers",
        }
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A set of registers: the core's r0 to r15 and the float unit's s0 to s31.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Registers(u64);

impl Registers {
    /// None.
    pub const NONE: Self = Self(0);
    /// How many there are, and so how many numbers [`Registers::numbers`] may give.
    pub const COUNT: usize = 48;

    /// Core register, the lowest four bits of `number`.
    #[must_use]
    pub const fn core(number: u16) -> Self {
        Self(1 << (number & 15))
    }

    /// Core registers, a bit for each.
    #[must_use]
    pub const fn core_list(bits: u16) -> Self {
        Self(bits as u64)
    }

    /// `count` float registers from `first` on; those past s31 do not exist.
    #[must_use]
    pub fn float(first: u16, count: u16) -> Self {
        (first..first.saturating_add(count))
            .filter(|number| *number < 32)
            .fold(Self::NONE, |all, s| all | Self(1 << (16 + s)))
    }

    /// Whether the two sets share a register.
    #[must_use]
    pub const fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Those of this set that are not in the other.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// How many are in the set.
    #[must_use]
    pub const fn count(self) -> u32 {
        self.0.count_ones()
    }

    /// Their numbers: 0 to 15 for the core's, 16 to 47 for the float unit's.
    pub fn numbers(self) -> impl Iterator<Item = usize> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            let number = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            (number < Self::COUNT).then_some(number)
        })
    }
}

impl BitOr for Registers {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
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
    /// The function that BL calls.
    pub calls: Option<u32>,
    /// A store whose address is the sum of two registers.
    pub register_offset: bool,
    /// Whether the program counter may go on to the next instruction: false for a branch without a condition.
    pub may_fall_through: bool,
}

impl Instruction {
    /// Something at an address that is not known: taken as one cycle, touching nothing.
    pub(crate) const fn unknown(address: u32) -> Self {
        let none = Registers::NONE;
        Self {
            address,
            width: 2,
            class: Class::System,
            words: 0,
            reads: none,
            addend: none,
            address_registers: none,
            writes: none,
            literal: None,
            calls: None,
            register_offset: false,
            may_fall_through: true,
        }
    }
}
