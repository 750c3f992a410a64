//! The arm this firmware was built for, written out by `build.rs` from the scene file that `NEWTAU_SCENE` names.

use dynamics_core::control::Controller;
#[cfg(target_os = "none")]
use link::{Hello, Pacing};

#[cfg(not(target_os = "none"))]
pub(crate) use generated::arm::ROBOT;
pub(crate) use generated::arm::{HASH, N, NAME, RATE_HZ, TRIG, Trig};
pub(crate) use generated::dynamics::Arm;

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

/// The controller of this arm.
pub(crate) type ArmController = Controller<f32, N, Arm, Trig>;

/// The controller of this arm, at rest.
pub(crate) fn controller() -> ArmController {
    Controller::new(generated::arm::config(), generated::dynamics::arm(), TRIG)
}

/// What this firmware says of itself.
#[cfg(target_os = "none")]
pub(crate) fn hello() -> Hello {
    Hello { robot: HASH, joints: N as u8, rate_hz: RATE_HZ, pacing: Pacing::LockStep }
}
