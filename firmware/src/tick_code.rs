//! The code of the tick: its copy in RAM, which runs, and its original in flash (`tick.x`).
#![allow(
    unsafe_code,
    reason = "memory at addresses from the linker script, and registers of the memory protection unit"
)]

use crate::app::ThisBoard;
use cortex_m::peripheral::MPU;
use firmware::board::Board;
use firmware::{code_check, memory_protection};

// SAFETY: `tick.x` defines the symbols: begin and end of the copy, and begin of the original, all at addresses of words.
unsafe extern "C" {
    #[link_name = "__tick_start"]
    static START: u32;
    #[link_name = "__tick_end"]
    static END: u32;
    #[link_name = "__tick_original"]
    static ORIGINAL: u32;
}

/// Makes the copy read-only: a write to it is a hard fault, which switches the drives off. Returns false if the chip has no such protection.
///
/// In the handlers of the hard fault and of the non-maskable interrupt the protection is off.
#[must_use]
pub(crate) fn protect(unit: &mut MPU) -> bool {
    let (start, end) = ((&raw const START).addr() as u32, (&raw const END).addr() as u32);
    let Some(regions) = memory_protection::read_only(start, end) else { return false };
    for region in &regions {
        // SAFETY: the regions hold code, which nothing writes any more. All other memory keeps its default access.
        unsafe {
            unit.rbar.write(region.base);
            unit.rasr.write(region.attributes);
        }
    }
    // SAFETY: as above. PRIVDEFENA: memory without a region has the default access.
    unsafe { unit.ctrl.write(1 << 2 | 1) };
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    // Registers that are not there read as zero.
    regions.iter().all(|region| {
        // SAFETY: selects the region that is read.
        unsafe { unit.rnr.write(region.base & 0xF) };
        unit.rasr.read() == region.attributes
    })
}

/// Compares all of it; ends the program if there is a difference.
pub(crate) fn check() {
    let (copy, original) = both();
    if !code_check::are_equal(copy, original) {
        halt();
    }
}

/// Compares a few words from `place` on; ends the program if there is a difference.
pub(crate) fn check_some(place: &mut usize) {
    let (copy, original) = both();
    if code_check::differs(place, copy, original) {
        halt();
    }
}

fn halt() -> ! {
    <ThisBoard as Board<{ arm::N }>>::halt(|| defmt::error!("the tick's code in RAM is not that in flash"))
}

/// The copy in RAM, and the original.
fn both() -> (&'static [u32], &'static [u32]) {
    let (start, end, original) = (&raw const START, &raw const END, &raw const ORIGINAL);
    let words = (end.addr() - start.addr()) / size_of::<u32>();
    // SAFETY: readable memory of this length. The start-up code has written the copy, and nothing writes to either while the program runs. Should
    // something do so by mistake, the words read here are still numbers.
    unsafe { (core::slice::from_raw_parts(start, words), core::slice::from_raw_parts(original, words)) }
}
