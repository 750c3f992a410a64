//! The arm that a firmware is built for: its numbers, its kernel and its controller, as the robot compiler writes them
//! out from a scene file. `cargo newtau firmware build --scene FILE` writes them; `build.rs` sets their path.
#![no_std]

// With the tests, so that the lints see it.
#[cfg(any(feature = "gate", test))]
pub mod gate;

use dynamics_core::control::{ArmBuild, Configuration, Controller, ControllerConfig};
use dynamics_core::safety::{self, Rules, Safety};

pub use generated::arm::{HASH, N, NAME, RATE_HZ, ROBOT, TRIG, Trig};
pub use generated::drives::{Frames, drives};
pub use generated::dynamics::Arm;
pub use generated::protection::Protection;
pub use generated::tuning::Tuning;

#[allow(
    unused_imports,
    dead_code,
    unreachable_pub,
    clippy::approx_constant,
    clippy::excessive_precision,
    reason = "generated: imports and holds what any scene may need"
)]
mod generated {
    use super::Settings;

    pub(crate) mod arm {
        include!(concat!(env!("ARM"), "/arm.rs"));
    }
    pub(crate) mod drives {
        include!(concat!(env!("ARM"), "/drives.rs"));
    }
    pub(crate) mod dynamics {
        include!(concat!(env!("ARM"), "/dynamics.rs"));
    }
    pub(crate) mod protection {
        include!(concat!(env!("ARM"), "/protection.rs"));
    }
    pub(crate) mod tuning {
        include!(concat!(env!("ARM"), "/tuning.rs"));
    }
}

/// The configuration of this arm's controller and of the safety state machine around it, as constants of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings;

impl Configuration<f32, N> for Settings {
    #[inline]
    fn get(&self) -> &ControllerConfig<f32, N> {
        const { &generated::arm::config() }
    }
}

impl safety::SafetyConfiguration<f32, N> for Settings {
    #[inline]
    fn rules(&self) -> &Rules<f32, N> {
        const { &generated::arm::rules() }
    }
}

/// The parts of this arm's controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Build;

impl ArmBuild<f32, N> for Build {
    type Dynamics = Arm;
    type Trig = Trig;
    /// [`Settings`], or the configuration itself in RAM where the scene says `tunable = true`.
    type Tuning = Tuning;
    type Protection = Protection;
    type Settings = Settings;
}

/// The controller of this arm.
pub type ArmController = Controller<f32, N, Build>;

/// The controller of this arm, at rest.
#[must_use]
pub fn controller() -> ArmController {
    Controller::built(
        generated::tuning::tuning(),
        generated::dynamics::arm(),
        TRIG,
        generated::protection::protection(),
    )
}

/// The safety state machine around it.
pub type ArmSafety = Safety<f32, N, Settings>;

/// The safety state machine around it, idle.
#[must_use]
pub fn safety() -> ArmSafety {
    Safety::new(Settings)
}
