//! Exercises 8, 14, 22 and 27: the planar polar arm, a revolute joint and a slider along its link.
//!
//! The figure is in another chapter. Assumed: a vertical plane, link 1 with its mass centre at `c1` from the joint,
//! and the slider's distance `d` measured to its mass centre.

use super::support_b::{
    DOWN_Y, Equations, G, State, arm, assert_equal, body, felt, larger, largest, placed, sizes, states,
    wrenches_in_base,
};
use dynamics_core::{Dynamics, JointKind, Wrench};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// `m1, c1, I1, m2, I2`
struct Polar([f64; 5]);

impl Polar {
    fn dynamics(&self) -> Dynamics<f64, 2> {
        let Self([m1, c1, i1, m2, i2]) = *self;
        let turn = placed(
            JointKind::Revolute,
            Matrix3::identity(),
            [0.0; 3],
            [0.0, 0.0, 1.0],
            body(m1, [c1, 0.0, 0.0], [0.0, 0.0, i1]),
        );
        let slide = placed(
            JointKind::Prismatic,
            Matrix3::identity(),
            [0.0; 3],
            [1.0, 0.0, 0.0],
            body(m2, [0.0; 3], [0.0, 0.0, i2]),
        );
        arm(&[turn, slide], [0.0; 3], 0.0, DOWN_Y)
    }

    /// `Q_0 = (I1 + m1 c1^2 + I2 + m2 d^2) thdd + 2 m2 d dd thd + (m1 c1 + m2 d) g cos th` and
    /// `Q_1 = m2 (ddd - d thd^2 + g sin th)`.
    fn equations(&self, State { q: [theta, d], qd: [turn, slide], .. }: &State<2>) -> Equations<2> {
        let Self([m1, c1, i1, m2, i2]) = *self;
        let (s, c) = theta.sin_cos();
        let h = m2 * d;
        Equations {
            d: Matrix2::new(i1 + m1 * c1 * c1 + i2 + m2 * d * d, 0.0, 0.0, m2),
            c: Matrix2::new(h * slide, h * turn, -h * turn, 0.0),
            g: Vector2::new((m1 * c1 + m2 * d) * G * c, m2 * G * s),
        }
    }
}

#[test]
fn equations_of_motion_of_the_polar_arm() {
    assert_equal("exercises 8, 14, 22, 27", (sizes(), states()), |(sizes, state)| {
        let arm = Polar(sizes);
        arm.equations(&state).error(&arm.dynamics(), &state)
    });
}

/// Exercise 22 b: the forward recursion, started with the base's force and moment of exercise 14, gives zero at the tip.
#[test]
fn forward_recursion_of_the_polar_arm() {
    assert_equal("exercise 22", (sizes(), states()), |(sizes, state)| {
        let (polar, [(force, moment), _]) = (Polar(sizes), wrenches(sizes, &state));
        let base = Wrench { force, moment };
        largest(&[felt(&polar.dynamics(), &state, &base)]) / largest(&[base])
    });
}

/// Both joints' forces and moments, in base axes.
fn wrenches(sizes: [f64; 5], state: &State<2>) -> [(Vector3<f64>, Vector3<f64>); 2] {
    let State { q: [theta, d], qd: [turn, slide], qdd: [spin, start] } = *state;
    let [m1, c1, i1, m2, i2] = sizes;
    let (s, c) = theta.sin_cos();
    let (along, across) = (Vector3::new(c, s, 0.0), Vector3::new(-s, c, 0.0));
    let a1 = across * (c1 * spin) - along * (c1 * turn * turn);
    let a2 = along * (start - d * turn * turn) + across * (d * spin + 2.0 * slide * turn);
    let force1 = (a2 - DOWN_Y) * m2;
    let force0 = force1 + (a1 - DOWN_Y) * m1;
    let moment1 = Vector3::z() * (i2 * spin);
    let lever = (along * c1).cross(&((a1 - DOWN_Y) * m1)) + (along * d).cross(&force1);
    [(force0, moment1 + Vector3::z() * (i1 * spin) + lever), (force1, moment1)]
}

/// Exercise 14 a: both joints' forces and moments by Newton's and Euler's laws.
#[test]
fn joint_forces_of_the_polar_arm() {
    assert_equal("exercise 14", (sizes(), states()), |(sizes, state)| {
        let found = wrenches_in_base(&Polar(sizes).dynamics(), &state);
        let pairs = wrenches(sizes, &state).into_iter().zip(found);
        let off =
            pairs.map(|((force, moment), found)| larger((found.force - force).amax(), (found.moment - moment).amax()));
        off.fold(0.0, larger) / largest(&found)
    });
}
