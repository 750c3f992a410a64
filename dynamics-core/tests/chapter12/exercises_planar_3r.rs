//! Exercises 11, 20, 26 and 34: the planar arm of three revolute joints on a wall. Gravity is along +x in exercise 11 and along
//! -x in the others.

use super::support_b::{
    Equations, G, State, arm, assert_equal, body, felt, larger, largest, planar_link, sizes, states, wrenches_in_base,
};
use dynamics_core::{Dynamics, Wrench};
use nalgebra::{Matrix3, Vector3};

/// Masses, lengths, distances of the mass centres from the links' joints, and moments of inertia about the mass centres.
#[derive(Clone, Copy)]
struct Wall {
    m: [f64; 3],
    l: [f64; 3],
    c: [f64; 3],
    i: [f64; 3],
    /// Gravitational acceleration along x, m/s^2.
    pull: f64,
}

impl Wall {
    fn of(x: [f64; 12], pull: f64) -> Self {
        let part = |n: usize| core::array::from_fn(|k| x[3 * n + k]);
        Self { m: part(0), l: part(1), c: part(2), i: part(3), pull }
    }

    fn dynamics(&self) -> Dynamics<f64, 3> {
        let link = |k: usize| {
            planar_link(self.l[k], body(self.m[k], [self.c[k] - self.l[k], 0.0, 0.0], [0.0, 0.0, self.i[k]]))
        };
        arm(&[link(0), link(1), link(2)], [0.0; 3], 0.0, Vector3::new(self.pull, 0.0, 0.0))
    }

    /// By Lagrange's method (exercise 26).
    fn equations(&self, State { q: [q1, q2, q3], qd: [v1, v2, v3], .. }: &State<3>) -> Equations<3> {
        let Self { m: [m1, m2, m3], l: [l1, l2, _], c: [c1, c2, c3], i: [i1, i2, i3], pull } = *self;
        let elbow = m2 * c2 + m3 * l2;
        let (cos2, cos3, cos23) = (q2.cos(), q3.cos(), (q2 + q3).cos());
        let d33 = i3 + m3 * c3 * c3;
        let d23 = d33 + m3 * l2 * c3 * cos3;
        let d22 = i2 + m2 * c2 * c2 + d33 + m3 * (l2 * l2 + 2.0 * l2 * c3 * cos3);
        let d13 = d23 + m3 * c3 * l1 * cos23;
        let d12 = d22 + l1 * (elbow * cos2 + m3 * c3 * cos23);
        let d11 = i1 + m1 * c1 * c1 + (m2 + m3) * l1 * l1 + d22 + 2.0 * l1 * (elbow * cos2 + m3 * c3 * cos23);
        // a: minus half of dD11/dq2; e: minus dD23/dq3; e + b: minus half of dD11/dq3.
        let b = l1 * m3 * c3 * (q2 + q3).sin();
        let a = l1 * elbow * q2.sin() + b;
        let e = m3 * l2 * c3 * q3.sin();
        let c = Matrix3::new(
            -a * v2 - (e + b) * v3,
            -a * (v1 + v2) - (e + b) * v3,
            -(e + b) * (v1 + v2 + v3),
            a * v1 - e * v3,
            -e * v3,
            -e * (v1 + v2 + v3),
            (e + b) * v1 + e * v2,
            e * (v1 + v2),
            0.0,
        );
        let (s1, s12, s123) = (q1.sin(), (q1 + q2).sin(), (q1 + q2 + q3).sin());
        let g3 = m3 * c3 * s123;
        let g2 = elbow * s12 + g3;
        let g1 = (m1 * c1 + (m2 + m3) * l1) * s1 + g2;
        Equations {
            d: Matrix3::new(d11, d12, d13, d12, d22, d23, d13, d23, d33),
            c,
            g: Vector3::new(g1, g2, g3) * pull,
        }
    }

