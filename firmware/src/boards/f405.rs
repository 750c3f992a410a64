//! Shared parts of boards with an STM32F405 and an 8 MHz crystal: clocks, the control timer, the lines. Their link is in `dma_link`.
//!
//! Written from the reference manual (RM0090) and compiled; **not yet run on silicon**.

use super::cortex::Watchdog;
pub use super::cortex::{CycleCounter, Generator, cycle_counter, halt, port_c};
use super::pac;
use firmware::board::{BoardLines, Ticker};
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

/// The emergency stop, if the board has a pin for it, and the independent watchdog.
pub struct Guards {
    /// Pin of the emergency stop, with a pull-up and a normally closed contact to ground: high if pressed or if the wire is broken.
    stop: Option<ErasedPin<InputPin>>,
    watchdog: Watchdog,
}

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
    Guards { stop, watchdog: Watchdog::new(watchdog, rate_hz) }
}

impl BoardLines for Guards {
    fn read(&mut self) -> Lines {
        Lines { emergency_stop: self.stop.as_ref().is_some_and(ErasedPin::is_high), ..Lines::NONE }
    }

    fn feed(&mut self) {
        self.watchdog.feed();
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
