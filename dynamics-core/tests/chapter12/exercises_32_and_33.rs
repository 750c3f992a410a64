//! Exercises 32 and 33: statics of two uniform bars that hang from a ceiling, with 14 kg at the tip.
//!
//! Angles are measured from the vertical, as in example 343, which also hangs from a ceiling; gravity is along -y of the base.

use super::support_b::{DOWN_Y, G, State, arm, body, planar_link, pushed};
use crate::common::{torque, turns};
use dynamics_core::{Dynamics, Live, energy};
use nalgebra::Vector3;

const BEND: f64 = core::f64::consts::FRAC_PI_4;

/// Weights beyond the joints times their lever arms: `Q_1 = g (44 sin(theta_1) + 23 sin(theta_1 + theta_2))`; `Q_2` is its
/// second term.
const FIRST: f64 = 24.0 / 2.0 + 18.0 + 14.0;
const SECOND: f64 = 18.0 / 2.0 + 14.0;

fn bars() -> Dynamics<f64, 2> {
    let bar = |m: f64| planar_link(1.0, body(m, [-0.5, 0.0, 0.0], [0.0, m / 12.0, m / 12.0]));
    arm(&[bar(24.0), bar(18.0)], [0.0; 3], 0.0, DOWN_Y)
}

/// The core's angles are measured from the x axis.
fn posture(theta: f64) -> [f64; 2] {
    [theta - core::f64::consts::FRAC_PI_2, BEND]
}

fn moments(theta: f64) -> [f64; 2] {
    let q = posture(theta);
    let State { qd, qdd, .. } = State::still(q);
    torque(&pushed(&bars(), &q, DOWN_Y * 14.0, Vector3::zeros()), &q, &qd, &qdd)
}

/// Potential energy of the bars, and of the load as a mass.
fn potential(theta: f64) -> f64 {
    let q = posture(theta);
    energy::potential(&bars(), &turns(&q), &q, &Live::zero()) - 14.0 * G * (theta.cos() + (theta + BEND).cos())
}

/// Exercise 32: 433.8 N m and 217.9 N m at 30 and 45 degrees.
#[test]
fn static_moments_of_exercise_32() {
    let theta = core::f64::consts::FRAC_PI_6;
    let [q1, q2] = moments(theta);
    let second = SECOND * G * (theta + BEND).sin();
    let first = FIRST * G * theta.sin() + second;
    assert!((q1 - first).abs() < 1e-12 * first && (q2 - second).abs() < 1e-12 * first);
    assert!((q1 - 433.76).abs() < 0.005 && (q2 - 217.94).abs() < 0.005, "{q1} {q2}");
}

/// A value of the arm as a function of its first angle.
type Value = fn(f64) -> f64;

/// `a sin(theta) + b sin(theta + 45 degrees) = r sin(theta + lead)`, as `(r, lead)`.
fn wave(a: f64, b: f64) -> (f64, f64) {
    let (sine, cosine) = (b * BEND.sin(), a + b * BEND.cos());
    ((sine * sine + cosine * cosine).sqrt(), sine.atan2(cosine))
}

/// Exercise 33: all four are sinusoids in the first angle, with the minimum half a turn from the maximum. The energy, whose
/// derivative is `Q_1`, lags by a quarter turn.
#[test]
fn least_moments_and_energy_of_exercise_33() {
    let pi = core::f64::consts::PI;
    let (size1, lead1) = wave(FIRST, SECOND);
    let (size2, lead2) = (SECOND, BEND);
    let (size_sum, lead_sum) = wave(FIRST, 2.0 * SECOND);
    let cases: [(&str, f64, f64, Value, f64); 4] = [
        ("Q1", -pi / 2.0 - lead1, -size1 * G, |theta| moments(theta)[0], -105.0),
        ("Q2", -pi / 2.0 - lead2, -size2 * G, |theta| moments(theta)[1], -135.0),
        ("Q1 + Q2", -pi / 2.0 - lead_sum, -size_sum * G, |theta| moments(theta).iter().sum(), -113.0),
        ("V", -lead1, -size1 * G, potential, -15.0),
    ];
    for (name, at, least, value, degrees) in cases {
        let size = least.abs();
        assert!((value(at) - least).abs() < 1e-12 * size, "{name}: {} {least}", value(at));
        assert!((at.to_degrees() - degrees).abs() < 1.0, "{name}: {}", at.to_degrees());
        for k in 1..360 {
            assert!(value(at + f64::from(k).to_radians()) > least + 1e-4 * size, "{name} {k}");
        }
    }
    // The energy is least where the first joint needs no moment.
    assert!(moments(-lead1)[0].abs() < 1e-11);
}
