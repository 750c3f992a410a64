//! Shared parts of boards with an STM32F405 and an 8 MHz crystal: clocks, the control timer, the watchdog. Their link is in
//! `dma_link`.
//!
//! Written from the reference manual (RM0090) and compiled; **not yet run on silicon**.

use super::cortex::nonce;
pub use super::cortex::{CycleCounter, cycle_counter, halt};
use super::pac;
use firmware::board::{BoardLines, Nonces, Ticker};
use link::{Nonce, NonceSource};
use session::readings::Lines;
use stm32f4xx_hal::gpio::{ErasedPin, Input as InputPin};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc};
use stm32f4xx_hal::rng::RngExt;
use stm32f4xx_hal::time::Hertz;
use stm32f4xx_hal::timer::{CounterHz, Event, Flag};

/// TIM3.
pub struct ControlTimer {
    timer: CounterHz<pac::TIM3>,
    rate: Hertz,
}

/// The chip's random number generator.
pub struct Generator(pac::RNG);

/// The emergency stop, if the board has a pin for it, and the independent watchdog.
pub struct Guards {
    /// Pin of the emergency stop, with a pull-up and a normally closed contact to ground: high if pressed or if the wire is broken.
    stop: Option<ErasedPin<InputPin>>,
    watchdog: pac::IWDG,
    /// Start value of the watchdog's down-counter, in units of 0.125 ms.
    reload: u16,
    running: bool,
}

/// Nominal number of ticks without feeding before the watchdog resets the chip. Its oscillator has 17 to 47 kHz instead of 32 kHz: in fact 2.7 to
/// 7.5 ticks.
const TICKS_UNFED: f32 = 4.0;

/// Clock configuration: 168 MHz from the crystal; 42 MHz for APB1, with the link and the CAN controllers; 48 MHz for the random number generator.
pub fn clocks() -> Config {
    Config::hse(8.MHz()).sysclk(168.MHz()).pclk1(42.MHz()).require_pll48clk()
}

/// Starts the random number generator.
pub fn generator(rng: pac::RNG, rcc: &mut Rcc) -> Generator {
    Generator(rng.constrain(rcc).release())
}

/// Sets up the control timer, stopped; `rate_hz` is the control rate, Hz.
pub fn control_timer(timer: pac::TIM3, rate_hz: f32, rcc: &mut Rcc) -> ControlTimer {
    let mut timer = timer.counter_hz(rcc);
    timer.listen(Event::Update);
    // The rate is rounded down to whole hertz, at least 1 Hz; the cast saturates.
    ControlTimer { timer, rate: (rate_hz as u32).max(1).Hz() }
}

/// Sets up the watchdog, not running, and the emergency stop's pin; `rate_hz` is the control rate, Hz.
pub fn guards(stop: Option<ErasedPin<InputPin>>, watchdog: pac::IWDG, rate_hz: f32) -> Guards {
    // 32 kHz divided by 4; a count of at least a millisecond, at most the register's maximum. The cast saturates.
    let reload = ((8_000.0 * TICKS_UNFED / rate_hz) as u16).clamp(8, 0xfff);
    Guards { stop, watchdog, reload, running: false }
}

impl BoardLines for Guards {
    fn read(&mut self) -> Lines {
        Lines { emergency_stop: self.stop.as_ref().is_some_and(ErasedPin::is_high), ..Lines::NONE }
    }

    fn feed(&mut self) {
        if !self.running {
            self.running = true;
            // The watchdog is started first, with its default of half a second. The settings take effect some cycles of its oscillator after they
            // are written, and the next tick loads them, so there is no need to wait.
            self.watchdog.kr().write(|w| w.key().start());
            self.watchdog.kr().write(|w| w.key().unlock());
            self.watchdog.pr().write(|w| w.pr().divide_by4());
            self.watchdog.rlr().write(|w| w.rl().set(self.reload));
        }
        self.watchdog.kr().write(|w| w.key().feed());
    }
}

impl Nonces for Generator {
    fn next(&mut self) -> Option<(Nonce, NonceSource)> {
        nonce(|| self.word())
    }
}

impl Generator {
    /// Returns the next random word; `None` if the generator's self-test reports an error, or if there is no word after far more than the 40
    /// periods of 48 MHz that one takes.
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

impl Ticker for ControlTimer {
    fn run(&mut self) {
        // Fails only for rates above the timer's clock. The timer then stays stopped, and the host receives no reports.
        self.timer.start(self.rate).ok();
    }

    fn hold(&mut self) {
        // It is no error if the timer is not running.
        self.timer.cancel().ok();
        self.timer.clear_flags(Flag::Update);
    }

    fn acknowledge(&mut self) {
        self.timer.clear_flags(Flag::Update);
    }

    fn is_due(&self) -> bool {
        self.timer.flags().contains(Flag::Update)
    }

    fn trigger(&mut self) {
        rtic::pend(pac::Interrupt::TIM3);
    }
}

/// Sets pins of port C low, without owning them. Only for the end of the program, when no owner runs any more.
pub fn set_port_c_low(pins: u16) {
    #[allow(unsafe_code, reason = "the program is over; whoever owned the pins does not run again")]
    // SAFETY: a write to the set-reset register changes only the pins that it names: its upper half resets.
    unsafe {
        (*pac::GPIOC::ptr()).bsrr().write(|w| w.bits(u32::from(pins) << 16));
    }
}
