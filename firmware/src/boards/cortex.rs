//! Parts that the boards with an STM32F405 and with an STM32G474 share: the cycle counter, the random number generator, the watchdog, pins of port C,
//! and the end of the program.
//!
//! Written from the reference manuals (RM0090, RM0440) and compiled; **not yet run on silicon**.

use super::pac::{GPIOC, IWDG, RNG};
use firmware::board::Nonces;
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

/// The chip's random number generator, started.
pub struct Generator(pub RNG);

impl Generator {
    /// Returns the next random word; `None` if the generator's self-test reports an error, or if there is no word after far more than the time
    /// that one takes: 40 periods of 48 MHz on an STM32F405, about 400 for four words on an STM32G474.
    fn word(&self) -> Option<u32> {
        for _ in 0..10_000 {
            let status = self.0.sr().read();
            if status.cecs().bit() || status.secs().bit() {
                return None;
            }
            if status.drdy().bit() {
                return Some(self.0.dr().read().rndata().bits());
            }
        }
        None
    }
}

impl Nonces for Generator {
    fn next(&mut self) -> Option<(Nonce, NonceSource)> {
        let mut nonce = Nonce::default();
        for bytes in nonce.chunks_exact_mut(4) {
            bytes.copy_from_slice(&self.word()?.to_le_bytes());
        }
        Some((nonce, NonceSource::Generator))
    }
}

/// Nominal number of ticks without feeding before the watchdog resets the chip. Its oscillator has 17 to 47 kHz (STM32F405) or 29.5 to 34 kHz
/// (STM32G474) instead of 32 kHz: in fact 2.7 to 7.5 ticks, or 3.8 to 4.3.
const TICKS_UNFED: f32 = 4.0;

/// The independent watchdog.
pub struct Watchdog {
    registers: IWDG,
    /// Start value of its down-counter, in units of 0.125 ms.
    reload: u16,
    running: bool,
}

impl Watchdog {
    /// Sets up the watchdog, not running; `rate_hz` is the control rate, Hz.
    pub fn new(registers: IWDG, rate_hz: f32) -> Self {
        // 32 kHz divided by 4; a count of at least a millisecond, at most the register's maximum. The cast saturates.
        let reload = ((8_000.0 * TICKS_UNFED / rate_hz) as u16).clamp(8, 0xfff);
        Self { registers, reload, running: false }
    }

    /// Feeds the watchdog. The first call starts it.
    pub fn feed(&mut self) {
        if !self.running {
            self.running = true;
            // The watchdog is started first, with its default of half a second. The settings take effect some cycles of its oscillator after they
            // are written, and the next tick loads them, so there is no need to wait.
            self.registers.kr().write(|w| w.key().start());
            self.registers.kr().write(|w| w.key().unlock());
            self.registers.pr().write(|w| w.pr().divide_by4());
            self.registers.rlr().write(|w| w.rl().set(self.reload));
        }
        self.registers.kr().write(|w| w.key().feed());
    }
}

/// Sets the pins of port C in the lower half of `pins`, and resets those in the upper half, without owning them.
pub fn port_c(pins: u32) {
    #[allow(unsafe_code, reason = "one port's pins have several owners, and at the end of the program none")]
    // SAFETY: a write to the set-reset register changes only the pins that it names.
    unsafe {
        (*GPIOC::ptr()).bsrr().write(|w| w.bits(pins));
    }
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
