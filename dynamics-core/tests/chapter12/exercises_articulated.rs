//! Exercises 13, 16, 23, 28 and 35: the articulated arm, with a vertical revolute joint and two parallel horizontal ones.
//!
//! The figures are in another chapter or show no lengths. Assumed: shoulder at height `l1` above the base without
//! offset; angles are zero with the arm stretched out horizontally. In exercise 13 the two masses are at elbow and tip.

use super::support_b::{
    Equations, G, State, arm, assert_equal, body, larger, placed, sizes, states, there_and_back, wrenches_in_base,
};
use dynamics_core::geometry::about_x;
use dynamics_core::{Dynamics, JointKind};
use nalgebra::{Matrix3, Vector3};

/// Links 2 and 3 with principal moments of inertia, the first link with that about the vertical axis, and a load at the tip.
#[derive(Clone, Copy)]
struct Articulated {
    i1: f64,
    m: [f64; 2],
    l: [f64; 2],
    c: [f64; 2],
    i: [[f64; 3]; 2],
    held: f64,
}

impl Articulated {
    fn of(x: [f64; 14]) -> Self {
        let [i1, m2, m3, l2, l3, c2, c3, held, xx2, yy2, zz2, xx3, yy3, zz3] = x;
        Self { i1, m: [m2, m3], l: [l2, l3], c: [c2, c3], i: [[xx2, yy2, zz2], [xx3, yy3, zz3]], held }
    }

    fn dynamics(&self, height: f64, gravity: f64) -> Dynamics<f64, 3> {
        let turn = |rotation, at, body| placed(JointKind::Revolute, rotation, at, [0.0, 0.0, 1.0], body);
        let level = about_x(core::f64::consts::FRAC_PI_2);
        let link = |k: usize| body(self.m[k], [self.c[k], 0.0, 0.0], self.i[k]);
        let joints = [
            turn(Matrix3::identity(), [0.0; 3], body(0.0, [0.0; 3], [0.0, 0.0, self.i1])),
            turn(level, [0.0, 0.0, height], link(0)),
            turn(Matrix3::identity(), [self.l[0], 0.0, 0.0], link(1)),
        ];
        arm(&joints, [self.l[1], 0.0, 0.0], self.held, Vector3::new(0.0, 0.0, gravity))
    }

    /// By Lagrange's method.
    fn equations(&self, State { q: [_, q2, q3], qd: [v1, v2, v3], .. }: &State<3>) -> Equations<3> {
        let Self { i1, m: [m2, m3], l: [l2, l3], c: [c2, c3], i: [[xx2, yy2, zz2], [xx3, yy3, zz3]], held } = *self;
        let ((s2, cos2), (s3, cos3), (s23, cos23)) = (q2.sin_cos(), q3.sin_cos(), (q2 + q3).sin_cos());
        let first = m2 * c2 + (m3 + held) * l2;
        let last = m3 * c3 + held * l3;
        let upper = m2 * c2 * c2 + (m3 + held) * l2 * l2;
        let lower = m3 * c3 * c3 + held * l3 * l3;
        let d11 = i1
            + xx2 * s2 * s2
            + (yy2 + upper) * cos2 * cos2
            + xx3 * s23 * s23
            + (yy3 + lower) * cos23 * cos23
            + 2.0 * last * l2 * cos2 * cos23;
        let d33 = zz3 + lower;
        let d23 = d33 + last * l2 * cos3;
        let d22 = zz2 + upper + d33 + 2.0 * last * l2 * cos3;
        // Halves of dD11/dq2, dD11/dq3 and dD22/dq3.
        let h3 = (xx3 - yy3 - lower) * s23 * cos23 - last * l2 * cos2 * s23;
        let h2 = (xx2 - yy2 - upper) * s2 * cos2 - last * l2 * s2 * cos23 + h3;
        let f = -last * l2 * s3;
        let c =
            Matrix3::new(h2 * v2 + h3 * v3, h2 * v1, h3 * v1, -h2 * v1, f * v3, f * (v2 + v3), -h3 * v1, -f * v2, 0.0);
        Equations {
            d: Matrix3::new(d11, 0.0, 0.0, 0.0, d22, d23, 0.0, d23, d33),
            c,
            g: Vector3::new(0.0, first * cos2 + last * cos23, last * cos23) * G,
        }
    }

