//! The code of the tick: its copy in RAM, which runs, and its original in flash (`tick.x`).
#![allow(
    unsafe_code,
    reason = "memory at addresses from the linker script, and registers of the memory protection unit"
)]

use crate::app::ThisBoard;
use cortex_m::peripheral::MPU;
use cortex_m::peripheral::mpu::RegisterBlock;
use firmware::board::Board;
use firmware::code_check;
use firmware::memory_protection::{self, MAX_REGIONS, Region};

// SAFETY: `tick.x` defines the symbols: begin and end of the copy, and begin of the original, all at addresses of words.
unsafe extern "C" {
    #[link_name = "__tick_start"]
    static START: u32;
    #[link_name = "__tick_end"]
    static END: u32;
    #[link_name = "__tick_original"]
    static ORIGINAL: u32;
}

/// The memory protection unit. No register of it has another owner.
fn unit() -> &'static RegisterBlock {
    // SAFETY: the registers of the core, at their address.
    unsafe { &*MPU::PTR }
}

/// The unit is on, also for privileged code; memory without a region has its default access; in the handlers of the hard fault and of the
/// non-maskable interrupt the unit is off.
const ON: u32 = 1 << 2 | 1;

/// The protection of the copy, and where its comparison continues.
#[allow(unreachable_pub, reason = "the framework makes the types of resources part of public ones")]
pub struct Guard {
    regions: [Region; MAX_REGIONS],
    place: usize,
}

impl Guard {
    /// Makes the copy read-only: a write to it is a hard fault, which switches the drives off. Then compares all of it, as [`Guard::check`] does. Ends
    /// the program if anything does not succeed.
    pub(crate) fn start() -> Self {
        let Some(regions) =
            memory_protection::read_only((&raw const START).addr() as u32, (&raw const END).addr() as u32)
        else {
            unprotected()
        };
        let unit = unit();
        cortex_m::asm::dmb();
        // SAFETY: the unit is off while its regions change.
        unsafe { unit.ctrl.write(0) };
        // All of them: a program before this one may have left some, and a higher number would win.
        for region in &regions {
            // SAFETY: the regions hold code, which nothing writes any more, and addresses that nothing uses.
            unsafe {
                unit.rbar.write(region.base);
                unit.rasr.write(region.attributes);
            }
        }
        // SAFETY: as above.
        unsafe { unit.ctrl.write(ON) };
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        let guard = Self { regions, place: 0 };
        guard.check();
        guard
    }

    /// Compares all of the code, and the registers that protect it; ends the program if there is a difference.
    pub(crate) fn check(&self) {
        if !self.regions.iter().all(protects) {
            unprotected();
        }
        let (copy, original) = both();
        if !code_check::are_equal(copy, original) {
            halt();
        }
    }

    /// Compares the next few words of the code and the registers of the next region; ends the program if there is a difference.
    pub(crate) fn check_some(&mut self) {
        let next = self.place / code_check::WORDS % MAX_REGIONS;
        if !self.regions.get(next).is_some_and(protects) {
            unprotected();
        }
        let (copy, original) = both();
        if code_check::differs(&mut self.place, copy, original) {
            halt();
        }
    }
}

/// True if the unit is on, and its registers are those of this region. Registers that are not there read as zero.
fn protects(region: &Region) -> bool {
    let unit = unit();
    // SAFETY: selects the region that is read. Only the lowest task does, after the start.
    unsafe { unit.rnr.write(region.base & 0xF) };
    // The bit that makes the number valid reads as zero.
    unit.ctrl.read() == ON && unit.rbar.read() == region.base & !(1 << 4) && unit.rasr.read() == region.attributes
}

fn halt() -> ! {
    <ThisBoard as Board<{ arm::N }>>::halt(|| defmt::error!("the tick's code in RAM is not that in flash"))
}

fn unprotected() -> ! {
    <ThisBoard as Board<{ arm::N }>>::halt(|| defmt::error!("the tick's code in RAM is not protected from writes"))
}

/// The copy in RAM, and the original.
fn both() -> (&'static [u32], &'static [u32]) {
    let (start, end, original) = (&raw const START, &raw const END, &raw const ORIGINAL);
    let words = (end.addr() - start.addr()) / size_of::<u32>();
    // SAFETY: readable memory of this length. The start-up code has written the copy, and nothing writes to either while the program runs. Should
    // something do so by mistake, the words read here are still numbers.
    unsafe { (core::slice::from_raw_parts(start, words), core::slice::from_raw_parts(original, words)) }
}
