//! The chip: clocks, lines, watchdog. On its internal oscillator. **Compiled, not run on silicon.**

use super::float_mode;
use super::halt::halt;
use arm_firmware::joints::Joints;
use embassy_stm32::Config;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::rcc::{Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};
use embassy_stm32::wdg::IndependentWatchdog;

/// Pins of port C that a panic sets low: brakes PC4, drives PC6.
const LINES: u32 = 1 << 4 | 1 << 6;

/// BSRR of port C (RM0440, table of the memory map, and GPIO registers).
const GPIOC_BSRR: *mut u32 = 0x4800_0818 as *mut u32;

/// Time without a tick after which the watchdog resets the chip, us. Its oscillator has 32 kHz within a few percent.
const UNFED_US: u32 = 10_000;

/// The joints on this chip.
pub type Arm = Joints<Output<'static>, Output<'static>>;

/// The independent watchdog, which has an oscillator of its own.
pub type Watchdog = IndependentWatchdog<'static, IWDG>;

/// Starts the chip, with 170 MHz, or halts if the floating-point unit is not as it must be. Until the lines are set, their pull-downs hold them low.
pub fn start() -> (Arm, Watchdog) {
    // SAFETY: the only other owner is among the peripherals that `init` returns below. It is never used.
    let mut watchdog = IndependentWatchdog::new(unsafe { IWDG::steal() }, UNFED_US);
    // From here on a clock that does not start, too, ends in a reset.
    watchdog.unleash();
    if !cortex_m::Peripherals::take().is_some_and(|core| float_mode::is_as_tested(&core)) {
        halt();
    }
    let mut config = Config::default();
    config.rcc.pll = Some(Pll {
        source: PllSource::HSI,
        prediv: PllPreDiv::DIV4,
        mul: PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.boost = true;
    let chip = embassy_stm32::init(config);
    let brakes = Output::new(chip.PC4, Level::Low, Speed::Low);
    let drives = Output::new(chip.PC6, Level::Low, Speed::Low);
    (Joints { drives, brakes }, watchdog)
}

/// Sets the lines low at the end of the program.
pub fn lines_low() {
    // SAFETY: one write to a set-reset register, which changes only the pins that it names: its upper half resets. No owner of the pins runs again.
    unsafe { GPIOC_BSRR.write_volatile(LINES << 16) }
}

/// Waits for the watchdog's reset.
pub fn stop() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}
