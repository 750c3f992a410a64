//! Parts that all boards with a Cortex-M4 share: the cycle counter, nonces from random words, and the end of the program.

use link::{Cost, Nonce, NonceSource};
use session::meter::Counter;

/// The core's cycle counter.
pub struct CycleCounter;

/// Starts the cycle counter.
pub fn cycle_counter(core: &mut cortex_m::Peripherals) -> CycleCounter {
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    CycleCounter
}

impl Counter for CycleCounter {
    fn now(&self) -> u32 {
        cortex_m::peripheral::DWT::cycle_count()
    }

    fn cost(count: u32) -> Cost {
        Cost::Cycles(count)
    }

    fn exercise(&self) {
        cortex_m::asm::delay(100);
    }
}

/// Makes a nonce from words of a random number generator; `None` if it returns none.
pub fn nonce(mut word: impl FnMut() -> Option<u32>) -> Option<(Nonce, NonceSource)> {
    let mut nonce = Nonce::default();
    for bytes in nonce.chunks_exact_mut(4) {
        bytes.copy_from_slice(&word()?.to_le_bytes());
    }
    Some((nonce, NonceSource::Generator))
}

/// Switches interrupts off, then the drives, then writes the log, then stops for good.
pub fn halt(drives_off: impl FnOnce(), write_log: impl FnOnce()) -> ! {
    cortex_m::interrupt::disable();
    drives_off();
    write_log();
    loop {
        cortex_m::asm::wfi();
    }
}
