//! Work of the actuators, compared with the energy that they put into the arm.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
#![allow(clippy::float_cmp, reason = "exactness is what is claimed")]

use crate::common::moving::{Moving, worst_over_arms};
use crate::common::{pinned, torque, turns};
use dynamics_core::chapter::work::WorkMeter;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, Inertia, JointKind, JointSpec, Limits, Live, Model, Rotor, Scene, Term, Tool, energy,
};
use nalgebra::Vector3;

#[test]
fn a_power_that_changes_its_sign_within_a_step_is_counted_on_both_sides() {
    // Power from 6 W to -2 W in 4 s: 3 s above zero, 1 s below.
    let mut meter = WorkMeter::<f64, 2>::new();
    meter.sample(f64::NAN, &[3.0, -1.0], &[2.0, 2.0]);
    meter.sample(4.0, &[3.0, 1.0], &[-2.0 / 3.0, 6.0]);
    assert!((meter.positive()[0] - 9.0).abs() < 1e-14 && (meter.negative()[0] + 1.0).abs() < 1e-15);
    // The same in reverse: from -2 W to 6 W.
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

/// Difference of the work from the gain in energy, relative to the work of either sign. The motion swings through the case's state at 0 and is
/// sampled in `steps` steps of a second.
fn imbalance<const N: usize>(case: &Moving<N>, steps: usize) -> f64 {
    let scene = Scene { tip_wrench: Term::Absent, ..*case.dynamics().scene() };
    let dynamics = Dynamics::new(case.model, scene);
    let at = |t: f64| {
        let each = |f: &dyn Fn(usize, f64) -> f64| core::array::from_fn(|i| f(i, 2.0 + i as f64));
        // Each joint has its own frequency.
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

/// Exercise 31: two massless links of 1 m carry 12 kg at 1 m/s along two half circles of 0.75 m, over the first centre and under
/// the second. Speed and height are the same at both ends, so the actuators together do no work.
#[test]
fn two_half_circles_at_constant_speed_take_back_all_that_they_gave() {
    let (mass, speed, radius, gravity) = (12.0, 1.0, 0.75, Vector3::new(0.0, -9.81, 0.0));
    let link = JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a: 1.0, ..Dh::default() }),
        body: Body::massless(),
        rotor: Rotor::default(),
        limits: Limits::none(),
    };
    let model = Model::new(&[link, link], &Tool::default()).unwrap();
    let point = Inertia { mass, ..Inertia::zero() };
    let scene = Scene { payload: Term::Constant(point), ..Scene::with_gravity(gravity, &model) };
    let dynamics = Dynamics::new(model, scene);
    // Torque and velocity of the joints `t` after the start of a half circle: from the right, turning left (+) or right (-).
    let at = |centre: f64, side: f64, t: f64| {
        let (s, c) = (speed * t / radius).sin_cos();
        let (x, y) = (centre + radius * c, 0.5 + side * radius * s);
        let (vx, vy) = (-speed * s, side * speed * c);
        let (ax, ay) = (-speed * speed / radius * c, -side * speed * speed / radius * s);
        let elbow = ((x * x + y * y - 2.0) / 2.0).acos();
        let shoulder = y.atan2(x) - elbow.sin().atan2(1.0 + elbow.cos());
        let (s1, c1) = shoulder.sin_cos();
        let (s12, c12) = (shoulder + elbow).sin_cos();
        // Absolute angles: the velocity is w1 across the first link and w12 across the second.
        let across = |vx: f64, vy: f64| {
            let sine = c1 * s12 - s1 * c12;
            [(c12 * vx + s12 * vy) / sine, -(c1 * vx + s1 * vy) / sine]
        };
        let [w1, w12] = across(vx, vy);
        let [a1, a12] = across(ax + w1 * w1 * c1 + w12 * w12 * c12, ay + w1 * w1 * s1 + w12 * w12 * s12);
        let qd = [w1, w12 - w1];
        (torque::<f64, 2>(&dynamics, &[shoulder, elbow], &qd, &[a1, a12 - a1]), qd)
    };
    let mut meter = WorkMeter::<f64, 2>::new();
    const STEPS: usize = 2000;
    let duration = core::f64::consts::PI * radius / speed;
    for (centre, side) in [(0.75, 1.0), (-0.75, -1.0)] {
        let sample = |k: usize| at(centre, side, duration * k as f64 / STEPS as f64);
        for k in 0..STEPS {
            // Where the circles meet, the acceleration and the torque jump: the end of one step need not equal the start of the next.
            let (from, to) = (sample(k), sample(k + 1));
            meter.step(duration / STEPS as f64, (&from.0, &from.1), (&to.0, &to.1));
        }
    }
    let (given, taken) = (meter.positive(), meter.negative());
    // At least the climb in both halves: 0.75 m up, and 0.75 m up again from below.
    assert!(given[0] + given[1] > 12.0 * 9.81 * 1.5);
    assert!((given[0] + given[1] + taken[0] + taken[1]).abs() < 1e-3, "{:?}", meter.total());
    pinned("shoulder gives, J", given[0], 125.4);
    pinned("elbow gives, J", given[1], 69.63);
    pinned("shoulder takes, J", -taken[0], 46.61);
    pinned("elbow takes, J", -taken[1], 148.5);
}

#[test]
fn work_is_the_gain_in_energy_and_misses_it_by_the_square_of_the_step() {
    let (coarse, fine) = (worst_over_arms!(coarse), worst_over_arms!(fine));
    pinned("steps of 4 ms", coarse, 4.02e-5);
    pinned("steps of 1 ms", fine, 2.51e-6);
    assert!((coarse / fine - 16.0).abs() < 0.2, "{}", coarse / fine);
}
