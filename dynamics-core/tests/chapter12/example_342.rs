//! Example 342: an articulated arm of three revolute joints, eq. 12.363-12.390, with the terms that the book omits in 12.390.

use super::support_b::{
    Equations, G, STATED_3, State, arm, assert_equal, assert_stated, body, difference, joint, larger, placed, posture,
    sizes, states,
};
use crate::common::turns;
use dynamics_core::geometry::about_x;
use dynamics_core::kinematics::link_poses;
use dynamics_core::{Dh, Dynamics, Frame, JointKind, Live, energy};
use nalgebra::{Matrix3, Matrix4, Vector3};

const QUARTER: f64 = core::f64::consts::FRAC_PI_2;

/// Masses `m0` (load) to `m3`, lengths, mass centres `c` from the far ends `o_1`, `o_2` and from `o_3` along `z_3`, and
/// principal moments of inertia, all in the book's frames.
struct Articulated {
    m: [f64; 4],
    l: [f64; 3],
    c: [f64; 3],
    i: [[f64; 3]; 3],
}

/// The arm for which printed forms are shown to be wrong.
pub(super) fn stated() -> Dynamics<f64, 3> {
    Articulated::stated().dynamics()
}

impl Articulated {
    fn stated() -> Self {
        Self {
            m: [0.8, 4.0, 3.0, 2.0],
            l: [0.2, 0.6, 0.5],
            c: [0.1, -0.35, 0.2],
            i: [[0.05, 0.04, 0.06], [0.02, 0.11, 0.12], [0.07, 0.08, 0.01]],
        }
    }

    fn of((sizes, inertia): ([f64; 10], [f64; 9])) -> Self {
        let [m0, m1, m2, m3, l1, l2, l3, c1, c2, c3] = sizes;
        let i = core::array::from_fn(|k| core::array::from_fn(|axis| inertia[3 * k + axis]));
        // The mass centre of the second link is inside the link, before its far end.
        Self { m: [m0, m1, m2, m3], l: [l1, l2, l3], c: [c1, -c2, c3], i }
    }

    /// The book's frames, each link's at its joint: `o_1` is `l1` before the foot of `z_1`, where the second joint is.
    fn dynamics(&self) -> Dynamics<f64, 3> {
        let Self { m: [m0, m1, m2, m3], l: [l1, l2, l3], c: [c1, c2, c3], i: [i1, i2, i3] } = *self;
        let (turned, zero) = (about_x(QUARTER), [0.0; 3]);
        // z_1 and z_3 are -y of the frames here, to which the twist has not yet been applied.
        let first = body(m1, [0.0, l1 - c1, 0.0], [i1[0], i1[2], i1[1]]);
        let second = body(m2, [c2 + l2, 0.0, 0.0], i2);
        let third = body(m3, [0.0, -c3, 0.0], [i3[0], i3[2], i3[1]]);
        let joints = [
            placed(JointKind::Revolute, Matrix3::identity(), zero, [0.0, 0.0, 1.0], first),
            placed(JointKind::Revolute, turned, [0.0, l1, 0.0], [0.0, 0.0, 1.0], second),
            placed(JointKind::Revolute, Matrix3::identity(), [l2, 0.0, 0.0], [0.0, 0.0, 1.0], third),
        ];
        arm(&joints, [0.0, -l3, 0.0], m0, Vector3::new(0.0, 0.0, -G))
    }

    /// The same arm as rows of a table: (a, alpha, d) = (0, 90, 0), (l2, 0, -l1), (0, 90, 0).
    fn by_rows(&self) -> Dynamics<f64, 3> {
        let Self { m: [m0, m1, m2, m3], l: [l1, l2, l3], c: [c1, c2, c3], i: [i1, i2, i3] } = *self;
        let row =
            |a, alpha, d, body| joint(JointKind::Revolute, Frame::ClassicalDh(Dh { a, alpha, d, theta: 0.0 }), body);
        let joints = [
            row(0.0, QUARTER, 0.0, body(m1, [0.0, 0.0, c1 - l1], i1)),
            row(l2, 0.0, -l1, body(m2, [c2, 0.0, 0.0], i2)),
            row(0.0, QUARTER, 0.0, body(m3, [0.0, 0.0, c3], i3)),
        ];
        arm(&joints, [0.0, 0.0, l3], m0, Vector3::new(0.0, 0.0, -G))
    }

