//! Samples in which dry friction holds a joint.
//!
//! The torque of a held joint can have any value between the breakaway torques of the two directions. It is not a function of the motion, so such
//! rows have zero weight in the fit, and no error counts them. In a log of static postures nearly every sample is held. There the rows are kept, and
//! the friction is that left by the last motion ([`crate::friction::Direction::Hysteresis`]).

use crate::Series;
use crate::statistics::median;

/// Time before and after a sample in which a held joint must not move, in `1 / cut-off` of the torque filter.
const STILL: f64 = 0.1;
/// Time around a held sample in which the torque filter still mixes in its torque, in `1 / cut-off`.
const MIXED: f64 = 0.5;
/// Range of a position at rest, in standard deviations of its noise.
const RANGE: f64 = 9.0;
/// Range of a position at rest without noise, rad or m.
const LEAST: f64 = 1e-7;
/// Share of held samples above which a log counts as one of static postures.
const RESTS: f64 = 0.8;

/// Returns, for each joint and sample, true if friction holds the joint. All false in a log in which the joint rests nearly always.
///
/// | name | quantity | unit |
/// |---|---|---|
/// | `q` | positions as measured, evenly in time | rad, m |
/// | `rate` | samples a second | Hz |
/// | `cutoff` | cut-off of the torque filter | Hz |
#[must_use]
pub fn held(q: &Series, rate: f64, cutoff: f64) -> Vec<Vec<bool>> {
    let still = (STILL * rate / cutoff).ceil() as usize;
    let mixed = (MIXED * rate / cutoff).ceil() as usize;
    q.iter().map(|q| of_joint(q, still, mixed)).collect()
}

fn of_joint(q: &[f64], still: usize, mixed: usize) -> Vec<bool> {
    let count = q.len();
    let limit = (RANGE * noise(q)).max(LEAST);
    let around = |k: usize, reach: usize| k.saturating_sub(reach)..(k + reach + 1).min(count);
    let rests = |k: usize| {
        let (low, high) = q[around(k, still)].iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
        high - low <= limit
    };
    let rests: Vec<bool> = (0..count).map(rests).collect();
    if rests.iter().filter(|rests| **rests).count() as f64 > RESTS * count as f64 {
        return vec![false; count];
    }
    (0..count).map(|k| rests[around(k, mixed)].contains(&true)).collect()
}

/// Standard deviation of a position's noise, from the median of third differences. A smooth motion contributes little to them, and a jolt does not
/// change the median.
fn noise(q: &[f64]) -> f64 {
    let third = q.windows(4).map(|q| (q[3] - 3.0 * q[2] + 3.0 * q[1] - q[0]).abs());
    1.4826 * median(third.collect()) / 20.0_f64.sqrt()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
mod tests {
    use super::held;

    /// A position that swings for 2 s, rests for 1 s, and swings again, at 100 Hz.
    fn stopped(noise: f64) -> Vec<f64> {
        let swing = |t: f64| 0.3 * (3.0 * t).sin();
        let jitter = |k: usize| noise * (((k * 7919) % 101) as f64 / 50.0 - 1.0);
        let at = |t: f64| {
            if t < 2.0 {
                swing(t)
            } else if t < 3.0 {
                swing(2.0)
            } else {
                swing(t - 1.0)
            }
        };
        (0..500).map(|k| at(f64::from(k) * 0.01) + jitter(k as usize)).collect()
    }

    #[test]
    fn a_pause_is_found_through_noise_and_turning_points_are_none() {
        for noise in [0.0, 2e-5] {
            let found = held(&vec![stopped(noise)], 100.0, 8.0).remove(0);
            let (first, last) = (found.iter().position(|x| *x).unwrap(), found.iter().rposition(|x| *x).unwrap());
            assert!((195..=207).contains(&first) && (293..=306).contains(&last), "{noise}: {first} to {last}");
            assert!(found[first..=last].iter().all(|x| *x), "{noise}: one pause");
        }
    }

    #[test]
    fn a_log_of_rests_keeps_them() {
        let steps: Vec<f64> = (0..500).map(|k| f64::from(k / 100)).collect();
        assert!(!held(&vec![steps], 100.0, 8.0)[0].contains(&true));
    }
}
