//! The chip: clocks, lines, timer, watchdog. For a crystal of 12 MHz. **Compiled, not run on silicon.**

use super::float_mode;
use arm_firmware::joints::Joints;
use arm_firmware::robot::RATE_HZ;
use rp235x_hal as hal;

use hal::fugit::ExtU32;
use hal::gpio::bank0::{Gpio16, Gpio17};
use hal::gpio::{FunctionSio, Pin, PinState, Pins, PullDown, SioOutput};
use hal::pac::{PSM, Peripherals, SIO, WATCHDOG};
use hal::timer::CopyableTimer0;
use hal::{Sio, Watchdog};

/// Tells the chip's boot program that this is a secure program for the Arm core.
#[unsafe(link_section = ".start_block")]
#[used]
static IMAGE: hal::block::ImageDef = hal::block::ImageDef::secure_exe();

/// Pins that a panic sets low: brakes GPIO16, drives GPIO17.
const LINES: u32 = 1 << 16 | 1 << 17;

/// Time without a tick after which the watchdog resets the chip, ms.
const UNFED_MS: u32 = 10;

/// The same until the first tick. The crystal alone may need 64 ms, and the watchdog then counts cycles of the ring oscillator, up to twice as fast.
const UNSTARTED_MS: u32 = 500;

/// Frequency of the crystal, Hz.
const CRYSTAL_HZ: u32 = 12_000_000;

type Line<P> = Pin<P, FunctionSio<SioOutput>, PullDown>;

/// The joints on this chip.
pub type Arm = Joints<Line<Gpio17>, Line<Gpio16>>;

/// The control timer, and the time at which the next tick is due, us. The counter has 32 bits and wraps.
pub struct Timer {
    timer: hal::Timer<CopyableTimer0>,
    next: u32,
}

/// Period of the ticks, us.
const PERIOD_US: u32 = {
    let period = (1e6 / RATE_HZ) as u32;
    assert!(
        period > 0 && period as f32 * RATE_HZ == 1e6,
        "the period of the scene's `rate` must be a whole number of microseconds"
    );
    period
};

/// Starts the chip; `None` if a clock does not start, or if the floating-point unit is not as it must be. The lines are low and the watchdog runs before
/// anything can wait.
pub fn start() -> Option<(Arm, Timer, Watchdog)> {
    let mut chip = Peripherals::take()?;
    let sio = Sio::new(chip.SIO);
    let pins = Pins::new(chip.IO_BANK0, chip.PADS_BANK0, sio.gpio_bank0, &mut chip.RESETS);
    let brakes = pins.gpio16.into_pull_type().into_push_pull_output_in_state(PinState::Low);
    let drives = pins.gpio17.into_pull_type().into_push_pull_output_in_state(PinState::Low);
    let mut watchdog = Watchdog::new(chip.WATCHDOG);
    watchdog.enable_tick_generation((CRYSTAL_HZ / 1_000_000) as u16);
    start_watchdog(&mut watchdog, UNSTARTED_MS);
    if !float_mode::is_as_tested(&cortex_m::Peripherals::take()?) {
        return None;
    }
    let clocks = hal::clocks::init_clocks_and_plls(
        CRYSTAL_HZ,
        chip.XOSC,
        chip.CLOCKS,
        chip.PLL_SYS,
        chip.PLL_USB,
        &mut chip.RESETS,
        &mut watchdog,
    )
    .ok()?;
    let mut timer = Timer { timer: hal::Timer::new_timer0(chip.TIMER0, &mut chip.RESETS, &clocks), next: 0 };
    timer.restart();
    start_watchdog(&mut watchdog, UNFED_MS);
    Some((Joints { drives, brakes }, timer, watchdog))
}

/// Starts the watchdog with this time, ms.
fn start_watchdog(watchdog: &mut Watchdog, unfed_ms: u32) {
    watchdog.start(unfed_ms.millis());
    // The driver selects only some of the chip's parts.
    select_all();
}

/// Selects what a reset by the watchdog resets: both cores and everything else but the oscillators.
fn select_all() {
    // SAFETY: one write. Nothing else of this program uses the register after the watchdog's driver has started the watchdog.
    unsafe {
        (*PSM::ptr()).wdsel().write_with_zero(|w| w.bits(0x01ff_ffff).rosc().clear_bit().xosc().clear_bit());
    }
}

impl Timer {
    /// True if the next tick is due.
    pub fn is_due(&self) -> bool {
        // The difference is negative before the time.
        self.timer.get_counter_low().wrapping_sub(self.next) as i32 >= 0
    }

    /// Waits until the next tick is due, and plans the one after it.
    pub fn wait(&mut self) {
        while !self.is_due() {}
        self.next = self.next.wrapping_add(PERIOD_US);
    }

    /// Plans the next tick one period from now.
    pub fn restart(&mut self) {
        self.next = self.timer.get_counter_low().wrapping_add(PERIOD_US);
    }
}

/// Sets the lines low at the end of the program.
pub fn lines_low() {
    // SAFETY: one write to a clear register, which changes only the pins that it names. On this core no owner of the pins runs again. If this is core 1,
    // their owner on core 0 runs on until the reset that follows.
    unsafe {
        (*SIO::ptr()).gpio_out_clr().write(|w| w.bits(LINES));
    }
}

/// Resets the whole chip at once, both cores, also if this one does not feed the watchdog.
pub fn stop() -> ! {
    select_all();
    // SAFETY: the write starts the reset. A core that still runs writes only another register, when it feeds the watchdog.
    unsafe {
        (*WATCHDOG::ptr()).ctrl().modify(|_, w| w.trigger().set_bit());
    }
    loop {
        cortex_m::asm::nop();
    }
}