    /// The matrices of 12.390, by Lagrange's method from the energies 12.385 (with `m2` for the printed `m21`) and 12.386.
    fn equations(&self, state: &State<3>) -> Equations<3> {
        let Self { m: [m0, m1, m2, m3], l: [l1, l2, l3], c: [c1, c2, c3], i: [i1, i2, i3] } = *self;
        let [_, q2, q3] = state.q;
        let [qd1, qd2, qd3] = state.qd;
        let ((s2, cos2), (s3, cos3), (s23, cos23)) = (q2.sin_cos(), q3.sin_cos(), (q2 + q3).sin_cos());
        let b = m3 * c3 + m0 * l3;
        let a22 = m2 * (c2 + l2) * (c2 + l2) + (m3 + m0) * l2 * l2;
        let a33 = m3 * c3 * c3 + m0 * l3 * l3;
        let off = m2 * (c2 + l2) + (m3 + m0) * l2;

        let d11 = i1[1]
            + m1 * (l1 - c1) * (l1 - c1)
            + (m2 + m3 + m0) * l1 * l1
            + i2[0] * s2 * s2
            + (i2[1] + a22) * cos2 * cos2
            + (i3[0] + a33) * s23 * s23
            + i3[2] * cos23 * cos23
            + 2.0 * b * l2 * cos2 * s23;
        let d12 = l1 * (off * s2 - b * cos23);
        let d13 = -l1 * b * cos23;
        let d22 = i2[2] + i3[1] + a22 + a33 + 2.0 * b * l2 * s3;
        let d23 = i3[1] + a33 + b * l2 * s3;
        let d33 = i3[1] + a33;

        // Half of dD11/dq2 and of dD11/dq3; dD12/dq2; dD12/dq3 = dD13/dq2 = dD13/dq3; half of dD22/dq3 = dD23/dq3.
        let h3 = (i3[0] + a33 - i3[2]) * s23 * cos23 + b * l2 * cos2 * cos23;
        let h2 = (i2[0] - i2[1] - a22) * s2 * cos2 - b * l2 * s2 * s23 + h3;
        let (e2, e3, f) = (l1 * (off * cos2 + b * s23), l1 * b * s23, b * l2 * cos3);
        let c = Matrix3::new(
            h2 * qd2 + h3 * qd3,
            h2 * qd1 + e2 * qd2 + e3 * qd3,
            h3 * qd1 + e3 * (qd2 + qd3),
            -h2 * qd1,
            f * qd3,
            f * (qd2 + qd3),
            -h3 * qd1,
            -f * qd2,
            0.0,
        );
        Equations {
            d: Matrix3::new(d11, d12, d13, d12, d22, d23, d13, d23, d33),
            c,
            g: Vector3::new(0.0, off * cos2 + b * s23, b * s23) * G,
        }
    }

    /// `r_1, d_1, r_2, d_2, r_3, d_3` (eq. 12.367-12.372, the last four corrected).
    fn points(&self, [q1, q2, q3]: [f64; 3]) -> [Vector3<f64>; 6] {
        let Self { l: [l1, l2, l3], c: [c1, c2, c3], .. } = *self;
        let ((s1, cos1), (s2, cos2), (s23, cos23)) = (q1.sin_cos(), q2.sin_cos(), (q2 + q3).sin_cos());
        let beside = Vector3::new(-s1, cos1, 0.0);
        let out = Vector3::new(cos1, s1, 0.0);
        let up = Vector3::z();
        let second = |reach: f64| beside * l1 + out * (reach * cos2) + up * (reach * s2);
        let third = |reach: f64| beside * l1 + out * (reach * s23 + l2 * cos2) + up * (l2 * s2 - reach * cos23);
        [beside * (l1 - c1), beside * l1, second(c2 + l2), second(l2), third(c3), third(l3)]
    }
}

#[test]
fn equations_of_motion_are_12_390() {
    assert_equal("example 342", ((sizes(), sizes()), states()), |(sizes, state)| {
        let arm = Articulated::of(sizes);
        arm.equations(&state).error(&arm.dynamics(), &state)
    });
}

/// The example's frames are not those of a Denavit-Hartenberg table. The rows for the same arm give the same equations.
#[test]
fn rows_of_a_table_give_the_same_arm() {
    assert_equal("rows", ((sizes(), sizes()), states()), |(sizes, state)| {
        let arm = Articulated::of(sizes);
        arm.equations(&state).error(&arm.by_rows(), &state)
    });
}

