//! The ordinary tick: an arm that runs, and goes on.
//!
//! Nearly every tick is one of these. All rules hold in it, most of them by far, so one comparison a rule is enough and nothing
//! has to be named. Where a comparison fails, nothing is said yet: [`super::decision`] applies the exact rules from the beginning. So a
//! comparison may be stricter than its rule, and never laxer.

use super::measured::JudgedInput;
use super::{Inputs, Rules};
use crate::control::{ControllerConfig, Reference, believed};
use crate::joint::Limits;
use crate::scalar::Real;

/// Share of a bound's size that the comparisons keep away from it: more than the rounding of either side in f32.
const MARGIN: f64 = 1.0 / 524_288.0;

/// True if there is no request, no fault outside, the host is there, no drive is off. The readings are to be of this tick.
#[inline]
pub(super) fn is_quiet<S: Real, const N: usize>(inputs: &Inputs<S, N>, rules: &Rules<S, N>) -> bool {
    // Arrays as a whole: words are compared, not bytes.
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
/// With the way `d` that a joint needs to stop, `|qd| latency + qd^2 / (2 a)` in the direction of `qd`, it stays within `c - h` and
/// `c + h` on all of that way if `|q + d/2 - c| + |d/2| <= h`.
///
/// Cost: about 50 operations a joint, all of them constants of the program but the state.
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
        // False for NaN, as every comparison here.
        let near = (seen.read[i] - last[i]).abs() <= rule.jump_step + rule.resolution;
        if !near {
            return false;
        }
    }
    for i in 0..N {
        let (lo, hi, speed_max) = believed(config, i);
        let (q, qd) = (seen.q[i], seen.qd[i]);
        // The reading may be this far from the estimate, and has to be inside too.
        let beside = (seen.read[i] - q).abs();
        if !(reach(q, half_way(qd, rules, i), (lo, hi)) + beside <= half((lo, hi)) && is_within(qd, speed_max)) {
            return false;
        }
    }
    // NaN or infinite where an acceleration is.
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

/// Half of the way that a joint needs to stop, in the direction of its velocity.
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

/// The middle of a range; of one without ends, zero.
#[inline]
fn middle<S: Real>((lo, hi): (S, S)) -> S {
    let finite = lo.abs() <= S::MAX && hi.abs() <= S::MAX;
    if finite { S::literal(0.5) * (lo + hi) } else { S::zero() }
}

/// Half of a range, less the margin. Of one without ends, every number; of one with one end, none: the exact rules have to look.
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
