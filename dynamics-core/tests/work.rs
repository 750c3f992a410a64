//! Work of the actuators, against the energy that they put into the arm.

mod common;

use common::moving::{Moving, worst_over_arms};
use common::{pinned, torque, turns};
use dynamics_core::work::WorkMeter;
use dynamics_core::{Dynamics, Live, Scene, Term, energy};

#[test]
fn a_power_that_changes_its_sign_within_a_step_is_counted_on_both_sides() {
    // Power from 6 W to -2 W in 4 s: 3 s above zero, 1 s below.
    let mut meter = WorkMeter::<f64, 2>::new();
    meter.sample(f64::NAN, &[3.0, -1.0], &[2.0, 2.0]);
    meter.sample(4.0, &[3.0, 1.0], &[-2.0 / 3.0, 6.0]);
    assert!((meter.positive()[0] - 9.0).abs() < 1e-14 && (meter.negative()[0] + 1.0).abs() < 1e-15);
    // The same turned round: from -2 W to 6 W.
    assert!((meter.positive()[1] - 9.0).abs() < 1e-14 && (meter.negative()[1] + 1.0).abs() < 1e-15);
    assert!((meter.total()[0] - 8.0).abs() < 1e-14);
}

#[test]
fn held_torques_that_jump_are_counted_exactly() {
    let mut meter = WorkMeter::<f64, 1>::new();
    meter.step(0.5, (&[4.0], &[1.0]), (&[4.0], &[2.0]));
    meter.step(0.5, (&[-4.0], &[2.0]), (&[-4.0], &[1.0]));
    assert_eq!((meter.positive(), meter.negative(), meter.total()), (&[3.0], &[-3.0], [0.0]));
    assert_eq!(WorkMeter::<f64, 1>::default().total(), [0.0]);
}

#[test]
fn a_number_that_is_none_is_not_lost() {
    for samples in [[f64::NAN, 1.0], [1.0, f64::NAN], [f64::NAN, -1.0], [-1.0, f64::NAN]] {
        let mut meter = WorkMeter::<f64, 1>::new();
        for tau in samples {
            meter.sample(0.1, &[tau], &[1.0]);
        }
        assert!(meter.total()[0].is_nan(), "{samples:?}");
    }
}

/// A swinging motion through the case's state at 0, sampled in `steps` steps of a second: what the work misses of the gain in energy,
/// relative to the work of either sign.
fn imbalance<const N: usize>(case: &Moving<N>, steps: usize) -> f64 {
    let scene = Scene { tip_wrench: Term::Absent, ..*case.dynamics().scene() };
    let dynamics = Dynamics::new(case.model, scene);
    let at = |t: f64| {
        let each = |f: &dyn Fn(usize, f64) -> f64| core::array::from_fn(|i| f(i, 2.0 + i as f64));
        // Each joint its own frequency.
        let q: [f64; N] = each(&|i, w| case.q[i] + case.qd[i] / w * (w * t).sin());
        let qd: [f64; N] = each(&|i, w| case.qd[i] * (w * t).cos());
        let qdd: [f64; N] = each(&|i, w| -case.qd[i] * w * (w * t).sin());
        (q, qd, qdd)
    };
    let energy = |t: f64| {
        let (q, qd, _) = at(t);
        let (turn, live) = (turns(&q), Live::zero());
        energy::kinetic(&dynamics, &turn, &q, &qd, &live) + energy::potential(&dynamics, &turn, &q, &live)
    };
    let dt = 1.0 / steps as f64;
    let mut meter = WorkMeter::<f64, N>::new();
    for k in 0..=steps {
        let (q, qd, qdd) = at(k as f64 * dt);
        meter.sample(dt, &torque::<f64, N>(&dynamics, &q, &qd, &qdd), &qd);
    }
    let work: f64 = meter.total().iter().sum();
    let turnover: f64 = meter.positive().iter().chain(meter.negative()).map(|x| x.abs()).sum();
    (work - (energy(1.0) - energy(0.0))).abs() / turnover
}

fn coarse<const N: usize>(case: &Moving<N>) -> f64 {
    imbalance(case, 250)
}

fn fine<const N: usize>(case: &Moving<N>) -> f64 {
    imbalance(case, 1000)
}

#[test]
fn work_is_the_gain_in_energy_and_misses_it_by_the_square_of_the_step() {
    let (coarse, fine) = (worst_over_arms!(coarse), worst_over_arms!(fine));
    pinned("steps of 4 ms", coarse, 4.02e-5);
    pinned("steps of 1 ms", fine, 2.51e-6);
    assert!((coarse / fine - 16.0).abs() < 0.2, "{}", coarse / fine);
}
