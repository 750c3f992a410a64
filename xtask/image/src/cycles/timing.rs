//! Every number of the estimate, with its source.
//!
//! | rule | cycles | source |
//! |---|---|---|
//! | integer arithmetic, all multiplications | 1 | TRM 3.3, checked in TI |
//! | SDIV, UDIV | 2 to 12, depending on the operands | TRM 3.3, checked in TI |
//! | load | 2; 1 after a load that does not supply its address | TRM 3.3.3, checked in TI |
//! | store | 1; 2 at the sum of two registers, 1 of these after a load | TRM 3.3.3, checked in TI |
//! | load, store of N registers | 1 + N, never pipelined with its neighbours | TRM 3.3, not checked |
//! | an address from the previous instruction, unless that is a load | 1 more | TRM 3.3.3, checked in TI |
//! | branch taken | 1 + P, P from 1 to 3; not taken 1 | TRM 3.3, checked in TI; P from 2 to 3 published |
//! | load of the program counter, branch by a table | 2 + 3, 3 + 3 at least | TRM 3.3.3, checked in TI |
//! | branch taken, target in SRAM | 0 to 2 more, probably 1 | RM0402 2.3, of a sibling chip, recommends address 0 instead of the system bus, without a number |
//! | IT | 1, or 0 folded into a narrow instruction before it | TRM 3.3, not checked |
//! | barrier | 1 + B, B at least 0 | TRM 3.3, for the Cortex-M3 checked |
//! | VADD, VSUB, VMUL, VNMUL, VABS, VNEG, VCMP, VCVT, VMRS, VMSR, VMOV of floats | 1 | TRM 7.2, checked in TI |
//! | VMLA and its variants | 3 | TRM 7.2, checked in TI and GCC |
//! | VDIV, VSQRT | 14 | TRM 7.2, VDIV checked in TI, both in GCC |
//! | VMOV between core and float registers | 1, the float unit 2 | published; TRM 7.2 has 2 for some, as have TI and GCC for all |
//! | VMOV of two float registers to the core | 2 | TRM 7.2, checked in TI and GCC, published |
//! | VLDR, VSTR of one float | 2, never pipelined | VLDR checked in TI, VSTR not; published; GCC pipelines both, and has 1 for VSTR |
//! | VLDR, VSTR of two floats | 3 | VLDR checked in TI, both in GCC |
//! | VLDM, VSTM, VPUSH, VPOP of N floats | 1 + N | TRM 7.2, VLDM and VPOP checked in TI |
//! | a float result that the next instruction needs | 1 more; none as the addend of a multiply-add | TRM 7.2, checked in GCC |
//! | core instructions during VDIV, VSQRT, VMLA | continue | TRM 7.2, checked in GCC |
//! | flash at 168 MHz, 3.3 V | 5 wait states | RM0090 3.5, not checked |
//! | flash: lines of 16 bytes, 64 for instructions, 8 for data, prefetch of instructions | - | RM0090 3.2, checked |
//! | flash: data before instructions if both wait | - | RM0090 3.4, not checked |
//! | evicted line: the least recently used | - | RM0090 3.5, not checked |
//!
//! TRM: Arm, Cortex-M4 Technical Reference Manual r0p1 (DDI 0439). RM0090: ST's reference manual of the STM32F405. We have read neither original.
//! "Checked in TI" means read in the copy of Arm's tables in Texas Instruments' SWCU192, tables 3-25 and 3-27 and the section on load and store
//! timings. "Checked in GCC" means that GCC's pipeline description `cortex-m4-fpu.md` agrees. "Checked" for RM0090 means read in a copy of its
//! chapter 3. "Not checked" means from memory of the manual. "Published" means the interpretation that comes nearest to the cycles that others
//! published for their programs on a Cortex-M4, in `docs/measured/calibration.md`.

/// Wait states of flash at 168 MHz and 3.3 V (RM0090, 3.5.1).
pub const FLASH_WAIT_STATES: u64 = 5;
/// Bytes per flash read (RM0090, 3.2).
pub const FLASH_LINE_BYTES: u32 = 16;
/// Number of cached instruction lines (RM0090, 3.2): 1 KiB.
pub const INSTRUCTION_LINES: usize = 64;
/// Number of cached data lines (RM0090, 3.2): 128 bytes.
pub const DATA_LINES: usize = 8;
/// Clock of the core for these wait states, Hz.
pub const CLOCK: u64 = 168_000_000;

