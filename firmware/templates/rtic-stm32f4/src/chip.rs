//! The chip: clocks, lines, timer, watchdog. For a crystal of 8 MHz. **Compiled, not run on silicon.**

use super::float_mode;
use super::halt::halt;
use arm_firmware::joints::Joints;
use arm_firmware::robot::RATE_HZ;
use cortex_m::Peripherals as CorePeripherals;
use cortex_m::peripheral::DWT;
use stm32f4xx_hal::gpio::{Output, PC4, PC6, PinState};
use stm32f4xx_hal::pac::{Peripherals, TIM3};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::timer::{CounterHz, Event, Flag};
use stm32f4xx_hal::watchdog::IndependentWatchdog;

/// Pins of port C that a panic sets low: brakes PC4, drives PC6.
const LINES: u32 = 1 << 4 | 1 << 6;

/// The joints on this chip.
pub type Arm = Joints<PC6<Output>, PC4<Output>>;

/// Frequency of the processor, Hz.
const CORE_HZ: u32 = 168_000_000;

/// Frequency of the timer's clock, Hz: twice that of its bus.
const TIMER_HZ: u32 = 84_000_000;

/// Rate of the ticks, Hz.
const TICK_HZ: u32 = {
    let rate = RATE_HZ as u32;
    assert!(
        rate > 0 && rate as f32 == RATE_HZ,
        "the scene's `rate` must be a whole number of Hz: this timer has no other"
    );
    let ticks = TIMER_HZ / rate;
    // As the timer's driver divides its clock.
    let prescaler = (ticks - 1) / (1 << 16) + 1;
    assert!(
        TIMER_HZ.is_multiple_of(rate) && ticks.is_multiple_of(prescaler),
        "the period of the scene's `rate` must be a whole number of cycles of the timer (84 MHz, prescaled): choose for example 500, 1000 or 2000 Hz"
    );
    rate
};

/// TIM3, and the cycle counter. The timer's flag alone does not show a tick that was lost because this task could not start.
pub struct Timer {
    timer: CounterHz<TIM3>,
    /// Count at the start of the last tick.
    started: u32,
    /// True if this tick started more than half a period late.
    late: bool,
}

/// The independent watchdog, which has an oscillator of its own.
pub struct Watchdog(IndependentWatchdog);

/// Time without a tick after which the watchdog resets the chip, ms: 6.8 to 19 ms, because its oscillator has 17 to 47 kHz.
const UNFED_MS: u32 = 10;

/// Starts the chip, or halts if the timer or the floating-point unit is not as it must be. Until the lines are set, their pull-downs hold them low.
pub fn start(device: Peripherals, mut core: CorePeripherals) -> (Arm, Timer, Watchdog) {
    let mut watchdog = IndependentWatchdog::new(device.IWDG);
    // From here on a crystal that does not start, too, ends in a reset.
    watchdog.start(UNFED_MS.millis());
    if !float_mode::is_as_tested(&core) {
        halt();
    }
    let mut rcc = device.RCC.freeze(Config::hse(8.MHz()).sysclk(CORE_HZ.Hz()).pclk1(42.MHz()));
    let port = device.GPIOC.split(&mut rcc);
    let brakes = port.pc4.into_push_pull_output_in_state(PinState::Low);
    let drives = port.pc6.into_push_pull_output_in_state(PinState::Low);
    let mut timer = device.TIM3.counter_hz(&mut rcc);
    timer.listen(Event::Update);
    if timer.start(TICK_HZ.Hz()).is_err() {
        halt();
    }
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    let timer = Timer { timer, started: DWT::cycle_count(), late: false };
    (Joints { drives, brakes }, timer, Watchdog(watchdog))
}

impl Timer {
    /// Ends the timer's interrupt.
    pub fn acknowledge(&mut self) {
        self.timer.clear_flags(Flag::Update);
        let now = DWT::cycle_count();
        self.late = now.wrapping_sub(self.started) > (1.5 * CORE_HZ as f32 / RATE_HZ) as u32;
        self.started = now;
    }

    /// True if the next tick is due, or was lost.
    pub fn is_due(&self) -> bool {
        self.late || self.timer.flags().contains(Flag::Update)
    }
}

impl Watchdog {
    /// Reports that a tick has ended in time.
    pub fn feed(&mut self) {
        self.0.feed();
    }
}

/// Nothing: the timer starts the next tick.
pub fn after_tick(_: &mut Arm, _: &Timer) {}

/// Sets the lines low at the end of the program.
pub fn lines_low() {
    // SAFETY: one write to a set-reset register, which changes only the pins that it names: its upper half resets. No owner of the pins runs again.
    unsafe {
        (*stm32f4xx_hal::pac::GPIOC::ptr()).bsrr().write(|w| w.bits(LINES << 16));
    }
}

/// Waits for the watchdog's reset.
pub fn stop() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}
