//! The control tick of one arm as a single C function: nothing else is linked, so every symbol that the linker keeps is
//! reachable from the tick. `cargo xtask gate` links it and reads the symbols.
#![no_std]

use dynamics_core::control::{Command, Controller, Measurement, Reference};
use generated::arm::{N, TRIG, Trig};
use generated::dynamics::Arm;

#[allow(
    unused_imports,
    dead_code,
    unreachable_pub,
    clippy::approx_constant,
    clippy::excessive_precision,
    reason = "generated: imports and holds what any scene may need"
)]
mod generated {
    pub(crate) mod arm {
        include!(concat!(env!("OUT_DIR"), "/arm.rs"));
    }
    pub(crate) mod dynamics {
        include!(concat!(env!("OUT_DIR"), "/dynamics.rs"));
    }
}

/// The controller that the firmware runs.
pub type ArmController = Controller<f32, N, Arm, Trig>;

/// The only thing here that is not the tick; linked because a staticlib needs one. The gate knows it by its name.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

/// A controller, made on the desk or at start; not part of the tick.
#[must_use]
pub fn controller() -> ArmController {
    Controller::new(generated::arm::config(), generated::dynamics::arm(), TRIG)
}

/// One tick: the entry that the gate links from.
#[allow(unsafe_code, reason = "the linker must find it by name")]
#[unsafe(no_mangle)]
pub extern "Rust" fn newtau_gate_tick(
    controller: &mut ArmController,
    reference: &Reference<f32, N>,
    measurement: &Measurement<f32, N>,
) -> Command<f32, N> {
    #[cfg(feature = "bad-panic")]
    let reference = &{
        let mut reference = *reference;
        reference.q[measurement.age_ticks as usize] += 1.0;
        reference
    };
    #[cfg(feature = "bad-double")]
    let reference = &{
        let mut reference = *reference;
        reference.q[0] = (f64::from(reference.q[0]) * 1.000_000_1) as f32;
        reference
    };
    controller.tick(reference, measurement)
}
