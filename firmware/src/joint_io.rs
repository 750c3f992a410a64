//! Ways of reaching the joints, without a chip in them: tested on the host against models of what is at the other end.
//!
//! | module | holds |
//! |---|---|
//! | [`mit`] | the frames of MIT-mode actuators |
//! | [`bus_time`] | how long frames take on a CAN bus, and how fast a schedule can be |
//! | [`can`] | actuators on two CAN buses: who is asked when, and what answers are believed |
//! | [`as5047p`] | the magnetic encoder: its words, its errors, its turns |
//! | [`pwm`] | torque to duty cycle, H-bridges, and the encoders beside them |
//!
//! Every function here is total: what a wire brings becomes a value, a count or a fault bit of a joint, never a panic, and
//! no loop waits for hardware without a bound.

pub mod as5047p;
pub mod bus_time;
pub mod can;
pub mod mit;
pub mod pwm;

use core::convert::Infallible;
use core::ops::{BitOr, BitOrAssign};
use dynamics_core::control::{Measurement, Sensed};
use embedded_hal::digital::{ErrorType, OutputPin};

/// Ticks without a measurement after which a joint is at fault.
///
/// The joint's measurement is one tick older each time. The controller's own limit (`age_max` of the scene) comes first
/// where it is lower.
pub const MISSING_MAX: u32 = 3;

/// What is wrong with a joint: a set of bits, stable in telemetry. Any of them stops the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct JointFaults(u8);

impl JointFaults {
    /// Nothing.
    pub const NONE: Self = Self(0);
    /// No measurement since [`MISSING_MAX`] ticks, or none ever.
    pub const MISSING: Self = Self(1);
    /// The drive reports an error of its own.
    pub const DRIVE: Self = Self(2);
    /// The position is at the end of what a reply can carry: the true one may lie beyond.
    pub const RANGE: Self = Self(4);
    /// The sensor doubts itself: its magnet is too far or too near.
    pub const SENSOR: Self = Self(8);
    /// The sensor moved further than the joint can, and its turn is lost. Stays until the sensor is started anew.
    pub const LOST: Self = Self(16);
    /// The bus is off.
    pub const BUS: Self = Self(32);
    /// The last torque was NaN or infinite, and none was driven.
    pub const NON_FINITE: Self = Self(64);
    /// A pin or a PWM channel refused.
    pub const OUTPUT: Self = Self(128);

    /// Each single bit with its name.
    pub const NAMES: [(Self, &'static str); 8] = [
        (Self::MISSING, "measurement missing"),
        (Self::DRIVE, "drive error"),
        (Self::RANGE, "position at the end of its range"),
        (Self::SENSOR, "sensor doubtful"),
        (Self::LOST, "turn lost"),
        (Self::BUS, "bus off"),
        (Self::NON_FINITE, "torque not finite"),
        (Self::OUTPUT, "output refused"),
    ];

    /// The bits.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether every bit of `other` is set.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether any bit of `other` is set.
    #[inline]
    #[must_use]
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// These bits and those of `other`.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// All but the bits of `other`.
    #[inline]
    #[must_use]
    pub(crate) const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// These bits, where the condition holds.
    #[inline]
    #[must_use]
    pub(crate) fn when(self, condition: bool) -> Self {
        if condition { self } else { Self::NONE }
    }
}

impl BitOr for JointFaults {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for JointFaults {
    fn bitor_assign(&mut self, other: Self) {
        *self = *self | other;
    }
}

/// What the joints say in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings<const N: usize> {
    /// Positions and velocities, or counts.
    pub sensed: Sensed<f32, N>,
    /// Torque or force that each drive reports or is estimated to give, N m or N.
    pub torque: [f32; N],
    /// Ticks since each joint's measurement; 0 is fresh, `u32::MAX` is never.
    pub age_ticks: [u32; N],
    /// What is wrong with each joint.
    pub faults: [JointFaults; N],
}

impl<const N: usize> Readings<N> {
    /// What the controller takes: as old as the oldest of its parts.
    #[must_use]
    pub fn measurement(&self) -> Measurement<f32, N> {
        Measurement { sensed: self.sensed, age_ticks: self.age_ticks.into_iter().max().unwrap_or(u32::MAX) }
    }

    /// Whether any joint is at fault.
    #[must_use]
    pub fn is_faulty(&self) -> bool {
        self.faults.iter().any(|&faults| faults != JointFaults::NONE)
    }
}

pub use dynamics_core::safety::SafeAction;

/// The joints, as the tick sees them: once a tick [`JointIo::measure`], then [`JointIo::drive`] or [`JointIo::safe`].
pub trait JointIo<const N: usize> {
    /// What the joints say; `None` where measurements come over the link.
    fn measure(&mut self) -> Option<Readings<N>>;

    /// Drive these torques or forces, N m or N, with open brakes. A drive that is off is switched on first, and gives its
    /// torque from the next tick on.
    fn drive(&mut self, torque: &[f32; N]);

    /// Stop, in one tick and from any state. Called in every tick that does not drive; where the wire asks for it, it also
    /// asks for the next measurement.
    fn safe(&mut self, action: SafeAction);
}

/// A line that is not there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoPin;

impl ErrorType for NoPin {
    type Error = Infallible;
}

impl OutputPin for NoPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
