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

/// The emergency stop, where the board has a pin for it, and the independent watchdog.
pub struct Guards {
    /// High when pressed, and when its wire is broken: a closed contact to ground, against a pull-up.
    stop: Option<ErasedPin<InputPin>>,
    watchdog: pac::IWDG,
    /// Start value of the watchdog's count-down, eighths of a millisecond.
    reload: u16,
    running: bool,
}

/// Ticks without feeding before the watchdog resets the chip. Its oscillator has 17 to 47 kHz instead of 32: 2.7 to 7.5
/// ticks.
const TICKS_UNFED: f32 = 4.0;

/// 168 MHz from the crystal; 42 MHz for APB1, with the link and the CAN controllers; 48 MHz for the random number generator.
pub fn clocks() -> Config {
    Config::hse(8.MHz()).sysclk(168.MHz()).pclk1(42.MHz()).require_pll48clk()
}

/// The random number generator, running.
pub fn generator(rng: pac::RNG, rcc: &mut Rcc) -> Generator {
    Generator(rng.constrain(rcc).release())
}

/// The control timer, held.
pub fn control_timer(timer: pac::TIM3, rate_hz: f32, rcc: &mut Rcc) -> ControlTimer {
    let mut timer = timer.counter_hz(rcc);
    timer.listen(Event::Update);
    // Whole hertz: the cast saturates, and a rate below 1 Hz is no control rate.
    ControlTimer { timer, rate: (rate_hz as u32).max(1).Hz() }
}

/// The watchdog, not running, and the emergency stop's pin.
pub fn guards(stop: Option<ErasedPin<InputPin>>, watchdog: pac::IWDG, rate_hz: f32) -> Guards {
    // 32 kHz by 4; a count of at least a millisecond, at most what the register holds. The cast saturates.
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
            // Started first, with half a second to go: the settings take effect some cycles of its oscillator after they are written,
            // and the next tick loads them. Nothing has to be waited for.
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
    /// The next random word. The generator tests itself; one that has doubts, or is silent for far longer than the 40 periods of
    /// 48 MHz that a word takes, gives none.
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
        // Fails only for rates above the timer's clock; the timer then stays held, and the host hears nothing.
        self.timer.start(self.rate).ok();
    }

    fn hold(&mut self) {
        // Not running is no error here.
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

/// Pull pins of port C low, without owning them. Only for the end of the program, when no owner runs any more.
pub fn set_port_c_low(pins: u16) {
    #[allow(unsafe_code, reason = "the program is over; whoever owned the pins does not run again")]
    // SAFETY: a write to the set-reset register changes only the pins that it names: its upper half resets.
    unsafe {
        (*pac::GPIOC::ptr()).bsrr().write(|w| w.bits(u32::from(pins) << 16));
    }
}