/// 12.363-12.366: the product of the example's transformations places the third frame at the same pose as the general code.
#[test]
fn transformations_are_12_363_to_12_366() {
    let arm = Articulated::stated();
    let [l1, l2, _] = arm.l;
    let [(s1, c1), (s2, c2), (s3, c3)] = STATED_3.q.map(f64::sin_cos);
    let row = Matrix4::new;
    let t10 = row(c1, s1, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, s1, -c1, 0.0, l1, 0.0, 0.0, 0.0, 1.0);
    let t01 = row(c1, 0.0, s1, -l1 * s1, s1, 0.0, -c1, l1 * c1, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let t12 = row(c2, -s2, 0.0, l2 * c2, s2, c2, 0.0, l2 * s2, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let t23 = row(c3, 0.0, s3, 0.0, s3, 0.0, -c3, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    assert!((t10 * t01 - Matrix4::identity()).amax() < 1e-15);
    let t03 = t01 * t12 * t23;
    let pose = link_poses(arm.dynamics().model(), &turns(&STATED_3.q), &STATED_3.q)[2];
    let rotation = pose.rotation * about_x(QUARTER);
    for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
        assert!((t03[(r, c)] - rotation[(r, c)]).abs() < 1e-15);
    }
    for r in 0..3 {
        assert!((t03[(r, 3)] - pose.translation[r]).abs() < 1e-15);
    }
}

/// 12.367-12.372, 12.373-12.375, 12.376-12.378 and the velocities 12.379-12.384, on arms without a load.
#[test]
fn kinematics_are_12_367_to_12_384() {
    assert_equal("12.367-12.384", ((sizes(), sizes()), states()), |(sizes, state)| {
        let mut arm = Articulated::of(sizes);
        arm.m[0] = 0.0;
        let posture = posture(&arm.dynamics(), &state.q);
        let motion = posture.motion(&state.qd, &[0.0; 3]);
        let [qd1, qd2, qd3] = state.qd;
        let (s1, c1) = state.q[0].sin_cos();
        let [r1, d1, r2, d2, r3, d3] = arm.points(state.q);
        let places = posture.links.map(|link| link.centre);
        let mut worst = [
            (places[0], r1),
            (posture.end(0), d1),
            (places[1], r2),
            (posture.end(1), d2),
            (places[2], r3),
            (posture.end(2), d3),
            // 12.373-12.375: the axes z_1 and z_2 are both (sin, -cos, 0).
            (motion[0].omega, Vector3::z() * qd1),
            (motion[1].omega, Vector3::new(s1, -c1, 0.0) * qd2 + Vector3::z() * qd1),
            (motion[2].omega, Vector3::new(s1, -c1, 0.0) * (qd2 + qd3) + Vector3::z() * qd1),
            // 12.379 and 12.382
            (motion[0].velocity, -Vector3::new(c1, s1, 0.0) * ((arm.l[0] - arm.c[0]) * qd1)),
            (motion[0].omega.cross(&posture.end(0)), -Vector3::new(c1, s1, 0.0) * (arm.l[0] * qd1)),
        ]
        .map(|(found, wanted)| (found - wanted).amax() / 6.0)
        .into_iter()
        .fold(0.0, larger);
        // 12.380-12.381, 12.383-12.384: the points' velocities are the derivatives of their positions; the linear part along each joint.
        let tip = motion[2].velocity + motion[2].omega.cross(&posture.outer_arm(2));
        for (found, k) in [(motion[1].velocity, 2), (motion[2].velocity, 4), (tip, 5)] {
            let step = 1e-4;
            let at = |n: f64| arm.points(core::array::from_fn(|j| state.q[j] + n * step * state.qd[j]))[k];
            let rate = (at(-2.0) - at(-1.0) * 8.0 + at(1.0) * 8.0 - at(2.0)) / (12.0 * step);
            assert!((found - rate).amax() < 1e-9 * 20.0, "{found} {rate}");
        }
        // 12.376
        let [ix, iy, iz] = arm.i[0];
        let xy = (ix - iz) * c1 * s1;
        let tensor =
            Matrix3::new(ix * c1 * c1 + iz * s1 * s1, xy, 0.0, xy, iz * c1 * c1 + ix * s1 * s1, 0.0, 0.0, 0.0, iy);
        worst = larger(worst, difference(posture.links[0].inertia.as_slice(), tensor.as_slice()));
        // 12.377-12.378, with the rotations of 12.364-12.366: `x_2` along the upper arm, `z_1 = z_2` across it, `z_3` along the forearm.
        let ((s2, c2), (s23, c23)) = (state.q[1].sin_cos(), (state.q[1] + state.q[2]).sin_cos());
        let across = Vector3::new(s1, -c1, 0.0);
        let second = [Vector3::new(c1 * c2, s1 * c2, s2), Vector3::new(-c1 * s2, -s1 * s2, c2), across];
        let third = [Vector3::new(c1 * c23, s1 * c23, s23), across, Vector3::new(c1 * s23, s1 * s23, -c23)];
        for (k, axes) in [(1, second), (2, third)] {
            let parts = axes.iter().zip(arm.i[k]).map(|(axis, moment)| axis * axis.transpose() * moment);
            let tensor = parts.fold(Matrix3::zeros(), |sum, part| sum + part);
            worst = larger(worst, difference(posture.links[k].inertia.as_slice(), tensor.as_slice()));
        }
        worst
    });
}

/// 12.385, with the second link's own mass, and 12.386.
#[test]
fn energies_are_12_385_and_12_386() {
    let (arm, State { q, qd, .. }) = (Articulated::stated(), STATED_3);
    let dynamics = arm.dynamics();
    let [m0, m1, m2, m3] = arm.m;
    // The masses separately, because the general code merges load and link.
    let bare = Articulated { m: [0.0, m1, m2, m3], ..Articulated::stated() };
    let posture = posture(&bare.dynamics(), &q);
    let motion = posture.motion(&qd, &[0.0; 3]);
    let tip = motion[2].velocity + motion[2].omega.cross(&posture.outer_arm(2));
    let links = |masses: [f64; 3]| -> f64 {
        let link = |k: usize| {
            let (place, motion) = (&posture.links[k], &motion[k]);
            (masses[k] * motion.velocity.dot(&motion.velocity) + motion.omega.dot(&(place.inertia * motion.omega)))
                / 2.0
        };
        (0..3).map(link).sum::<f64>() + m0 * tip.dot(&tip) / 2.0
    };
    let found = energy::kinetic(&dynamics, &turns(&q), &q, &qd, &Live::zero());
    assert!(difference(&[found], &[links([m1, m2, m3])]) < 1e-14);
    let [_, _, r2, _, r3, d3] = arm.points(q);
    let potential = m2 * G * r2.z + m3 * G * r3.z + m0 * G * d3.z;
    let found = energy::potential(&dynamics, &turns(&q), &q, &Live::zero());
    assert!((found - potential).abs() < 1e-14 * (m2 + m3 + m0) * G);
}

/// 12.369-12.372 add an origin that the transformation has already added. 12.371-12.372 multiply all of `l2` by the length
/// beyond it. Their fourth elements, 2 and 3, are not those of a point.
#[test]
fn printed_12_369_to_12_372_are_wrong() {
    let arm = Articulated::stated();
    let Articulated { l: [l1, l2, l3], c: [_, c2, c3], m: [_, m1, m2, m3], .. } = arm;
    let bare = Articulated { m: [0.0, m1, m2, m3], ..arm };
    let posture = posture(&bare.dynamics(), &STATED_3.q);
    let [r2, r3] = [posture.links[1].centre, posture.links[2].centre];
    let [d2, d3] = [posture.end(1), posture.end(2)];
    let [q1, q2, q3] = STATED_3.q;
    let ((s1, k1), (s2, k2), (s23, k23)) = (q1.sin_cos(), q2.sin_cos(), (q2 + q3).sin_cos());
    let reach = c2 + l2;
    let printed_r2 = Vector3::new(-2.0 * l1 * s1 + reach * k1 * k2, 2.0 * l1 * k1 + reach * k2 * s1, reach * s2);
    let printed_d2 = Vector3::new(l2 * k1 * k2 - l1 * s1, l1 * k1 + l2 * k2 * s1, l2 * s2) * 2.0;
    let printed_third = |c: f64| {
        let out = c * (s23 + 3.0 * l2 * k2);
        Vector3::new(k1 * out - 3.0 * l1 * s1, s1 * out + 3.0 * l1 * k1, 3.0 * l2 * s2 - c * k23)
    };
    let pairs = [(printed_r2, r2), (printed_d2, d2), (printed_third(c3), r3), (printed_third(l3), d3)];
    let off = pairs.map(|(printed, right)| difference(printed.as_slice(), right.as_slice()));
    assert_stated(&off, &[0.7527, 1.0, 2.613, 2.112]);
}
