//! The control tick of one arm, bare and inside the safety state machine, as two functions: nothing else is linked, so every
//! symbol that the linker keeps is reachable from a tick. `cargo xtask gate` links it and reads the symbols.

use crate::{ArmController, ArmSafety, N};
use dynamics_core::control::{Command, Measurement, Reference};
use dynamics_core::safety::{Inputs, Output};

/// The only function here outside the tick: a staticlib needs a panic handler. The gate recognises it by its name.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
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

/// One tick of the safety state machine with the controller inside it: the gate links it beside [`newtau_gate_tick`].
#[allow(unsafe_code, reason = "the linker must find it by name")]
#[unsafe(no_mangle)]
pub extern "Rust" fn newtau_gate_safety(
    safety: &mut ArmSafety,
    controller: &mut ArmController,
    inputs: &Inputs<f32, N>,
) -> Output<f32, N> {
    safety.tick(inputs, |ask| ask.of(controller))
}
