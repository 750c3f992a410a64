//! Properties of every motion.

use dynamics_core::Reference;
use dynamics_core::control::trajectory::Motion;

/// `count + 1` moments from start to end.
pub(crate) fn moments(duration: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..=count).map(move |i| duration * f64::from(i) / f64::from(count))
}

/// Largest differences between `qd` and the slope of `q`, and between `qdd` and the slope of `qd`, relative to the
/// peaks. Moments within `1e-5` of the duration from one in `apart` are skipped.
pub(crate) fn slope_errors<const N: usize>(motion: &Motion<f64, N>, apart: &[f64]) -> (f64, f64) {
    let h = 1e-5 * motion.duration();
    let peaks = motion.peaks();
    let fastest = peaks.velocity.into_iter().fold(0.0, f64::max);
    let steepest = peaks.acceleration.into_iter().fold(0.0, f64::max);
    let mut errors = (0.0_f64, 0.0_f64);
    for t in moments(motion.duration() - 2.0 * h, 997).map(|t| t + h) {
        if apart.iter().any(|jump| (t - jump).abs() <= h) {
            continue;
        }
        let (before, here, after) = (motion.sample(t - h), motion.sample(t), motion.sample(t + h));
        for i in 0..N {
            let qd = (after.q[i] - before.q[i]) / (2.0 * h);
            let qdd = (after.qd[i] - before.qd[i]) / (2.0 * h);
            errors.0 = errors.0.max((here.qd[i] - qd).abs() / fastest);
            errors.1 = errors.1.max((here.qdd[i] - qdd).abs() / steepest);
        }
    }
    errors
}

/// Asserts that the motion starts and ends at rest at the given positions, stays there, and that a NaN time counts as before the start.
pub(crate) fn check_ends<const N: usize>(motion: &Motion<f64, N>, from: [f64; N], to: [f64; N]) {
    assert_eq!(motion.start(), Reference::at_rest(from));
    assert_eq!(motion.end(), Reference::at_rest(to));
    for t in [0.0, -0.0, -1e-9, -1e9, f64::NEG_INFINITY, f64::NAN] {
        assert_eq!(motion.sample(t), motion.start(), "at {t}");
    }
    for t in [motion.duration(), motion.duration().next_up(), 1e9, f64::INFINITY] {
        assert_eq!(motion.sample(t), motion.end(), "at {t}");
    }
    // Approaching the ends from inside: no step in position at either end.
    let near = 1e-9 * motion.duration();
    for i in 0..N {
        let fastest = motion.peaks().velocity[i];
        let (early, late) = (motion.sample(near), motion.sample(motion.duration() - near));
        assert!((early.q[i] - from[i]).abs() <= fastest * near && (late.q[i] - to[i]).abs() <= fastest * near);
    }
}

/// Greatest speed and acceleration per joint at `count + 1` moments.
pub(crate) fn sampled_peaks<const N: usize>(motion: &Motion<f64, N>, count: u32) -> ([f64; N], [f64; N]) {
    let mut peaks = ([0.0_f64; N], [0.0_f64; N]);
    for t in moments(motion.duration(), count) {
        let r = motion.sample(t);
        for i in 0..N {
            peaks.0[i] = peaks.0[i].max(r.qd[i].abs());
            peaks.1[i] = peaks.1[i].max(r.qdd[i].abs());
        }
    }
    peaks
}
