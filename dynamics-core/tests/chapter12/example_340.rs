//! Example 340: the general planar arm of two revolute joints, eq. 12.301-12.331.

use super::support_b::{
    DOWN_Y, Equations, G, STATED_2, State, arm, assert_equal, assert_stated, body, difference, joined, larger,
    planar_link, point, posture, sizes, states,
};
use crate::common::turns;
use dynamics_core::{Dynamics, Live, energy};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Links `m11`, `m21` with mass centres at `c` from their joints, a motor `m12` at the second joint, a payload `m0`.
#[derive(Clone, Copy)]
pub(super) struct Arm {
    pub(super) m11: f64,
    pub(super) m12: f64,
    pub(super) m21: f64,
    pub(super) m0: f64,
    pub(super) l: [f64; 2],
    pub(super) c: [f64; 2],
    pub(super) iz: [f64; 2],
}

impl Arm {
    pub(super) const STATED: Self =
        Self { m11: 3.0, m12: 1.2, m21: 2.0, m0: 0.8, l: [0.7, 0.5], c: [0.3, 0.2], iz: [0.15, 0.06] };

    pub(super) fn of([m11, m12, m21, m0, l1, l2, c1, c2, iz1, iz2]: [f64; 10]) -> Self {
        Self { m11, m12, m21, m0, l: [l1, l2], c: [c1, c2], iz: [iz1, iz2] }
    }

    pub(super) fn dynamics(&self) -> Dynamics<f64, 2> {
        let ([l1, l2], [c1, c2], [iz1, iz2]) = (self.l, self.c, self.iz);
        let first = joined(&[body(self.m11, [c1 - l1, 0.0, 0.0], [0.0, 0.0, iz1]), point(self.m12, [0.0; 3])]);
        let second = body(self.m21, [c2 - l2, 0.0, 0.0], [0.0, 0.0, iz2]);
        arm(&[planar_link(l1, first), planar_link(l2, second)], [0.0; 3], self.m0, DOWN_Y)
    }

    /// 12.322-12.331, the last two with the missing `g`.
    pub(super) fn equations(&self, state: &State<2>) -> Equations<2> {
        let Self { m11, m12, m21, m0, l: [l1, l2], c: [c1, c2], iz: [iz1, iz2] } = *self;
        let ([q1, q2], [qd1, qd2]) = (state.q, state.qd);
        let (s2, cos2, cos1, cos12) = (q2.sin(), q2.cos(), q1.cos(), (q1 + q2).cos());
        let far = m21 * c2 + m0 * l2;
        let d11 = 2.0 * l1 * far * cos2
            + iz1
            + iz2
            + m11 * c1 * c1
            + m12 * l1 * l1
            + m21 * (c2 * c2 + l1 * l1)
            + m0 * (l1 * l1 + l2 * l2);
        let d12 = l1 * far * cos2 + iz2 + m0 * l2 * l2 + m21 * c2 * c2;
        let d22 = iz2 + m21 * c2 * c2 + m0 * l2 * l2;
        let c11 = -l1 * far * qd2 * s2;
        let c12 = -l1 * far * (qd1 + qd2) * s2;
        let c21 = l1 * far * qd1 * s2;
        let g1 = G * (((m21 + m12 + m0) * l1 + m11 * c1) * cos1 + far * cos12);
        let g2 = G * far * cos12;
        Equations { d: Matrix2::new(d11, d12, d12, d22), c: Matrix2::new(c11, c12, c21, 0.0), g: Vector2::new(g1, g2) }
    }
}

#[test]
fn equations_of_motion_are_12_322_to_12_331() {
    assert_equal("example 340", (sizes(), states()), |(sizes, state)| {
        let arm = Arm::of(sizes);
        arm.equations(&state).error(&arm.dynamics(), &state)
    });
}