    /// Every joint's force and moment by Newton's and Euler's laws, in the base frame (exercise 11 a).
    fn wrenches(&self, State { q, qd, qdd }: &State<3>) -> [(Vector3<f64>, f64); 3] {
        let sum = |x: &[f64; 3], k: usize| x[..=k].iter().sum::<f64>();
        let along = |k: usize| Vector3::new(sum(q, k).cos(), sum(q, k).sin(), 0.0);
        let across = |k: usize| Vector3::new(-sum(q, k).sin(), sum(q, k).cos(), 0.0);
        let gained = |k: usize| across(k) * sum(qdd, k) - along(k) * (sum(qd, k) * sum(qd, k));
        let centre = |k: usize| gained(k) * self.c[k] + (0..k).map(|j| gained(j) * self.l[j]).sum::<Vector3<f64>>();
        let pull = Vector3::x() * self.pull;
        let mut wrenches = [(Vector3::zeros(), 0.0); 3];
        let (mut force, mut moment) = (Vector3::zeros(), 0.0);
        for k in (0..3).rev() {
            let own = (centre(k) - pull) * self.m[k];
            moment +=
                (along(k) * self.l[k]).cross(&force).z + (along(k) * self.c[k]).cross(&own).z + self.i[k] * sum(qdd, k);
            force += own;
            wrenches[k] = (force, moment);
        }
        wrenches
    }
}

#[test]
fn equations_of_motion_of_the_three_link_arm() {
    for (what, pull) in [("exercise 11", G), ("exercises 20, 26", -G)] {
        assert_equal(what, (sizes(), states()), |(x, state)| {
            let arm = Wall::of(x, pull);
            arm.equations(&state).error(&arm.dynamics(), &state)
        });
    }
}

#[test]
fn joint_forces_of_the_three_link_arm() {
    for (what, pull) in [("exercise 11 a", G), ("exercise 20", -G)] {
        assert_equal(what, (sizes(), states()), |(x, state)| {
            let arm = Wall::of(x, pull);
            let found = wrenches_in_base(&arm.dynamics(), &state);
            let off = arm.wrenches(&state).into_iter().zip(found).map(|((force, moment), found)| {
                larger((found.force - force).amax(), (found.moment - Vector3::z() * moment).amax())
            });
            off.fold(0.0, larger) / largest(&found)
        });
    }
}

/// Exercise 20 b: the forward recursion, started with the base's force and moment from the laws of each link, gives zero at the tip.
#[test]
fn forward_recursion_of_the_three_link_arm() {
    assert_equal("exercise 20 b", (sizes(), states()), |(x, state)| {
        let arm = Wall::of(x, -G);
        let [(force, moment), ..] = arm.wrenches(&state);
        let base = Wrench { force, moment: Vector3::z() * moment };
        let left = felt(&arm.dynamics(), &state, &base);
        largest(&[left]) / largest(&[base])
    });
}

/// Exercise 34: at rest every joint carries the links beyond it, `F_{i-1} = g sum m_k i` and
/// `M_{i-1} = -g sum m_k y_k`, heights from the joint.
#[test]
fn statics_of_the_three_link_arm() {
    assert_equal("exercise 34", (sizes(), states()), |(x, state): (_, State<3>)| {
        let (arm, still) = (Wall::of(x, -G), State::still(state.q));
        let ([m1, m2, m3], [l1, l2, _], [c1, c2, c3]) = (arm.m, arm.l, arm.c);
        let [q1, q2, q3] = state.q;
        let (s1, s12, s123) = (q1.sin(), (q1 + q2).sin(), (q1 + q2 + q3).sin());
        let third = -G * m3 * c3 * s123;
        let second = third - G * (m2 * c2 + m3 * l2) * s12;
        let first = second - G * (m1 * c1 + (m2 + m3) * l1) * s1;
        let wanted = [(m1 + m2 + m3, first), (m2 + m3, second), (m3, third)];
        let found = wrenches_in_base(&arm.dynamics(), &still);
        let off = wanted.into_iter().zip(found).map(|((mass, moment), found)| {
            let force = (found.force - Vector3::x() * (mass * G)).amax();
            larger(force, (found.moment - Vector3::z() * moment).amax())
        });
        off.fold(0.0, larger) / largest(&found)
    });
}
