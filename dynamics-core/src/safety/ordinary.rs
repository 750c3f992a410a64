//! The ordinary tick: an arm that runs, and goes on.
//!
//! Nearly every tick is ordinary: it meets all rules, and most of them by a large margin. So one comparison a rule is enough, and no reason
//! has to be found. If a comparison fails, nothing is decided yet: [`super::decision`] applies the exact rules from the beginning. A
//! comparison may therefore be stricter than its rule, and never laxer.

use super::measured::JudgedInput;
use super::{Inputs, Rules};
use crate::control::{ControllerConfig, Reference, believed};
use crate::joint::Limits;
use crate::scalar::Real;

/// Distance that the comparisons keep from a bound, as a share of its size: more than the rounding of either side in f32.
const MARGIN: f64 = 1.0 / 524_288.0;

/// True if there is no request and no external fault, the host is heard, and no drive is off. The caller checks that the readings are fresh.
#[inline]
pub(super) fn is_quiet<S: Real, const N: usize>(inputs: &Inputs<S, N>, rules: &Rules<S, N>) -> bool {
    // The arrays are compared as a whole: words, not bytes.
    let drives = inputs.drive_fault != [false; N] || inputs.on != [true; N];
    let wrong = drives
        | inputs.emergency_stop
        | inputs.overrun
        | inputs.zero_lost
        | (rules.live != 0 && rules.live_max != 0 && inputs.live_age > rules.live_max);
    // False for NaN.
    let inside = |value: Option<S>, (lo, hi): (S, S)| value.is_none_or(|x| x >= lo && x <= hi);
    !wrong
        && inputs.request.is_none()
        && inputs.heartbeat_age <= rules.heartbeat_max
        && inside(inputs.supply, rules.supply)
        && inside(inputs.temperature, rules.temperature)
}

/// True if arm and reference are within bounds, close to each other, and able to stop in time. `last` are the positions of the tick
/// before.
///
/// A joint needs the distance `d` to stop, `|qd| latency + qd^2 / (2 a)` in the direction of `qd`. On all of that distance it stays within
/// `c - h` and `c + h` if `|q + d/2 - c| + |d/2| <= h`.
///
/// Cost: about 50 operations a joint; everything but the state is a constant of the program.
#[inline]
pub(super) fn goes_on<S: Real, const N: usize>(
    seen: &JudgedInput<'_, S, N>,
    last: &[S; N],
    reference: &Reference<S, N>,
    config: &ControllerConfig<S, N>,
    rules: &Rules<S, N>,
) -> bool {
    // Three short loops: the compiler unrolls each, and the numbers of every joint become constants.
    for i in 0..N {
        let rule = &rules.joints[i];
        // False for NaN, like every comparison here.
        let near = (seen.read[i] - last[i]).abs() <= rule.jump_step + rule.resolution;
        if !near {
            return false;
        }
    }
    for i in 0..N {
        let (lo, hi, speed_max) = believed(config, i);
        let (q, qd) = (seen.q[i], seen.qd[i]);
        // The reading differs from the estimate by this much, and has to be inside too.
        let beside = (seen.read[i] - q).abs();
        if !(reach(q, half_way(qd, rules, i), (lo, hi)) + beside <= half((lo, hi)) && is_within(qd, speed_max)) {
            return false;
        }
    }
    // The sum is NaN or infinite if an acceleration is.
    let mut sum = S::zero();
    for i in 0..N {
        let Limits { position, velocity, .. } = config.limits[i];
        let (q, qd) = (reference.q[i], reference.qd[i]);
        if !(reach(q, half_way(qd, rules, i), position) <= half(position) && is_within(qd, velocity)) {
            return false;
        }
        let near = (q - seen.q[i]).abs() <= rules.joints[i].reach;
        if !near {
            return false;
        }
        sum += reference.qdd[i];
    }
    sum.abs() <= S::MAX
}

/// Half of the distance that a joint needs to stop, in the direction of its velocity, rad or m.
#[inline]
fn half_way<S: Real, const N: usize>(qd: S, rules: &Rules<S, N>, i: usize) -> S {
    let half_latency = S::literal(0.5) * rules.latency;
    let per_speed = S::literal(0.25) / rules.joints[i].deceleration;
    qd * (qd.abs() * per_speed + half_latency)
}

/// Greatest distance of a joint from the middle of its range.
#[inline]
fn reach<S: Real>(q: S, half_way: S, range: (S, S)) -> S {
    (q + half_way - middle(range)).abs() + half_way.abs()
}

/// The middle of a range; zero for a range without ends.
#[inline]
fn middle<S: Real>((lo, hi): (S, S)) -> S {
    let finite = lo.abs() <= S::MAX && hi.abs() <= S::MAX;
    if finite { S::literal(0.5) * (lo + hi) } else { S::zero() }
}

/// Half of a range, less the margin. Without ends: the largest number. With one end: negative, so that the exact rules decide.
#[inline]
fn half<S: Real>((lo, hi): (S, S)) -> S {
    let (below, above) = (lo.abs(), hi.abs());
    if below <= S::MAX && above <= S::MAX {
        S::literal(0.5) * (hi - lo) - S::literal(MARGIN) * (below + above)
    } else if below > S::MAX && above > S::MAX {
        S::MAX
    } else {
        -S::one()
    }
}

/// True if a speed is a number within its bound, which may be infinite.
#[inline]
fn is_within<S: Real>(speed: S, bound: S) -> bool {
    speed.abs() <= bound.clamp_symmetric(S::MAX)
}
