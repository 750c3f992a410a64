//! Numbers of the safety rules.

use super::SafeAction;
use crate::control::{Configuration as ControlConfiguration, ControllerConfig};
use crate::fields::record;
use crate::inertia::InertiaBounds;

record! {
    /// Numbers of one joint.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct JointRules<S> {
        /// Speed up to which the joint is at rest, rad/s or m/s.
        pub rest_speed: S,
        /// Greatest motion of the joint in one tick, rad or m: a multiple of its velocity limit times the period.
        pub jump_step: S,
        /// Error of a position that does not count as a jump, rad or m: an encoder's resolution and noise.
        pub resolution: S,
        /// Deceleration that the joint is sure to have, rad/s^2 or m/s^2.
        pub deceleration: S,
        /// How far the reference may be from the joint, rad or m.
        pub reach: S,
        /// How far the speed of the first reference may be from the joint's, rad/s or m/s.
        pub reach_speed: S,
        /// Greatest reflected rotor inertia that can be told at run time, kg m^2 or kg.
        pub rotor_max: S,
        /// Velocity gain of a damped stop, N m s/rad or N s/m, for drives that take one.
        pub damping: S,
    }
}

record! {
    /// Numbers of the machine around one controller.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Rules<S, const N: usize> {
        /// Action of the drives when no torque is commanded.
        pub safe_action: SafeAction,
        /// Longest silence of the host, ticks.
        pub heartbeat_max: u32,
        /// How long the arm holds without the host before the safe action, ticks.
        pub hold_max: u32,
        /// Lowest and highest supply voltage, V.
        pub supply: (S, S),
        /// Lowest and highest temperature, degrees Celsius.
        pub temperature: (S, S),
        /// Control period, s.
        pub period: S,
        /// Control rate, Hz.
        pub rate: S,
        /// Time from a measurement to the resulting torque, s: added to the braking distance as time at full speed.
        pub latency: S,
        /// Bounds on a payload that is set at run time, about the last link's origin.
        pub payload: InertiaBounds<S>,
        /// Numbers of each joint.
        pub joints: [JointRules<S>; N],
    }
}

/// Where a machine finds its numbers: limits, guards, encoders and observer are the controller's own.
///
/// A firmware implements it for a type without a size, as it does [`crate::control::Configuration`].
pub trait Configuration<S, const N: usize>: ControlConfiguration<S, N> {
    /// The rules; always the same.
    fn rules(&self) -> &Rules<S, N>;
}

/// A controller's configuration and the rules around it, as values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Protected<S, const N: usize> {
    /// The controller's.
    pub control: ControllerConfig<S, N>,
    /// The machine's.
    pub rules: Rules<S, N>,
}

impl<S, const N: usize> ControlConfiguration<S, N> for Protected<S, N> {
    #[inline]
    fn get(&self) -> &ControllerConfig<S, N> {
        &self.control
    }
}

impl<S, const N: usize> Configuration<S, N> for Protected<S, N> {
    #[inline]
    fn rules(&self) -> &Rules<S, N> {
        &self.rules
    }
}
