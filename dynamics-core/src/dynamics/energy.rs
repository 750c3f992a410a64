//! Kinetic and potential energy.

use crate::geometry::apply;
use crate::kinematics::link_poses;
use crate::mass_matrix::mass_matrix;
use crate::scalar::Scalar;
use crate::scene::{Dynamics, Live};
use crate::trig::SinCos;

/// Kinetic energy `1/2 qd^T D(q) qd`, J, with the payload and the rotors that the scene counts (eq. 12.228, corrected).
#[must_use]
pub fn kinetic<S: Scalar, const N: usize>(
    dynamics: &Dynamics<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    live: &Live<S, N>,
) -> S {
    let matrix = mass_matrix(dynamics, turn, q, live);
    let mut twice = S::zero();
    for i in 0..N {
        for j in 0..N {
            twice += qd[i] * matrix[(i, j)] * qd[j];
        }
    }
    twice * S::literal(0.5)
}

/// Potential energy `-sum_i g . (m_i r_i)`, J, zero for masses at the base origin (eq. 12.231).
#[must_use]
pub fn potential<S: Scalar, const N: usize>(
    dynamics: &Dynamics<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    live: &Live<S, N>,
) -> S {
    let Some(gravity) = dynamics.scene().gravity.value(&live.gravity) else {
        return S::zero();
    };
    let poses = link_poses(dynamics.model(), turn, q);
    let mut energy = S::zero();
    for i in 0..N {
        let body = dynamics.inertia(i, live);
        let moment = poses[i].translation * body.mass + apply(&poses[i].rotation, &body.first_moment);
        energy -= gravity.dot(&moment);
    }
    energy
}
