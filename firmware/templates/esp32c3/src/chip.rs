//! The chip: clocks, lines, timer, watchdog. **Compiled, not run on silicon.**

use arm_firmware::joints::Joints;
use arm_firmware::robot::RATE_HZ;
use esp_hal::clock::CpuClock;
use esp_hal::gpio::{Level, Output, OutputConfig};
use esp_hal::rtc_cntl::{Rtc, RwdtStage};
use esp_hal::time::{Duration, Instant};

/// Pins that a panic sets low: brakes GPIO4, drives GPIO5.
const LINES: u32 = 1 << 4 | 1 << 5;

/// GPIO_OUT_W1TC (ESP32-C3 technical reference manual, GPIO registers).
const OUTPUTS_CLEAR: *mut u32 = 0x6000_400c as *mut u32;

/// Time without a tick after which the watchdog resets the chip.
const UNFED: Duration = Duration::from_millis(20);

/// The joints on this chip.
pub type Arm = Joints<Output<'static>, Output<'static>>;

/// Period of the ticks, us.
const PERIOD_US: u64 = {
    let period = (1e6 / RATE_HZ) as u64;
    assert!(
        period > 0 && period as f32 * RATE_HZ == 1e6,
        "the period of the scene's `rate` must be a whole number of microseconds"
    );
    period
};

/// The time at which the next tick is due.
pub struct Timer {
    next: Instant,
    period: Duration,
}

/// The watchdog of the clock for low power, which has an oscillator of its own.
pub struct Watchdog(Rtc<'static>);

/// Starts the chip: 160 MHz. The lines are low before the first tick.
pub fn start() -> (Arm, Timer, Watchdog) {
    // It switches every watchdog off, so ours cannot start before it. If it does not return, nothing resets the chip; the pull-downs hold the lines low.
    let chip = esp_hal::init(esp_hal::Config::default().with_cpu_clock(CpuClock::max()));
    let mut rtc = Rtc::new(chip.RTC_TIMER);
    rtc.rwdt.set_timeout(RwdtStage::Stage0, UNFED);
    rtc.rwdt.enable();
    let brakes = Output::new(chip.GPIO4, Level::Low, OutputConfig::default());
    let drives = Output::new(chip.GPIO5, Level::Low, OutputConfig::default());
    let period = Duration::from_micros(PERIOD_US);
    (Joints { drives, brakes }, Timer { next: Instant::now() + period, period }, Watchdog(rtc))
}

impl Timer {
    /// True if the next tick is due.
    pub fn is_due(&self) -> bool {
        Instant::now() >= self.next
    }

    /// Waits until the next tick is due, and plans the one after it.
    pub fn wait(&mut self) {
        while !self.is_due() {}
        self.next += self.period;
    }

    /// Plans the next tick one period from now.
    pub fn restart(&mut self) {
        self.next = Instant::now() + self.period;
    }
}

impl Watchdog {
    /// Reports that a tick has ended in time.
    pub fn feed(&mut self) {
        self.0.rwdt.feed();
    }
}

/// Sets the lines low at the end of the program.
pub fn lines_low() {
    // SAFETY: one write to a clear register, which changes only the pins that it names. No owner of the pins runs again.
    unsafe { OUTPUTS_CLEAR.write_volatile(LINES) }
}

/// Waits for the watchdog's reset.
pub fn stop() -> ! {
    loop {
        core::hint::spin_loop();
    }
}
