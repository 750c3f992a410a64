//! The chapter's planar 2R arm with the chapter's symbols, for the examples up to 335.
#![allow(unreachable_pub, reason = "helpers of one test binary")]

use super::support_b::{
    DOWN_Y, State, arm, body, difference, joined, larger, planar_link, point, posture, pushed, sizes, states,
};
use dynamics_core::chapter::posture::{BaseFrameMotion, Posture};
use dynamics_core::{Body, Dynamics};
use nalgebra::Vector3;
use proptest::prelude::Strategy;

/// Lengths, mass centres from the joint, masses and moments of inertia about the mass centres, of two links; and a point mass
/// at the tip.
#[derive(Clone, Copy, Debug)]
pub struct TwoLinks {
    pub l1: f64,
    pub l2: f64,
    pub c1: f64,
    pub c2: f64,
    pub m1: f64,
    pub m2: f64,
    pub iz1: f64,
    pub iz2: f64,
    pub m0: f64,
}

/// The arm for which printed forms are shown to be wrong.
pub const STATED: TwoLinks =
    TwoLinks { l1: 1.0, l2: 0.8, c1: 0.45, c2: 0.3, m1: 4.0, m2: 2.5, iz1: 0.4, iz2: 0.16, m0: 2.0 };

impl TwoLinks {
    /// Two slender rods: mass centres in the middle, `m l^2 / 12` (eq. 12.188).
    pub fn rods(l1: f64, l2: f64, m1: f64, m2: f64) -> Self {
        let (iz1, iz2) = (m1 * l1 * l1 / 12.0, m2 * l2 * l2 / 12.0);
        Self { l1, l2, c1: 0.5 * l1, c2: 0.5 * l2, m1, m2, iz1, iz2, m0: 0.0 }
    }

    /// The arm in the core's form, in a plane with gravity along -y; the point mass is the scene's payload.
    pub fn dynamics(&self) -> Dynamics<f64, 2> {
        let links = [
            planar_link(self.l1, link(self.m1, self.c1 - self.l1, self.iz1)),
            planar_link(self.l2, link(self.m2, self.c2 - self.l2, self.iz2)),
        ];
        arm(&links, [0.0; 3], self.m0, DOWN_Y)
    }

    /// The same with the weight `m0 g` as a force at the tip: without the inertia of the payload, as in example 329.
    pub fn with_static_payload(&self, q: &[f64; 2]) -> Dynamics<f64, 2> {
        let empty = Self { m0: 0.0, ..*self }.dynamics();
        pushed(&empty, q, DOWN_Y * self.m0, Vector3::zeros())
    }
}

/// A flat body with its mass centre `x` from the link's far end.
pub fn link(mass: f64, x: f64, iz: f64) -> Body {
    body(mass, [x, 0.0, 0.0], [0.5 * iz, 0.5 * iz, iz])
}

/// A link with a point mass at its far end.
pub fn link_with_motor(own: Body, motor: f64) -> Body {
    joined(&[own, point(motor, [0.0; 3])])
}

/// Random sizes and states.
pub fn two_links() -> impl Strategy<Value = (TwoLinks, State<2>)> {
    (sizes::<9>(), states::<2>()).prop_map(|([l1, l2, c1, c2, m1, m2, iz1, iz2, m0], state)| {
        (TwoLinks { l1, l2, c1, c2, m1, m2, iz1, iz2, m0 }, state)
    })
}

/// Symbols of a 2R arm's state: angles by their sines and cosines, `w` and `e` for first and second derivatives, `12`
/// for the sum of both joints.
#[derive(Clone, Copy, Debug)]
pub struct Letters {
    pub sin1: f64,
    pub cos1: f64,
    pub sin2: f64,
    pub cos2: f64,
    pub sin12: f64,
    pub cos12: f64,
    pub w1: f64,
    pub w2: f64,
    pub w12: f64,
    pub e1: f64,
    pub e2: f64,
    pub e12: f64,
}

impl Letters {
    pub fn of(state: &State<2>) -> Self {
        let State { q: [q1, q2], qd: [w1, w2], qdd: [e1, e2] } = *state;
        let ((sin1, cos1), (sin2, cos2), (sin12, cos12)) = (q1.sin_cos(), q2.sin_cos(), (q1 + q2).sin_cos());
        Self { sin1, cos1, sin2, cos2, sin12, cos12, w1, w2, w12: w1 + w2, e1, e2, e12: e1 + e2 }
    }
}

/// Posture and motion of all links, with the payload, from the core.
pub fn moving<const N: usize>(
    dynamics: &Dynamics<f64, N>,
    state: &State<N>,
) -> (Posture<f64, N>, [BaseFrameMotion<f64>; N]) {
    let posture = posture(dynamics, &state.q);
    (posture, posture.motion(&state.qd, &state.qdd))
}

/// A vector of the plane of motion.
pub fn planar(x: f64, y: f64) -> Vector3<f64> {
    Vector3::new(x, y, 0.0)
}

/// Largest difference of two vectors over the largest entry of the second.
pub fn off(found: Vector3<f64>, wanted: Vector3<f64>) -> f64 {
    difference(found.as_slice(), wanted.as_slice())
}

/// The largest of several relative errors.
pub fn largest<const M: usize>(errors: [f64; M]) -> f64 {
    errors.into_iter().fold(0.0, larger)
}

/// Relative error of each number.
pub fn shares<const M: usize>(found: [f64; M], wanted: [f64; M]) -> [f64; M] {
    core::array::from_fn(|i| (found[i] / wanted[i] - 1.0).abs())
}
