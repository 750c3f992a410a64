//! QEMU's `netduinoplus2` in place of the chip, with a simulated arm. The emulator has no clock tree and no watchdog, so each tick pends the next one.

use super::float_mode;
use super::halt::halt;
use arm_firmware::GOLDEN;
use arm_firmware::dry_run::{DryRun, TICKS};
use cortex_m_semihosting::{debug, hprintln};
use stm32f4xx_hal::pac::{Interrupt, Peripherals};

/// The simulated joints.
pub type Arm = DryRun;

/// No timer: counts ticks.
pub struct Timer(u32);

/// No watchdog.
pub struct Watchdog;

/// Starts the first tick.
pub fn start(_: Peripherals, core: cortex_m::Peripherals) -> (Arm, Timer, Watchdog) {
    if !float_mode::is_as_tested(&core) {
        halt();
    }
    rtic::pend(Interrupt::TIM3);
    (DryRun::at(arm_firmware::TEST_POSE), Timer(0), Watchdog)
}

impl Timer {
    /// Counts a tick.
    pub fn acknowledge(&mut self) {
        self.0 += 1;
    }

    /// False: time does not matter here.
    pub fn is_due(&self) -> bool {
        false
    }
}

impl Watchdog {
    /// Does nothing.
    pub fn feed(&mut self) {}
}

/// Starts the next tick, or ends the emulator with the result.
pub fn after_tick(joints: &mut Arm, timer: &Timer) {
    if timer.0 < TICKS {
        return rtic::pend(Interrupt::TIM3);
    }
    let hash = joints.hash;
    hprintln!("{} ticks, hash 0x{:016x}, on the desk 0x{:016x}", TICKS, hash, GOLDEN);
    debug::exit(if hash == GOLDEN { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
}

/// No lines.
pub fn lines_low() {}

/// Ends the emulator.
pub fn stop() -> ! {
    debug::exit(debug::EXIT_FAILURE);
    loop {
        cortex_m::asm::nop();
    }
}
