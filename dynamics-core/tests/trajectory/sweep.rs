//! Sine sweeps.

use crate::trajectory::support::{check_ends, moments, sampled_peaks, slope_errors};
use dynamics_core::control::trajectory::{Bounds, Motion, SweepSpec};
use std::f64::consts::TAU;

const SPEC: SweepSpec<f64, 2> =
    SweepSpec { centre: [0.5, -1.0], amplitude: [0.2, -0.7], from: 0.5, to: 3.0, duration: 12.0, ramp: 2.0 };

fn sweep(spec: &SweepSpec<f64, 2>) -> Motion<f64, 2> {
    Motion::sweep(spec, &Bounds::none()).unwrap()
}

#[test]
fn it_starts_and_ends_at_rest_without_a_step_in_acceleration() {
    let motion = sweep(&SPEC);
    check_ends(&motion, SPEC.centre, SPEC.centre);
    for t in [1e-4, SPEC.duration - 1e-4] {
        let r = motion.sample(t);
        for i in 0..2 {
            assert!((r.q[i] - SPEC.centre[i]).abs() < 1e-12 && r.qd[i].abs() < 1e-6 && r.qdd[i].abs() < 1e-2);
        }
    }
}

#[test]
fn between_the_ramps_it_is_the_chirp_of_the_formula() {
    let motion = sweep(&SPEC);
    for t in moments(8.0, 500).map(|t| t + 2.0) {
        let phase = TAU * (0.5 * t + 2.5 * t * t / 24.0);
        let frequency = TAU * (0.5 + 2.5 * t / 12.0);
        let r = motion.sample(t);
        for i in 0..2 {
            assert!((r.q[i] - SPEC.centre[i] - SPEC.amplitude[i] * phase.sin()).abs() < 1e-12);
            assert!((r.qd[i] - SPEC.amplitude[i] * frequency * phase.cos()).abs() < 1e-11);
        }
    }
}

#[test]
fn velocity_and_acceleration_are_slopes() {
    for (from, to) in [(0.5, 3.0), (3.0, 0.5), (0.0, 2.0), (1.0, 1.0)] {
        let (qd, qdd) = slope_errors(&sweep(&SweepSpec { from, to, ..SPEC }), &[]);
        assert!(qd < 1e-6 && qdd < 1e-6, "{from} to {to}: {qd} {qdd}");
    }
}

#[test]
fn peaks_are_never_understated_and_hardly_overstated() {
    let mut worst = 0.0_f64;
    // The last one has phase 0 at both ends, and its shortest ramp is a fiftieth of its period.
    for (from, to) in [(0.1, 5.0), (5.0, 0.0), (2.0, 2.0), (0.0, 0.4), (0.25, 0.25)] {
        for ramp in [0.08, 0.2, 0.5, 1.0, 2.0, 6.0] {
            let motion = sweep(&SweepSpec { from, to, ramp, ..SPEC });
            let peaks = motion.peaks();
            let (velocity, acceleration) = sampled_peaks(&motion, 60_000);
            for (peak, sampled) in [(peaks.velocity[1], velocity[1]), (peaks.acceleration[1], acceleration[1])] {
                assert!(sampled <= peak, "{from} to {to}, ramp {ramp}: {peak} but sampled {sampled}");
                worst = worst.max(peak / sampled - 1.0);
            }
        }
    }
    assert!((0.005..0.01).contains(&worst), "the bound is {worst} too wide at worst");
}

#[test]
fn it_never_swings_beyond_its_amplitude() {
    let motion = sweep(&SPEC);
    let mut reach = 0.0_f64;
    for t in moments(SPEC.duration, 20_000) {
        reach = reach.max((motion.sample(t).q[1] - SPEC.centre[1]).abs());
    }
    assert!(reach <= 0.7 + 1e-15 && reach > 0.6999, "{reach}");
}