/// 12.317 and 12.318.
#[test]
fn energies_are_12_317_and_12_318() {
    assert_equal("12.317-12.318", (sizes(), states()), |(sizes, state)| {
        let arm = Arm::of(sizes);
        let Arm { m11, m12, m21, m0, l: [l1, l2], c: [c1, c2], iz: [iz1, iz2] } = arm;
        let ([q1, q2], [qd1, qd2]) = (state.q, state.qd);
        let ((s1, cos1), (s12, cos12), w12) = (q1.sin_cos(), (q1 + q2).sin_cos(), qd1 + qd2);
        let square = |reach: f64| {
            let x = -l1 * qd1 * s1 - reach * w12 * s12;
            let y = l1 * qd1 * cos1 + reach * w12 * cos12;
            x * x + y * y
        };
        let kinetic = (m11 * c1 * c1 + m12 * l1 * l1 + iz1) * qd1 * qd1 / 2.0
            + m21 * square(c2) / 2.0
            + m0 * square(l2) / 2.0
            + iz2 * w12 * w12 / 2.0;
        let potential =
            m11 * G * c1 * s1 + m12 * G * l1 * s1 + m21 * G * (l1 * s1 + c2 * s12) + m0 * G * (l1 * s1 + l2 * s12);
        let (dynamics, turn) = (arm.dynamics(), turns(&state.q));
        let found = energy::kinetic(&dynamics, &turn, &state.q, &state.qd, &Live::zero());
        // 1/2 qd^T D qd cancels if the joints turn in opposite directions; its error is relative to D.
        let size = Equations::of(&dynamics, &state.q, &state.qd).d.amax() * (qd1 * qd1).max(qd2 * qd2);
        let error = (found - kinetic).abs() / size;
        let found = energy::potential(&dynamics, &turn, &state.q, &Live::zero());
        let height = (m11 + m12 + m21 + m0) * G * (l1 + l2 + c1 + c2);
        larger(error, (found - potential).abs() / height)
    });
}

/// 12.301-12.304, 12.307-12.311 and 12.313-12.315, on arms without a payload, because the general code adds a payload to its link.
#[test]
fn kinematics_are_12_301_to_12_315() {
    assert_equal("12.301-12.315", (sizes(), sizes::<4>(), states()), |(sizes, ixy, state)| {
        let arm = Arm { m12: 0.0, m0: 0.0, ..Arm::of(sizes) };
        let Arm { m11, m21, l: [l1, l2], c: [c1, c2], iz, .. } = arm;
        let links = [
            planar_link(l1, body(m11, [c1 - l1, 0.0, 0.0], [ixy[0], ixy[1], iz[0]])),
            planar_link(l2, body(m21, [c2 - l2, 0.0, 0.0], [ixy[2], ixy[3], iz[1]])),
        ];
        let posture = posture(&super::support_b::arm(&links, [0.0; 3], 0.0, DOWN_Y), &state.q);
        let motion = posture.motion(&state.qd, &[0.0; 2]);
        let ([q1, q2], [qd1, qd2]) = (state.q, state.qd);
        let along = |angle: f64| Vector3::new(angle.cos(), angle.sin(), 0.0);
        let across = |angle: f64| Vector3::new(-angle.sin(), angle.cos(), 0.0);
        let (q12, w12) = (q1 + q2, qd1 + qd2);
        let z = Vector3::z();
        let tip_speed = motion[1].velocity + motion[1].omega.cross(&posture.outer_arm(1));
        let pairs = [
            (posture.links[0].centre, along(q1) * c1),
            (posture.links[1].centre, along(q1) * l1 + along(q12) * c2),
            (posture.end(0), along(q1) * l1),
            (posture.end(1), along(q1) * l1 + along(q12) * l2),
            (motion[0].omega, z * qd1),
            (motion[1].omega, z * w12),
            (motion[0].velocity, across(q1) * (c1 * qd1)),
            (motion[1].velocity, across(q1) * (l1 * qd1) + across(q12) * (c2 * w12)),
            (motion[0].omega.cross(&posture.end(0)), across(q1) * (l1 * qd1)),
            (tip_speed, across(q1) * (l1 * qd1) + across(q12) * (l2 * w12)),
        ];
        let size = 1.0 + l1 + l2 + c1 + c2;
        let worst = pairs.map(|(found, wanted)| (found - wanted).amax() / size).into_iter().fold(0.0, larger);
        [q1, q12].into_iter().enumerate().fold(worst, |worst, (i, angle)| {
            let (s, c) = angle.sin_cos();
            let (ix, iy) = (ixy[2 * i], ixy[2 * i + 1]);
            let (xx, yy, xy) = (ix * c * c + iy * s * s, iy * c * c + ix * s * s, (ix - iy) * c * s);
            let tensor = Matrix3::new(xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, iz[i]);
            larger(worst, difference(posture.links[i].inertia.as_slice(), tensor.as_slice()))
        })
    });
}

/// 12.330-12.331 as printed are first moments, kg m: they are torques only after multiplication by `g`.
#[test]
fn printed_12_330_and_12_331_lack_g() {
    let found = Equations::of(&Arm::STATED.dynamics(), &STATED_2.q, &STATED_2.qd).g;
    let printed = Arm::STATED.equations(&STATED_2).g / G;
    assert_stated(&[difference(&[printed.x], &[found.x]), difference(&[printed.y], &[found.y])], &[0.8981, 0.8981]);
}
