//! Exercise 21: a redundant planar arm, revolute, prismatic, revolute, with a point mass at the second revolute joint and one at
//! the tip.

use super::support_b::{DOWN_Y, Equations, G, State, arm, assert_equal, placed, point, sizes, states};
use dynamics_core::{Body, Dynamics, JointKind};
use nalgebra::{Matrix3, Vector3};

fn dynamics(m1: f64, m2: f64, l: f64) -> Dynamics<f64, 3> {
    let plain = Matrix3::identity();
    let joints = [
        placed(JointKind::Revolute, plain, [0.0; 3], [0.0, 0.0, 1.0], Body::massless()),
        placed(JointKind::Prismatic, plain, [0.0; 3], [1.0, 0.0, 0.0], point(m1, [0.0; 3])),
        placed(JointKind::Revolute, plain, [0.0; 3], [0.0, 0.0, 1.0], Body::massless()),
    ];
    arm(&joints, [l, 0.0, 0.0], m2, DOWN_Y)
}

/// By Lagrange's method, in the joint variables `theta_1, d_2, theta_2`.
fn equations(m1: f64, m2: f64, l: f64, State { q: [q1, d, q3], qd: [v1, v2, v3], .. }: &State<3>) -> Equations<3> {
    let (mass, (s3, cos3)) = (m1 + m2, q3.sin_cos());
    let (d11, d12) = (mass * d * d + m2 * (l * l + 2.0 * l * d * cos3), -m2 * l * s3);
    let d13 = m2 * (l * l + l * d * cos3);
    // Halves of dD11/dd and dD11/dq3, and dD12/dq3.
    let (a, b, e) = (mass * d + m2 * l * cos3, -m2 * l * d * s3, -m2 * l * cos3);
    let c = Matrix3::new(
        a * v2 + b * v3,
        a * v1,
        b * (v1 + v3),
        -a * v1 + e * v3,
        0.0,
        e * (v1 + v3),
        -b * v1 - e * v2,
        -e * v1,
        0.0,
    );
    let last = m2 * l * (q1 + q3).cos();
    Equations {
        d: Matrix3::new(d11, d12, d13, d12, mass, d12, d13, d12, m2 * l * l),
        c,
        g: Vector3::new(mass * d * q1.cos() + last, mass * q1.sin(), last) * G,
    }
}

#[test]
fn equations_of_motion_of_the_redundant_arm() {
    assert_equal("exercise 21", (sizes(), states()), |([m1, m2, l], state)| {
        equations(m1, m2, l, &state).error(&dynamics(m1, m2, l), &state)
    });
}
