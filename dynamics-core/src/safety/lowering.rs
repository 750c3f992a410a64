//! Lowering: without a host the arm moves to its rest pose instead of being let go.

use super::Rules;
use super::stop::slowed;
use crate::control::Reference;
use crate::joint::Limits;
use crate::scalar::Real;

/// The reference one tick on, on a straight line to the rest pose, and its new pace.
///
/// ```text
/// d = rest - q,   T = max_i |d_i| / v_i                    time left at full pace
/// p' = min(p + a h, 1, a T),   a = min_i(deceleration_i / v_i) / 2
/// q' = q + d p' h / T,   qd' = d p' / T
/// ```
///
/// The pace `p` rises linearly, and falls with the time left, so that no joint exceeds its speed `v_i` or its deceleration. All joints
/// arrive together. A reference that still moves from an earlier motion is stopped first, joint by joint. `None` for the reference: it is
/// at the rest pose.
pub(super) fn lowered<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    pace: &mut S,
    rest: &[S; N],
    rules: &Rules<S, N>,
    limits: &[Limits<S>; N],
) -> Option<Reference<S, N>> {
    let (zero, one) = (S::zero(), S::one());
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
    // Two ticks at full pace: the rest of the way in one tick.
    if left <= rules.period + rules.period {
        *pace = zero;
        return Some(Reference::at_rest(*rest));
    }
    *pace = smaller(smaller(*pace + quickness * rules.period, one), quickness * left);
    let rate = *pace / left;
    let mut next = *reference;
    for i in 0..N {
        let speed = (rest[i] - reference.q[i]) * rate;
        next.q[i] = reference.q[i] + speed * rules.period;
        next.qd[i] = speed;
        next.qdd[i] = (speed - reference.qd[i]) * rules.rate;
    }
    // In single precision the last steps may be too small to be one.
    if (0..N).all(|i| next.q[i] == reference.q[i]) && *pace < one {
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
