//! Classes of instructions, by their timing.

use std::fmt;

/// Class of an instruction, as far as its timing depends on it.
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
    /// Every other instruction that may change the program counter, taken or not.
    Branch,
    /// TBB, TBH.
    TableBranch,
    /// IT.
    IfThen,
    /// VADD, VSUB, VMUL, VNMUL, VABS, VNEG.
    FloatArithmetic,
    /// VMLA, VMLS, VNMLA, VNMLS and their fused variants.
    FloatMultiplyAdd,
    /// VDIV.
    FloatDivide,
    /// VSQRT.
    FloatSquareRoot,
    /// VCVT.
    FloatConvert,
    /// VMOV between float registers, or of a constant.
    FloatMove,
    /// VMOV between a core and a float register.
    FloatTransfer,
    /// VMOV between two core registers and two float registers.
    FloatTransferPair,
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
    /// True if the float unit executes it.
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
                | Self::FloatTransferPair
                | Self::FloatCompare
                | Self::FloatStatus
                | Self::FloatLoad
                | Self::FloatStore
                | Self::FloatLoadMultiple
                | Self::FloatStoreMultiple
        )
    }

    /// True if it reads memory.
    #[must_use]
    pub const fn loads(self) -> bool {
        matches!(self, Self::Load | Self::LoadMultiple | Self::TableBranch | Self::FloatLoad | Self::FloatLoadMultiple)
    }

    /// True if it reads or writes memory.
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

    /// Name in tables.
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
            Self::FloatTransfer => "move between a core and a float register",
            Self::FloatTransferPair => "move between two core and two float registers",
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
