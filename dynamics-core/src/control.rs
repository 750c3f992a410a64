//! Computed-torque control: from a reference and a measurement to a command, once a tick.
//!
//! ```text
//! measurement -> observer -> guard -> law (inverse dynamics) -> friction -> integral -> limits -> command
//! ```
//!
//! [`Controller::tick`] is total: it returns a command for every input, including NaN. Bad input becomes a
//! numbered [`Fault`] that stays in force until [`Controller::reset`]. A limit that acts is reported, but is not a fault.

mod answer;
mod build;
mod collision;
mod config;
mod controller;
mod every_nth;
mod fault;
mod friction;
mod integral;
mod law;
mod law_torques;
mod limits;
mod momentum_observer;
mod observer;
mod reference;
mod teach;
mod torque_request;
pub mod trajectory;

pub use build::{ArmBuild, BuildOf, Unsupervised};
pub use collision::{
    CollisionConfig, CollisionConfiguration, CollisionReaction, CollisionWatch, ObservedState, Protection, Unprotected,
    Verdict,
};
pub use config::{Configuration, ControllerConfig, Guard};
pub use controller::{Controller, ControllerOf};
pub(crate) use controller::{Observed, believed, name_reference};
pub use every_nth::{Between, EveryNth};
pub use fault::Fault;
pub use friction::{Friction, FrictionTerms, LoadGrowth, Rise};
pub use integral::{Integral, Integrated};
pub use law::{ControlLaw, FeedbackInertia, Gains, LawTraits, ModelUse, MotionSource, Spring, SpringOwner};
pub use law_torques::computed_torque;
pub use limits::LimitFlags;
pub(crate) use limits::{around, hold_near, reference_is_inside};
pub use momentum_observer::{MomentumFilter, MomentumObserver};
pub use observer::{Encoder, TrackingObserver};
pub use reference::Reference;
pub use teach::Teach;
pub use torque_request::TorqueRequest;

/// Reading of the joint sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
// The tag is a word. With a byte tag, copies of the rest start at odd addresses and need three times the instructions.
#[repr(u32)]
pub enum Sensed<S, const N: usize> {
    /// Position and velocity are both measured.
    State {
        /// Joint position, rad or m.
        q: [S; N],
        /// Joint velocity, rad/s or m/s.
        qd: [S; N],
    },
    /// Encoder counts; the velocity comes from the tracking observer.
    Counts([i32; N]),
}

/// Sensor reading and its age.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement<S, const N: usize> {
    /// The reading.
    pub sensed: Sensed<S, N>,
    /// Ticks since it was taken; 0 is fresh.
    pub age_ticks: u32,
}

/// Command to the actuators: torques, or a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
// The tag is a word. With a byte tag, copies of the rest start at odd addresses and need three times the instructions.
#[repr(u32)]
pub enum Command<S, const N: usize> {
    /// Drive these torques.
    Drive {
        /// Actuator torque or force of each joint, N m or N.
        torque: [S; N],
        /// Limits that acted on each joint in this tick.
        limits: [LimitFlags; N],
    },
    /// Stop: release the drives, engage the brakes.
    Brake(Fault),
}
