//! The program: a loop without a framework, at the scene's rate.
#![no_std]
#![no_main]

mod chip;
mod float_mode;
mod halt;

use arm_firmware::control::Control;

#[rp235x_hal::entry]
fn main() -> ! {
    let Some((mut joints, mut timer, watchdog)) = chip::start() else { halt::halt() };
    let mut control = Control::new();
    loop {
        timer.wait();
        if control.tick(&mut joints, || timer.is_due()) {
            watchdog.feed();
        } else {
            // Ticks that were missed are not made up for.
            timer.restart();
        }
        // Work of your own delays the next tick, here and in interrupts of every priority: this loop does not run in an interrupt. Keep it short. For
        // more of it, run the tick in the timer's interrupt at the highest priority, and your work here.
    }
}
