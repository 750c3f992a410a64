//! The stretches: loops of one class of instructions, each from flash with its loop at the start of a line, from flash two
//! bytes on, where wide instructions straddle words, and from SRAM.

use core::arch::global_asm;

/// Turns of each loop.
const TURNS: u32 = 64;

/// Data that the stretches read and write.
pub(crate) struct Data {
    /// In SRAM. The first word becomes its own address, for chains of loads.
    words: [u32; 64],
}

impl Data {
    pub(crate) const fn new() -> Self {
        Self { words: [0; 64] }
    }
}

/// A row of the table that the assembler makes.
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

/// All of them; the first one returns at once.
pub(crate) fn all() -> &'static [Stretch] {
    // SAFETY: the assembler lays out as many rows of three words, behind one another, and nothing changes them.
    unsafe { core::slice::from_raw_parts(&raw const MICRO_TABLE, MICRO_ROWS) }
}

global_asm!(include_str!("stretches.s"), options(raw));
