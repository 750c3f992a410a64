//! The timed loops, each of one class of instructions. Each exists three times: in flash at the start of a cache line, in flash two bytes further
//! (wide instructions then straddle words), and in SRAM.

use core::arch::global_asm;

/// Number of passes of each loop.
const TURNS: u32 = 64;

/// Data that the loops read and write.
pub(crate) struct Data {
    /// In SRAM. The first word becomes its own address, for chains of loads.
    words: [u32; 64],
}

impl Data {
    pub(crate) const fn new() -> Self {
        Self { words: [0; 64] }
    }
}

/// A row of the table that the assembler creates.
#[repr(C)]
pub(crate) struct Stretch {
    code: extern "C" fn(turns: u32, words: *mut u32),
    name: *const u8,
    length: usize,
}

impl Stretch {
    /// Its name, as in `vldr_flash`.
    pub(crate) fn name(&self) -> &str {
        // SAFETY: the assembler writes both from the same constant string, which is never changed.
        let bytes = unsafe { core::slice::from_raw_parts(self.name, self.length) };
        core::str::from_utf8(bytes).unwrap_or_default()
    }

    /// Runs it once.
    pub(crate) fn run(&self, data: &mut Data) {
        (self.code)(TURNS, data.words.as_mut_ptr());
    }
}

unsafe extern "C" {
    static MICRO_TABLE: Stretch;
    static MICRO_ROWS: usize;
}

/// Returns all loops; the first one returns at once.
pub(crate) fn all() -> &'static [Stretch] {
    // SAFETY: the assembler creates this number of contiguous rows of three words, and nothing changes them.
    unsafe { core::slice::from_raw_parts(&raw const MICRO_TABLE, MICRO_ROWS) }
}

global_asm!(include_str!("stretches.s"), options(raw));
