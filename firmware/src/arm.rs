//! The arm this firmware was built for, written out by `build.rs` from the scene file that `NEWTAU_SCENE` names.

use dynamics_core::control::Controller;
use dynamics_core::scene::Dynamics;
#[cfg(target_os = "none")]
use link::{Hello, Pacing};

#[cfg(not(target_os = "none"))]
pub(crate) use generated::ROBOT;
pub(crate) use generated::{HASH, N, NAME, RATE_HZ, TRIG, Trig};

#[allow(
    unused_imports,
    dead_code,
    unreachable_pub,
    clippy::approx_constant,
    reason = "generated: imports what any scene may need, and exports all"
)]
mod generated {
    include!(concat!(env!("OUT_DIR"), "/arm.rs"));
}

/// The controller of this arm.
pub(crate) type ArmController = Controller<f32, N, Dynamics<f32, N>, Trig>;

/// The controller of this arm, at rest.
pub(crate) fn controller() -> ArmController {
    Controller::new(generated::config(), Dynamics::new(generated::model(), generated::scene()), TRIG)
}

/// What this firmware says of itself.
#[cfg(target_os = "none")]
pub(crate) fn hello() -> Hello {
    Hello { robot: HASH, joints: N as u8, rate_hz: RATE_HZ, pacing: Pacing::LockStep }
}
