//! Example 334: a carriage that slides along X and a point on a massless arm that turns on it.

use super::support::shares;
use super::support_b::{
    DOWN_Y, Equations, G, STATED_2, State, arm, assert_equal, assert_stated, difference, placed, point, sizes, states,
};
use crate::common::torque;
use dynamics_core::{Dynamics, JointKind};
use nalgebra::{Matrix2, Matrix3, Vector2};

/// `m1`, `m2`, `l`.
type Sizes = [f64; 3];

const STATED: Sizes = [5.0, 2.0, 0.6];

fn dynamics([m1, m2, l]: Sizes) -> Dynamics<f64, 2> {
    let joint = |kind, axis, body| placed(kind, Matrix3::identity(), [0.0; 3], axis, body);
    let carriage = joint(JointKind::Prismatic, [1.0, 0.0, 0.0], point(m1, [0.0; 3]));
    let turning = joint(JointKind::Revolute, [0.0, 0.0, 1.0], point(m2, [l, 0.0, 0.0]));
    arm(&[carriage, turning], [l, 0.0, 0.0], 0.0, DOWN_Y)
}

/// Eq. 12.250 (corrected), 12.251 and 12.252.
fn equations([m1, m2, l]: Sizes, state: &State<2>) -> Equations<2> {
    let (sin, cos) = state.q[1].sin_cos();
    Equations {
        d: Matrix2::new(m1 + m2, -m2 * l * sin, -m2 * l * sin, m2 * l * l),
        c: Matrix2::new(0.0, -m2 * l * state.qd[1] * cos, 0.0, 0.0),
        g: Vector2::new(0.0, m2 * G * l * cos),
    }
}

/// Eq. 12.247 and 12.248 (corrected).
fn torques([m1, m2, l]: Sizes, state: &State<2>) -> [f64; 2] {
    let State { q: [_, q2], qd: [_, w2], qdd: [e1, e2] } = *state;
    let (sin, cos) = q2.sin_cos();
    [
        (m1 + m2) * e1 - m2 * l * e2 * sin - m2 * l * w2 * w2 * cos,
        m2 * l * l * e2 - m2 * l * e1 * sin + m2 * G * l * cos,
    ]
}

#[test]
fn corrected_equations_are_those_of_the_recursion() {
    assert_equal("12.250-12.252", (sizes::<3>(), states::<2>()), |(sizes, state)| {
        equations(sizes, &state).error(&dynamics(sizes), &state)
    });
    assert_equal("12.247-12.248", (sizes::<3>(), states::<2>()), |(sizes, state)| {
        let wanted: [f64; 2] = torque(&dynamics(sizes), &state.q, &state.qd, &state.qdd);
        difference(&torques(sizes, &state), &wanted)
    });
}

#[test]
fn the_printed_second_row_is_wrong() {
    let State { q, qd, qdd } = STATED_2;
    let [_, m2, l] = STATED;
    let (sin, cos) = q[1].sin_cos();
    let wanted: [f64; 2] = torque(&dynamics(STATED), &q, &qd, &qdd);
    // 12.248: the carriage's acceleration instead of the arm's.
    let second = m2 * l * l * qdd[0] - m2 * l * qdd[0] * sin + m2 * G * l * cos;
    // 12.250, second row.
    let right = Equations::of(&dynamics(STATED), &q, &qd).d;
    let [off] = shares([second], [wanted[1]]);
    let row = [m2 * l * l - right[(1, 0)], -m2 * l * sin - right[(1, 1)]].map(|x| x.abs() / right[(1, 1)]);
    assert_stated(&[off, row[0], row[1]], &[0.63556, 2.3055, 2.3055]);
}