/// Cycles of VDIV and VSQRT.
pub const FLOAT_DIVIDE: u64 = 14;
/// Cycles of VMLA and its variants.
pub const FLOAT_MULTIPLY_ADD: u64 = 3;
/// Cycles of VMOV between core and float registers, in the float unit.
pub const FLOAT_TRANSFER: u64 = 2;
/// Refill after a load of the program counter and a branch by a table, cycles: always the longest.
pub const REFILL_MOST: u64 = 3;

/// Interpretations of a branch's refill P.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refill {
    /// The same for every branch.
    Always(u64),
    /// 2 cycles, or 3 if the target is a wide instruction across two words, which takes two fetches.
    ByTarget,
}

/// One interpretation of the manuals, for all points that they leave open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Cycles of an integer division.
    pub divide: u64,
    /// Refill P of a taken branch.
    pub refill: Refill,
    /// True if VLDR and VSTR are pipelined with their neighbours like LDR and STR. GCC's description says so; the manual's table does not.
    pub float_memory_is_pipelined: bool,
    /// True if instructions outside the float unit continue during VDIV, VSQRT and multiply-add.
    pub float_unit_runs_beside: bool,
    /// True if a load of one or several core registers is pipelined after every load and store of core registers. The manual states this only for a
    /// load of one register after another such load, but one published program is quicker than that.
    pub loads_follow_all: bool,
    /// VMOV between core and float registers.
    pub transfer: Transfer,
    /// Folding of IT into a narrow instruction before it; otherwise it takes one cycle. The low interpretation folds every IT.
    pub if_then: IfThen,
    /// Additional cycles B of a barrier.
    pub barrier: u64,
    /// Stall of a load from flash that coincides with a fetch, cycles: "might add a cycle".
    pub literal: u64,
    /// Caching of a prefetched line when it is executed.
    pub prefetched: Prefetched,
    /// True if a flash read that is no longer needed must end before the next begins.
    pub flash_reads_finish: bool,
    /// Cycles of a load or store on the bus while instructions come from SRAM over the same bus.
    pub bus_conflict: BusConflict,
    /// Further cycles of a refill from SRAM: the system bus is not made for instructions.
    pub refill_from_sram: u64,
}

/// Interpretations of VMOV between core and float registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// 1 cycle.
    Quick,
    /// 1 cycle of the core and 2 of the float unit, and the result is ready after these. For two float registers to the core, 2 cycles of both,
    /// because they are transferred one after the other.
    Beside,
    /// 2 cycles.
    Whole,
}

/// Interpretations of the caching of a prefetched line that is executed. RM0090 says that missed lines are cached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prefetched {
    /// Always cached.
    Kept,
    /// Cached if the core waited for it, because it was then missed.
    KeptIfWaitedFor,
    /// Never cached.
    Dropped,
}

/// Interpretations of IT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IfThen {
    /// Always folded.
    Folded,
    /// Folded after a narrow instruction.
    BehindNarrow,
    /// Never folded.
    Apart,
}

/// Extra cycles of a load or store while instructions come over the same bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusConflict {
    /// None: fetched words that are queued in the core hide the access.
    Hidden,
    /// One cycle per instruction.
    EachInstruction,
    /// One cycle per word.
    EachWord,
}

/// Best case of every choice.
pub const LOW: Reading = Reading {
    divide: 2,
    refill: Refill::Always(2),
    float_memory_is_pipelined: true,
    float_unit_runs_beside: true,
    loads_follow_all: true,
    transfer: Transfer::Quick,
    if_then: IfThen::Folded,
    barrier: 0,
    literal: 0,
    prefetched: Prefetched::Kept,
    flash_reads_finish: false,
    bus_conflict: BusConflict::Hidden,
    refill_from_sram: 0,
};

/// Most probable interpretation: division in the middle of its range; otherwise the one that published cycles support.
pub const LIKELY: Reading = Reading {
    divide: 7,
    refill: Refill::ByTarget,
    float_memory_is_pipelined: false,
    float_unit_runs_beside: true,
    loads_follow_all: false,
    transfer: Transfer::Beside,
    if_then: IfThen::BehindNarrow,
    barrier: 2,
    literal: 0,
    prefetched: Prefetched::Kept,
    flash_reads_finish: true,
    bus_conflict: BusConflict::EachInstruction,
    refill_from_sram: 1,
};

/// Worst case of every choice.
pub const HIGH: Reading = Reading {
    divide: 12,
    refill: Refill::Always(REFILL_MOST),
    float_memory_is_pipelined: false,
    float_unit_runs_beside: false,
    loads_follow_all: false,
    transfer: Transfer::Whole,
    if_then: IfThen::Apart,
    barrier: 3,
    literal: 1,
    prefetched: Prefetched::Dropped,
    flash_reads_finish: true,
    bus_conflict: BusConflict::EachWord,
    refill_from_sram: 2,
};
