//! Exercises 9 and 12: the planar Cartesian arm, two sliders at right angles.
//!
//! Assumed: x horizontal, y vertical, mass centres offset from the sliders' axes by `c1` and `c2` along x, so that the bearings carry moments.

use super::support_b::{
    DOWN_Y, Equations, G, State, arm, assert_equal, body, larger, largest, placed, sizes, states, wrenches_in_base,
};
use dynamics_core::{Dynamics, JointKind};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

fn dynamics([m1, c1, m2, c2]: [f64; 4]) -> Dynamics<f64, 2> {
    let slider = |axis, body| placed(JointKind::Prismatic, Matrix3::identity(), [0.0; 3], axis, body);
    let first = slider([1.0, 0.0, 0.0], body(m1, [c1, 0.0, 0.0], [0.0; 3]));
    let second = slider([0.0, 1.0, 0.0], body(m2, [c2, 0.0, 0.0], [0.0; 3]));
    arm(&[first, second], [0.0; 3], 0.0, DOWN_Y)
}

/// `Q_1 = (m1 + m2) xdd`, `Q_2 = m2 (ydd + g)`: the coordinates are not coupled.
#[test]
fn equations_of_motion_of_the_cartesian_arm() {
    assert_equal("exercises 9, 12", (sizes(), states()), |(sizes, state)| {
        let [m1, _, m2, _] = sizes;
        let closed =
            Equations { d: Matrix2::new(m1 + m2, 0.0, 0.0, m2), c: Matrix2::zeros(), g: Vector2::new(0.0, m2 * G) };
        closed.error(&dynamics(sizes), &state)
    });
}

/// Wrenches of the sliders' bearings, each about its slider's own origin.
#[test]
fn joint_forces_of_the_cartesian_arm() {
    assert_equal("exercise 12", (sizes(), states()), |(sizes, state)| {
        let ([m1, c1, m2, c2], State { q: [_, y], qdd: [xdd, ydd], .. }) = (sizes, state);
        let force1 = Vector3::new(m2 * xdd, m2 * (ydd + G), 0.0);
        let force0 = Vector3::new((m1 + m2) * xdd, m1 * G + m2 * (ydd + G), 0.0);
        let moment1 = Vector3::z() * (c2 * force1.y);
        let moment0 = moment1 + Vector3::z() * (c1 * m1 * G - y * force1.x);
        let found = wrenches_in_base(&dynamics(sizes), &state);
        let pairs = [
            (found[0].force, force0),
            (found[0].moment, moment0),
            (found[1].force, force1),
            (found[1].moment, moment1),
        ];
        pairs.map(|(found, wanted)| (found - wanted).amax()).into_iter().fold(0.0, larger) / largest(&found)
    });
}
