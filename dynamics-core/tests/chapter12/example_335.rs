//! Example 335: a point that slides along a massless turning arm. It contains no misprint.

use super::support_b::{
    DOWN_Y, Equations, G, State, arm, assert_equal, difference, mass_matrix_slope, placed, point, sizes, states,
};
use crate::common::torque;
use dynamics_core::{Body, Dynamics, JointKind};
use nalgebra::{Matrix2, Matrix3, Vector2};

/// The first joint turns, the second slides; the example counts the slide as `q1` and the turn as `q2`.
fn dynamics(m: f64) -> Dynamics<f64, 2> {
    let joint = |kind, axis, body| placed(kind, Matrix3::identity(), [0.0; 3], axis, body);
    let turn = joint(JointKind::Revolute, [0.0, 0.0, 1.0], Body::massless());
    let slide = joint(JointKind::Prismatic, [1.0, 0.0, 0.0], point(m, [0.0; 3]));
    arm(&[turn, slide], [0.0; 3], 0.0, DOWN_Y)
}

/// Eq. 12.257-12.258.
fn torques(m: f64, state: &State<2>) -> [f64; 2] {
    let State { q: [q2, q1], qd: [w2, v1], qdd: [e2, a1] } = *state;
    let (sin, cos) = q2.sin_cos();
    let force = m * a1 - m * q1 * w2 * w2 + m * G * sin;
    let moment = m * q1 * q1 * e2 + 2.0 * m * q1 * v1 * w2 + m * G * q1 * cos;
    [moment, force]
}

/// Eq. 12.260-12.262, rows and columns in the order of the joints.
fn equations(m: f64, state: &State<2>) -> Equations<2> {
    let State { q: [q2, q1], qd: [w2, v1], .. } = *state;
    let (sin, cos) = q2.sin_cos();
    Equations {
        d: Matrix2::new(m * q1 * q1, 0.0, 0.0, m),
        c: Matrix2::new(m * q1 * v1, m * q1 * w2, -m * q1 * w2, 0.0),
        g: Vector2::new(m * G * q1 * cos, m * G * sin),
    }
}

#[test]
fn equations_are_those_of_the_recursion() {
    assert_equal("12.257-12.258", (sizes::<1>(), states::<2>()), |([m], state)| {
        let wanted: [f64; 2] = torque(&dynamics(m), &state.q, &state.qd, &state.qdd);
        difference(&torques(m, &state), &wanted)
    });
    assert_equal("12.260-12.262", (sizes::<1>(), states::<2>()), |([m], state)| {
        equations(m, &state).error(&dynamics(m), &state)
    });
}

#[test]
fn the_rate_of_d_less_twice_c_is_skew() {
    assert_equal("D' - 2 C", (sizes::<1>(), states::<2>()), |([m], state)| {
        let dynamics = dynamics(m);
        let rate = mass_matrix_slope(&dynamics, &state.q, 0) * state.qd[0]
            + mass_matrix_slope(&dynamics, &state.q, 1) * state.qd[1];
        let odd = rate - equations(m, &state).c * 2.0;
        (odd + odd.transpose()).amax() / odd.amax()
    });
}
