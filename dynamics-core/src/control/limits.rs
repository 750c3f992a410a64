//! Limits on references and torques, and which of them act.

use super::Reference;
use crate::joint::Limits;
use crate::scalar::Real;
use core::ops::{BitOr, BitOrAssign};

/// Which limits acted on a joint in a tick: a set of bits, stable on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct LimitFlags(u8);

impl LimitFlags {
    /// None acted.
    pub const NONE: Self = Self(0);
    /// The reference position was held at a position limit.
    pub const POSITION: Self = Self(1);
    /// The reference velocity was held at the velocity limit.
    pub const VELOCITY: Self = Self(2);
    /// The torque was held at the torque limit.
    pub const TORQUE: Self = Self(4);
    /// The change of torque was held at the torque-rate limit.
    pub const TORQUE_RATE: Self = Self(8);

    /// Each single flag with its name.
    pub const NAMES: [(Self, &'static str); 4] = [
        (Self::POSITION, "position"),
        (Self::VELOCITY, "velocity"),
        (Self::TORQUE, "torque"),
        (Self::TORQUE_RATE, "torque rate"),
    ];

    /// The bits.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// From bits; those that mean nothing are dropped.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits & 0xf)
    }

    /// Whether every flag of `other` is set.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    #[inline]
    fn when(self, condition: bool) -> Self {
        if condition { self } else { Self::NONE }
    }
}

impl BitOr for LimitFlags {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for LimitFlags {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

/// Hold a joint's reference inside its position and velocity limits.
///
/// At a position limit the part of velocity and acceleration that leads further out is taken away; at the velocity limit
/// the part of the acceleration that leads to more speed.
#[inline]
pub(super) fn limit_reference<S: Real, const N: usize>(
    reference: &mut Reference<S, N>,
    i: usize,
    limits: &Limits<S>,
) -> LimitFlags {
    let zero = S::zero();
    let (lo, hi) = limits.position;
    let below = reference.q[i] < lo;
    let above = reference.q[i] > hi;
    reference.q[i] = reference.q[i].clamp_to(lo, hi);
    if (above && reference.qd[i] > zero) || (below && reference.qd[i] < zero) {
        reference.qd[i] = zero;
    }
    let slow = -limits.velocity;
    let fast = limits.velocity;
    let too_fast = reference.qd[i] > fast;
    let too_slow = reference.qd[i] < slow;
    reference.qd[i] = reference.qd[i].clamp_to(slow, fast);
    let outward = reference.qdd[i] > zero && (above || too_fast);
    let inward = reference.qdd[i] < zero && (below || too_slow);
    if outward || inward {
        reference.qdd[i] = zero;
    }
    LimitFlags::POSITION.when(below || above) | LimitFlags::VELOCITY.when(too_fast || too_slow)
}

/// Hold a torque inside its limit and near the one before; `step` is the greatest change in one tick.
#[inline]
pub(super) fn limit_torque<S: Real>(torque: S, last: Option<S>, step: S, limit: S) -> (S, LimitFlags) {
    let bounded = torque.clamp_symmetric(limit);
    let mut flags = LimitFlags::TORQUE.when(bounded != torque);
    let Some(last) = last else {
        return (bounded, flags);
    };
    let near = bounded.clamp_to(last - step, last + step);
    flags |= LimitFlags::TORQUE_RATE.when(near != bounded);
    (near, flags)
}
