//! Numbers of the safety rules.

use super::heat::HeatRules;
use crate::control::{Configuration as ControlConfiguration, ControllerConfig};
use crate::fields::{record, words};
use crate::inertia::InertiaBounds;

/// Action of the drives when no torque is commanded.
///
/// No action needs a value that a failed sensor could have given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SafeAction {
    /// Drives off, brakes engaged: for an arm with holding brakes.
    Brake,
    /// The drives damp the motion without commands: windings shorted through one side of the bridge, or, in a drive that has one, a velocity gain
    /// ([`JointRules::damping`]) without position gain and torque. The arm sinks slowly.
    DampedStop,
    /// Drives off: for an arm that does not fall without torque.
    Off,
}

words!(SafeAction { Brake = 0, DampedStop = 1, Off = 2 });

/// Live input of a scene: data of the dynamics that arrive over the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LiveInput {
    /// Gravitational acceleration.
    Gravity,
    /// Payload at the tip.
    Payload,
    /// Wrench of the environment on the tip.
    TipWrench,
    /// Reflected rotor inertias.
    Rotors,
}

impl LiveInput {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 4] = [Self::Gravity, Self::Payload, Self::TipWrench, Self::Rotors];

    /// The stable number: gravity 1, payload 2, tip wrench 3, rotors 4.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Gravity => 1,
            Self::Payload => 2,
            Self::TipWrench => 3,
            Self::Rotors => 4,
        }
    }

    /// The input's bit in [`Rules::live`].
    #[must_use]
    pub const fn bit(self) -> u32 {
        1 << (self.code() - 1)
    }

    /// The first input of a set of bits; gravity for the empty set.
    pub(super) fn first(bits: u32) -> Self {
        match bits.trailing_zeros() {
            1 => Self::Payload,
            2 => Self::TipWrench,
            3 => Self::Rotors,
            _ => Self::Gravity,
        }
    }
}

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
        /// Deceleration that the joint can always reach, rad/s^2 or m/s^2.
        pub deceleration: S,
        /// Largest distance of the reference from the joint, rad or m.
        pub reach: S,
        /// Largest difference between the speed of the first reference and the joint's, rad/s or m/s.
        pub reach_speed: S,
        /// Greatest reflected rotor inertia that can be set at run time, kg m^2 or kg.
        pub rotor_max: S,
        /// Velocity gain of a damped stop, N m s/rad or N s/m, for drives that take one.
        pub damping: S,
        /// Greatest speed of the joint on the path to the rest pose without a host, rad/s or m/s; above zero.
        pub lowering_speed: S,
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
        /// Time for which the arm holds without the host before the safe action, ticks. It is also the longest total wait of lowering for joints that
        /// lag, but not more than half a second.
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
        /// Longest time to switch the drives on, ticks.
        pub arming_max: u32,
        /// Longest time that the brakes need to engage after they lose power, ticks. Torque goes on for this time when the arm is disarmed.
        /// 0 for an arm without brakes.
        pub brake_delay: u32,
        /// Live inputs that the scene needs: bits of [`LiveInput::bit`].
        pub live: u32,
        /// Greatest age of the live inputs while the arm runs, ticks; 0 for no limit.
        pub live_max: u32,
        /// Pose to which the arm moves, after `hold_max`, if the host stays silent, rad or m; `None` for the safe action instead.
        pub rest: Option<[S; N]>,
        /// Share of the velocity limit, and of the torque limit beyond the weight, that an arm may use after homing until
        /// [`FullRange`](super::Request::FullRange); `None` for no such limit.
        pub first_motion: Option<S>,
        /// Heat models of the motors; `None` if no motor's is known. One motor is updated in each tick, so each motor is updated every
        /// `N` ticks.
        pub heat: Option<[HeatRules<S>; N]>,
        /// Bounds on a payload that is set at run time, about the last link's origin.
        pub payload: InertiaBounds<S>,
        /// Numbers of each joint.
        pub joints: [JointRules<S>; N],
    }
}

/// Source of a machine's numbers: limits, guards, encoders and observer are the controller's own.
///
/// A firmware implements it for a type without a size, as it does [`crate::control::Configuration`].
pub trait SafetyConfiguration<S, const N: usize>: ControlConfiguration<S, N> {
    /// The rules; always the same.
    fn rules(&self) -> &Rules<S, N>;
}

/// A controller's configuration and the rules around it, as values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Protected<S, const N: usize> {
    /// The controller's configuration.
    pub control: ControllerConfig<S, N>,
    /// The machine's rules.
    pub rules: Rules<S, N>,
}

impl<S, const N: usize> ControlConfiguration<S, N> for Protected<S, N> {
    #[inline]
    fn get(&self) -> &ControllerConfig<S, N> {
        &self.control
    }
}

impl<S, const N: usize> SafetyConfiguration<S, N> for Protected<S, N> {
    #[inline]
    fn rules(&self) -> &Rules<S, N> {
        &self.rules
    }
}
