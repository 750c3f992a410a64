//! The program: the chip, and the control task on an executor of its own.
#![no_std]
#![no_main]

mod chip;
mod float_mode;
mod halt;

use arm_firmware::control::Control;
use arm_firmware::robot::RATE_HZ;
use chip::{Arm, Watchdog};
use embassy_executor::{InterruptExecutor, Spawner};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_time::{Duration, Instant, Timer};

/// Period of the ticks, us.
const PERIOD_US: u64 = {
    let period = (1e6 / RATE_HZ) as u64;
    assert!(
        period > 0 && period as f32 * RATE_HZ == 1e6,
        "the period of the scene's `rate` must be a whole number of microseconds"
    );
    period
};

/// Runs the control task in an interrupt, so that no task of the thread executor delays it.
static CONTROL: InterruptExecutor = InterruptExecutor::new();

/// A vector of a peripheral that this firmware does not use.
#[interrupt]
unsafe fn UART4() {
    // SAFETY: this is the interrupt that the executor was started for.
    unsafe { CONTROL.on_interrupt() }
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let (joints, watchdog) = chip::start();
    interrupt::UART4.set_priority(Priority::P1);
    let control = CONTROL.start(interrupt::UART4);
    // Fails only if the task runs already. Without ticks the watchdog resets the chip.
    if let Ok(task) = control_task(joints, watchdog) {
        control.spawn(task);
    }
    // Spawn your own tasks here with `_spawner`: the control task interrupts them.
}

/// The control task, at the scene's rate.
#[embassy_executor::task]
async fn control_task(mut joints: Arm, mut watchdog: Watchdog) {
    let mut control = Control::new();
    let period = Duration::from_micros(PERIOD_US);
    let mut next = Instant::now() + period;
    loop {
        Timer::at(next).await;
        next += period;
        if control.tick(&mut joints, || Instant::now() >= next) {
            watchdog.pet();
        } else {
            // Ticks that were missed are not made up for.
            next = Instant::now() + period;
        }
    }
}
