//! Lowering: without a host the arm moves slowly to its rest pose, instead of losing its torque where it is.

use super::measured::JudgedInput;
use super::stop::slowed;
use super::{JointRules, Rules};
use crate::control::Reference;
use crate::joint::Limits;
use crate::scalar::Real;

/// Shares of the joint's reach: the lag from which the reference waits for a joint, the lag to which it is then drawn back, and the lag below
/// which it goes on. A blocked arm keeps the lag to which the reference was drawn back; an arm that is free again lags less.
const WAITS: f64 = 0.5;
const DRAWN: f64 = 1.0 / 3.0;
const GOES_ON: f64 = 0.3;

/// The greatest lag, as a share of the joint's reach, and the joint that has it.
///
/// A joint that is ahead counts too: something moves it away.
fn lag<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    seen: &JudgedInput<'_, S, N>,
    rules: &Rules<S, N>,
) -> (S, u8) {
    let (mut most, mut joint) = (S::zero(), 0);
    for i in 0..N {
        let its = (reference.q[i] - seen.q[i]).abs() / rules.joints[i].reach;
        if its > most {
            (most, joint) = (its, i as u8);
        }
    }
    (most, joint)
}

/// Share of the full pace at which the arm can be lowered, with the joint that lags most; `waits` is true while the reference waits for it.
///
/// ```text
/// f = clamp(2 - 3 max_i(|reference_i - q_i| / reach_i), 0, 1),   0 while it waits
/// ```
///
/// It is full up to a third of the reach, and half at half of the reach, where waiting begins. So the greatest lag against an obstacle is half
/// of the reach plus the distance in which the reference stops, `v_i^2 / deceleration_i`.
pub(super) fn followed<S: Real, const N: usize>(
    waits: &mut bool,
    reference: &Reference<S, N>,
    seen: &JudgedInput<'_, S, N>,
    rules: &Rules<S, N>,
) -> (S, u8) {
    let (lag, joint) = lag(reference, seen, rules);
    *waits = lag > S::literal(if *waits { GOES_ON } else { WAITS });
    let share = S::literal(2.0) - S::literal(3.0) * lag;
    (if *waits { S::zero() } else { smaller(share, S::one()) }, joint)
}

/// Draws a reference at rest one tick back, at the joints' lowering speeds, towards joints that lag by more than a third of their reach. So
/// the torque against an obstacle falls, and the arm starts slowly when the obstacle is removed.
pub(super) fn drawn_back<S: Real, const N: usize>(
    reference: &mut Reference<S, N>,
    seen: &JudgedInput<'_, S, N>,
    rules: &Rules<S, N>,
) {
    for i in 0..N {
        let JointRules { reach, lowering_speed, .. } = rules.joints[i];
        let (lag, near) = (reference.q[i] - seen.q[i], S::literal(DRAWN) * reach);
        // The excess over a third of the reach, limited to one tick's motion.
        let beyond = lag - lag.clamp_symmetric(near);
        reference.q[i] -= beyond.clamp_symmetric(lowering_speed * rules.period);
        reference.qdd[i] = S::zero();
    }
}

/// The reference one tick on, on a straight line to the rest pose, and its new pace.
///
/// ```text
/// d = rest - q,   T = max_i |d_i| / v_i                    time left at full pace
/// p' = min(clamp(f, p - a h, p + a h), a T),   a = min_i(deceleration_i / v_i) / 2
/// q' = q + d p' h / T,   qd' = d p' / T
/// ```
///
/// The pace `p` changes linearly, towards the share `f` at which the arm [follows](followed), and falls with the time left, so that no joint
/// exceeds its speed `v_i` or its deceleration. All joints arrive together. A reference that still moves from an earlier motion is stopped
/// first, joint by joint. `None` for the reference: it is at the rest pose.
pub(super) fn lowered<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    pace: &mut S,
    share: S,
    rest: &[S; N],
    rules: &Rules<S, N>,
    limits: &[Limits<S>; N],
) -> Option<Reference<S, N>> {
    let zero = S::zero();
    let moves = (0..N).any(|i| reference.qd[i] != zero);
    if *pace <= zero && moves {
        return Some(slowed(reference, rules, limits));
    }
    let (mut left, mut quickness) = (zero, S::MAX);
    for i in 0..N {
        let joint = &rules.joints[i];
        left = larger(left, (rest[i] - reference.q[i]).abs() / joint.lowering_speed);
        quickness = smaller(quickness, S::literal(0.5) * joint.deceleration / joint.lowering_speed);
    }
    if left <= zero && !moves {
        return None;
    }
    // At most two ticks are left at full pace: the rest of the path in one tick.
    if left <= rules.period + rules.period {
        *pace = zero;
        return Some(Reference::at_rest(*rest));
    }
    let step = quickness * rules.period;
    let last = quickness * left;
    *pace = smaller(share.clamp_to(*pace - step, *pace + step), last);
    let rate = *pace / left;
    let mut next = *reference;
    for i in 0..N {
        let speed = (rest[i] - reference.q[i]) * rate;
        next.q[i] = reference.q[i] + speed * rules.period;
        next.qd[i] = speed;
        next.qdd[i] = (speed - reference.qd[i]) * rules.rate;
    }
    // In single precision the last steps may be too small to change the position, and so may the first ones and those of an arm that is waited for.
    if *pace >= last && (0..N).all(|i| next.q[i] == reference.q[i]) {
        *pace = zero;
        return Some(Reference::at_rest(*rest));
    }
    Some(next)
}

fn larger<S: Real>(a: S, b: S) -> S {
    if a >= b { a } else { b }
}

fn smaller<S: Real>(a: S, b: S) -> S {
    if a <= b { a } else { b }
}
