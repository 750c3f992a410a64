//! Limits on references and torques, and which of them act.

use super::{Fault, Reference};
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
    /// The reference was not followed, because this joint has felt a collision.
    pub const COLLISION: Self = Self(16);
    /// The joint's motor is warm: the torque beyond the weight is limited to less than the torque limit.
    pub const HEAT: Self = Self(32);

    /// Each single flag with its name.
    pub const NAMES: [(Self, &'static str); 6] = [
        (Self::POSITION, "position"),
        (Self::VELOCITY, "velocity"),
        (Self::TORQUE, "torque"),
        (Self::TORQUE_RATE, "torque rate"),
        (Self::COLLISION, "collision"),
        (Self::HEAT, "heat"),
    ];

    /// The bits.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// True if a limit acted on some joint. Compares all flags as a whole: words, not bytes.
    #[inline]
    pub(crate) fn any<const N: usize>(flags: &[Self; N]) -> bool {
        flags.map(Self::bits) != [0; N]
    }

    /// From bits; unknown bits are dropped.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits & 0x3f)
    }

    /// True if every flag of `other` is set.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// True if any flag of `other` is set.
    #[inline]
    #[must_use]
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    #[inline]
    pub(crate) fn when(self, condition: bool) -> Self {
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

/// True if every value of a reference is a finite number and no limit acts on it.
///
/// Nearly every tick takes this path: two comparisons for the position, one for the velocity, and one for all
/// accelerations.
#[inline]
pub(crate) fn reference_is_inside<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    limits: &[Limits<S>; N],
) -> bool {
    let mut sum = S::zero();
    for i in 0..N {
        let (lo, hi) = limits[i].position;
        // Without a limit, an infinite value would count as inside.
        let (lo, hi) = (lo.clamp_symmetric(S::MAX), hi.clamp_symmetric(S::MAX));
        let velocity = limits[i].velocity.clamp_symmetric(S::MAX);
        if !(reference.q[i] >= lo && reference.q[i] <= hi && reference.qd[i].abs() <= velocity) {
            return false;
        }
        // Zero for a finite number, NaN otherwise; the sum is then NaN too.
        sum += reference.qdd[i] * S::zero();
    }
    sum == S::zero()
}

/// Limits a reference to the position and velocity limits, and records which of them acted.
///
/// At a position limit the part of velocity and acceleration that leads further out is taken away; at the velocity limit
/// the part of the acceleration that leads to more speed.
#[cold]
pub(super) fn hold_reference<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    limits: &[Limits<S>; N],
    flags: &mut [LimitFlags; N],
) -> Reference<S, N> {
    let mut held = *reference;
    for i in 0..N {
        flags[i] = hold_joint(&mut held.q[i], &mut held.qd[i], &mut held.qdd[i], &limits[i]);
    }
    held
}

/// As [`hold_reference`], with the position limits extended to the reference's current position: beyond a limit it moves no farther out.
#[cold]
pub(crate) fn hold_near<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    now: &[S; N],
    limits: &[Limits<S>; N],
    flags: &mut [LimitFlags; N],
) -> Reference<S, N> {
    let mut held = *reference;
    for i in 0..N {
        let (lo, hi) = limits[i].position;
        let beyond = reference.q[i] < lo || reference.q[i] > hi;
        let near = Limits { position: around(limits[i].position, now[i]), ..limits[i] };
        flags[i] =
            hold_joint(&mut held.q[i], &mut held.qd[i], &mut held.qdd[i], &near) | LimitFlags::POSITION.when(beyond);
    }
    held
}

/// A range, extended to a position.
pub(crate) fn around<S: Real>((lo, hi): (S, S), q: S) -> (S, S) {
    (if q < lo { q } else { lo }, if q > hi { q } else { hi })
}

fn hold_joint<S: Real>(q: &mut S, qd: &mut S, qdd: &mut S, limits: &Limits<S>) -> LimitFlags {
    let zero = S::zero();
    let (lo, hi) = limits.position;
    let (below, above) = (*q < lo, *q > hi);
    *q = q.clamp_to(lo, hi);
    if (above && *qd > zero) || (below && *qd < zero) {
        *qd = zero;
    }
    let (too_slow, too_fast) = (*qd < -limits.velocity, *qd > limits.velocity);
    *qd = qd.clamp_symmetric(limits.velocity);
    let outward = *qdd > zero && (above || too_fast);
    let inward = *qdd < zero && (below || too_slow);
    if outward || inward {
        *qdd = zero;
    }
    LimitFlags::POSITION.when(below || above) | LimitFlags::VELOCITY.when(too_fast || too_slow)
}

/// Limits torques to their range and to the allowed change from the last ones, and records which limits acted.
///
/// `rated` holds the greatest steps of the configuration, `step` those of this tick. If `rated` is infinite, the step
/// is not checked; if that is known at build time, the check costs nothing.
///
/// # Errors
/// [`Fault::NonFiniteTorque`] for a torque that is NaN or infinite; torques of earlier joints may already have been limited.
// Called instead of inlined, it would take its arguments through memory in every tick.
#[inline(always)]
pub(crate) fn hold_torques<S: Real, const N: usize>(
    torque: &mut [S; N],
    flags: &mut [LimitFlags; N],
    limits: &[Limits<S>; N],
    last: &[S; N],
    step: &[S; N],
    rated: &[S; N],
) -> Result<(), Fault> {
    for i in 0..N {
        let limit = limits[i].torque;
        let rated = rated[i] <= S::MAX;
        if torque_is_inside(torque[i], limit) && (!rated || step_is_inside(torque[i], last[i], step[i])) {
            continue;
        }
        if !torque[i].is_finite() {
            return Err(Fault::NonFiniteTorque { joint: i as u8 });
        }
        let (held, acted) = hold_torque(torque[i], last[i], step[i], limit);
        torque[i] = held;
        flags[i] |= acted;
    }
    Ok(())
}

/// As [`hold_torques`], without a limit on the rate. A separate function, so that the steps of `hold_torques` stay constants of the program.
#[cold]
#[inline(never)]
pub(super) fn bound_torques<S: Real, const N: usize>(
    torque: &mut [S; N],
    flags: &mut [LimitFlags; N],
    limits: &[Limits<S>; N],
) -> Result<(), Fault> {
    for i in 0..N {
        if !torque[i].is_finite() {
            return Err(Fault::NonFiniteTorque { joint: i as u8 });
        }
        let bounded = torque[i].clamp_symmetric(limits[i].torque);
        flags[i] |= LimitFlags::TORQUE.when(bounded != torque[i]);
        torque[i] = bounded;
    }
    Ok(())
}

/// True if a torque is a finite number inside its limit.
#[inline]
fn torque_is_inside<S: Real>(torque: S, limit: S) -> bool {
    torque.abs() <= limit.clamp_symmetric(S::MAX)
}

/// True if a torque is near the one before.
#[inline]
fn step_is_inside<S: Real>(torque: S, last: S, step: S) -> bool {
    (torque - last).abs() <= step
}

/// Limits a torque to its range and to the allowed change from the last one; `step` is the greatest change in one tick.
#[cold]
fn hold_torque<S: Real>(torque: S, last: S, step: S, limit: S) -> (S, LimitFlags) {
    let bounded = torque.clamp_symmetric(limit);
    let near = bounded.clamp_to(last - step, last + step);
    (near, LimitFlags::TORQUE.when(bounded != torque) | LimitFlags::TORQUE_RATE.when(near != bounded))
}
