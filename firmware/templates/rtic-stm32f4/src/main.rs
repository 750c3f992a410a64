//! The program: the chip, a timer at the scene's rate, and the control task.
#![no_std]
#![no_main]

// With the feature `qemu`: the emulated chip and a simulated arm.
#[cfg_attr(feature = "qemu", path = "qemu.rs")]
mod chip;
mod float_mode;
mod halt;

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use super::chip::{self, Arm, Timer, Watchdog};
    use arm_firmware::control::Control;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        control: Control,
        joints: Arm,
        timer: Timer,
        watchdog: Watchdog,
    }

    #[init]
    fn init(cx: init::Context) -> (Shared, Local) {
        let (joints, timer, watchdog) = chip::start(cx.device, cx.core);
        (Shared {}, Local { control: Control::new(), joints, timer, watchdog })
    }

    /// The control task. Give your own tasks a lower priority, so that none of them delays it.
    #[task(binds = TIM3, priority = 8, local = [control, joints, timer, watchdog])]
    fn tick(cx: tick::Context) {
        let tick::LocalResources { control, joints, timer, watchdog, .. } = cx.local;
        timer.acknowledge();
        if control.tick(joints, || timer.is_due()) {
            watchdog.feed();
        }
        chip::after_tick(joints, timer);
    }
}
