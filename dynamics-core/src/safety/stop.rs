//! Braking: the check that there is enough distance for it, and the reference that does it.

use super::Rules;
use crate::control::{Reference, around};
use crate::joint::Limits;
use crate::scalar::Real;

/// True if a joint at `q` with the velocity `qd` can still stop between `lo` and `hi`.
///
/// `|qd| latency + qd^2 / (2 a) <= room`, with `room` the distance to the limit in the direction of motion. A joint at rest, or
/// one that moves back inside, can always stop.
///
/// No division: `qd^2 <= 2 a (room - |qd| latency)`. False if `q` or `qd` is NaN.
#[inline]
pub(super) fn can_stop<S: Real>(q: S, qd: S, (lo, hi): (S, S), deceleration: S, latency: S) -> bool {
    let (zero, speed) = (S::zero(), qd.abs());
    let room = if qd > zero { hi - q } else { q - lo };
    speed <= zero || speed * speed <= (deceleration + deceleration) * (room - speed * latency)
}

/// The reference one tick later, each joint slowed down by its deceleration until it rests.
///
/// ```text
/// v' = v - clamp(v, -a h, a h),   q' = q + h (v + v') / 2,   a' = (v' - v) / h
/// ```
///
/// It starts inside the velocity limits, because the reference was limited before, and stays there. The same holds for the position limits;
/// beyond one it moves no farther out.
pub(super) fn slowed<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    rules: &Rules<S, N>,
    limits: &[Limits<S>; N],
) -> Reference<S, N> {
    let half = S::literal(0.5);
    let mut next = *reference;
    for i in 0..N {
        let v = reference.qd[i].clamp_symmetric(limits[i].velocity);
        let (lo, hi) = around(limits[i].position, reference.q[i]);
        let slower = v - v.clamp_symmetric(rules.joints[i].deceleration * rules.period);
        next.q[i] = (reference.q[i] + rules.period * half * (v + slower)).clamp_to(lo, hi);
        next.qd[i] = slower;
        next.qdd[i] = (slower - v) * rules.rate;
    }
    next
}
