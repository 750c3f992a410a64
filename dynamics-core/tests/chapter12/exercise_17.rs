//! Exercise 17: a planar arm of three joints, massless links, two point masses.
//!
//! The figure is not available here. Assumed: a slider along x with two revolute joints on it, one
//! mass at the elbow and one at the tip, gravity along -y.

use super::support_b::{DOWN_Y, Equations, G, State, arm, assert_equal, placed, point, sizes, states};
use dynamics_core::{Body, Dynamics, JointKind};
use nalgebra::{Matrix3, Vector3};

fn dynamics(m1: f64, m2: f64, [l1, l2]: [f64; 2]) -> Dynamics<f64, 3> {
    let plain = Matrix3::identity();
    let joints = [
        placed(JointKind::Prismatic, plain, [0.0; 3], [1.0, 0.0, 0.0], Body::massless()),
        placed(JointKind::Revolute, plain, [0.0; 3], [0.0, 0.0, 1.0], point(m1, [l1, 0.0, 0.0])),
        placed(JointKind::Revolute, plain, [l1, 0.0, 0.0], [0.0, 0.0, 1.0], Body::massless()),
    ];
    arm(&joints, [l2, 0.0, 0.0], m2, DOWN_Y)
}

/// By Lagrange's method.
fn equations(m1: f64, m2: f64, [l1, l2]: [f64; 2], state: &State<3>) -> Equations<3> {
    let State { q: [_, q1, q2], qd: [_, v1, v2], .. } = *state;
    let ((s1, c1), (s2, c2), (s12, c12)) = (q1.sin_cos(), q2.sin_cos(), (q1 + q2).sin_cos());
    let (mass, h) = (m1 + m2, m2 * l1 * l2 * s2);
    let (d12, d13) = (-mass * l1 * s1 - m2 * l2 * s12, -m2 * l2 * s12);
    let d23 = m2 * (l2 * l2 + l1 * l2 * c2);
    let d22 = mass * l1 * l1 + m2 * (l2 * l2 + 2.0 * l1 * l2 * c2);
    let outer = -m2 * l2 * c12 * (v1 + v2);
    Equations {
        d: Matrix3::new(mass, d12, d13, d12, d22, d23, d13, d23, m2 * l2 * l2),
        c: Matrix3::new(0.0, outer - mass * l1 * c1 * v1, outer, 0.0, -h * v2, -h * (v1 + v2), 0.0, h * v1, 0.0),
        g: Vector3::new(0.0, mass * l1 * c1 + m2 * l2 * c12, m2 * l2 * c12) * G,
    }
}

#[test]
fn equations_of_motion_of_a_slider_with_two_links() {
    assert_equal("exercise 17", (sizes(), states()), |([m1, m2, l1, l2], state)| {
        equations(m1, m2, [l1, l2], &state).error(&dynamics(m1, m2, [l1, l2]), &state)
    });
}
