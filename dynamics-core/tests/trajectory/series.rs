//! Finite Fourier series.

use dynamics_core::control::trajectory::{Bounds, FourierSpec, HARMONICS_MAX, Motion, MotionError};

fn spec() -> FourierSpec<f64, 2> {
    let mut sine = [[0.0; 2]; HARMONICS_MAX];
    let mut cosine = sine;
    (sine[0], sine[2], cosine[1]) = ([0.4, -0.1], [0.1, 0.2], [-0.2, 0.3]);
    FourierSpec { centre: [0.3, -0.2], sine, cosine, period: 4.0, duration: 11.0, ramp: 1.5 }
}

#[test]
fn a_series_starts_and_ends_at_rest_in_its_centre() {
    let motion = Motion::fourier(&spec(), &Bounds::none()).unwrap();
    for t in [0.0, 1e-9, 11.0 - 1e-9, 11.0] {
        let there = motion.sample(t);
        for joint in 0..2 {
            assert!((there.q[joint] - spec().centre[joint]).abs() < 1e-12, "{t}: {there:?}");
            assert!(there.qd[joint].abs() + there.qdd[joint].abs() < 1e-6, "{t}: {there:?}");
        }
    }
}

#[test]
fn velocity_and_acceleration_of_a_series_are_its_derivatives() {
    let motion = Motion::fourier(&spec(), &Bounds::none()).unwrap();
    let h = 1e-4;
    for step in 1..110 {
        // Away from the ends of the ramps, where the third derivative jumps.
        let t = 0.1 * f64::from(step) + 0.03;
        let [before, here, after] = [t - h, t, t + h].map(|t| motion.sample(t));
        for joint in 0..2 {
            assert!(((after.q[joint] - before.q[joint]) / (2.0 * h) - here.qd[joint]).abs() < 1e-6);
            assert!(((after.qd[joint] - before.qd[joint]) / (2.0 * h) - here.qdd[joint]).abs() < 1e-5);
        }
    }
}

#[test]
fn peaks_of_a_series_are_never_too_low_and_half_a_per_cent_too_high_at_most() {
    let motion = Motion::fourier(&spec(), &Bounds::none()).unwrap();
    let peaks = motion.peaks();
    let (mut qd, mut qdd) = ([0.0_f64; 2], [0.0_f64; 2]);
    for step in 0..200_000 {
        let there = motion.sample(11.0 * f64::from(step) / 200_000.0);
        for joint in 0..2 {
            qd[joint] = qd[joint].max(there.qd[joint].abs());
            qdd[joint] = qdd[joint].max(there.qdd[joint].abs());
        }
    }
    for joint in 0..2 {
        for (found, seen) in [(peaks.velocity[joint], qd[joint]), (peaks.acceleration[joint], qdd[joint])] {
            assert!(found >= seen && found < 1.005 * seen, "{found}, {seen}");
        }
    }
}

#[test]
fn a_series_that_leaves_its_limits_is_refused() {
    let narrow = Bounds { position: [(-2.0, 2.0), (-0.3, 0.3)], ..Bounds::none() };
    let refused = Motion::fourier(&spec(), &narrow);
    assert!(matches!(refused, Err(MotionError::AmplitudeBeyondLimits { joint: 1, .. })), "{refused:?}");
    let slow = Bounds { velocity: [0.5, 0.5], ..Bounds::none() };
    assert!(matches!(Motion::fourier(&spec(), &slow), Err(MotionError::TooFast { .. })));
    let long = FourierSpec { ramp: 6.0, ..spec() };
    assert!(matches!(Motion::fourier(&long, &Bounds::none()), Err(MotionError::OutOfRange { .. })));
}