    /// Exercise 13: only a mass at the elbow and one at the tip.
    fn of_two_points(x: [f64; 14]) -> Self {
        let arm = Self::of(x);
        Self { i1: 0.0, m: [arm.m[0], 0.0], c: [arm.l[0], 0.0], i: [[0.0; 3]; 2], ..arm }
    }
}

#[test]
fn equations_of_motion_of_the_articulated_arm() {
    assert_equal("exercises 16, 23, 28", (sizes(), states()), |(x, state)| {
        let arm = Articulated::of(x);
        arm.equations(&state).error(&arm.dynamics(0.4, -G), &state)
    });
}

/// Exercise 23: on this arm the forward recursion inverts the backward one.
#[test]
fn both_recursions_of_the_articulated_arm() {
    assert_equal("exercise 23", (sizes(), states()), |(x, state)| {
        there_and_back(&Articulated::of(x).dynamics(0.4, -G), &state)
    });
}

#[test]
fn equations_of_motion_of_two_points_on_massless_arms() {
    assert_equal("exercise 13", (sizes(), states()), |(x, state)| {
        let arm = Articulated::of_two_points(x);
        arm.equations(&state).error(&arm.dynamics(0.4, -G), &state)
    });
}

/// Exercise 35, with gravity along +z as stated: every joint carries minus the weight beyond it, and horizontal moments.
#[test]
fn statics_of_the_articulated_arm() {
    assert_equal("exercise 35", (sizes(), states()), |(x, state): (_, State<3>)| {
        let arm = Articulated { held: 20.0, ..Articulated::of(x) };
        let Articulated { m: [m2, m3], l: [l2, l3], c: [c2, c3], held, .. } = arm;
        let ([q1, q2, q3], height) = (state.q, 0.4);
        let (out, up) = (Vector3::new(q1.cos(), q1.sin(), 0.0), Vector3::z());
        let along = |angle: f64| out * angle.cos() + up * angle.sin();
        let (upper, lower) = (along(q2), along(q2 + q3));
        let pull = up * G;
        let third = -(lower * (m3 * c3 + held * l3)).cross(&pull);
        let second = third - (upper * (m2 * c2 + (m3 + held) * l2)).cross(&pull);
        // The base is vertically below the shoulder: vertical forces have no moment about it.
        let wanted = [(m2 + m3 + held, second), (m2 + m3 + held, second), (m3 + held, third)];
        let found = wrenches_in_base(&arm.dynamics(height, G), &State::still(state.q));
        let off = wanted
            .into_iter()
            .zip(found)
            .map(|((mass, moment), found)| larger((found.force + pull * mass).amax(), (found.moment - moment).amax()));
        off.fold(0.0, larger) / (G * (m2 + m3 + held) * (1.0 + l2 + l3 + c2 + c3))
    });
}

/// Exercise 35: the moment at the base is largest with the arm stretched out horizontally: the sum of masses times distances.
#[test]
fn largest_base_moment_is_at_full_level_reach() {
    let arm = Articulated::of([0.1, 4.0, 3.0, 0.6, 0.5, 0.3, 0.25, 20.0, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1]);
    let dynamics = arm.dynamics(0.4, G);
    let moment = |q: [f64; 3]| {
        let m = wrenches_in_base(&dynamics, &State::still(q))[0].moment;
        m.dot(&m).sqrt()
    };
    let largest = G * ((4.0 * 0.3 + 23.0 * 0.6) + (3.0 * 0.25 + 20.0 * 0.5));
    assert!((moment([0.3, 0.0, 0.0]) / largest - 1.0).abs() < 1e-14);
    for (i, j) in (0..48).flat_map(|i| (0..48).map(move |j| (i, j))).filter(|&(i, j)| (i % 24, j) != (0, 0)) {
        let step = core::f64::consts::TAU / 48.0;
        assert!(moment([0.3, step * f64::from(i), step * f64::from(j)]) < largest * 0.999, "{i} {j}");
    }
}
