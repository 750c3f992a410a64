//! Coupling between the spin of the rotors and the links that carry them (eq. 12.404, completed), as a term of the plant.
//!
//! The rotor of joint `m` is mounted on the link before the joint. It spins about the joint's axis `k`, `g` times as fast as the joint turns. Let `I`
//! be its inertia about `k`, `w` the angular velocity of that link, and `a` the link's angular acceleration at `qdd = 0`. Lagrange's equation of the
//! energy `g I qd_m (k . w)` adds
//!
//! ```text
//! D_mi += g I (k . z_i),   h_m += g I (k . a),   h_i += g I qd_m k . (z_i x w)        revolute joints i before m
//! ```
//!
//! `1/2 I (k . w)^2` is counted with the link, whose inertia tensor includes the rotor. Nothing here is shared with
//! [`dynamics_core::chapter::rotor_coupling`]; the tests compare the two.

use super::kinematics::Pose;
use super::terms::Terms;
use dynamics_core::{JointKind, JointSpec, Scalar};
use nalgebra::Vector3;

/// Gear ratio times rotor inertia of each joint, with the ratio's sign, kg m^2 (kg m for a prismatic joint).
pub(super) fn gear_times_inertia<const N: usize>(joints: &[JointSpec; N]) -> [f64; N] {
    joints.each_ref().map(|joint| joint.rotor.gear * joint.rotor.inertia)
}

/// Adds the coupling to the terms at a state.
pub(super) fn add<S: Scalar, const N: usize>(
    terms: &mut Terms<N, S>,
    pose: &[Pose<S>; N],
    qd: &[S; N],
    coupling: &[S; N],
) {
    #[cfg(test)]
    super::calls::count(super::calls::Effect::RotorCoupling);
    let (mut w, mut a) = (Vector3::zeros(), Vector3::zeros());
    for m in 0..N {
        let (k, own) = (&pose[m].axis, coupling[m]);
        terms.coriolis[m] += own * k.dot(&a);
        for i in 0..m {
            if pose[i].kind == JointKind::Revolute {
                let along = own * k.dot(&pose[i].axis);
                terms.mass_matrix[(m, i)] += along;
                terms.mass_matrix[(i, m)] += along;
                terms.coriolis[i] += own * qd[m] * k.dot(&pose[i].axis.cross(&w));
            }
        }
        if pose[m].kind == JointKind::Revolute {
            let spin = k * qd[m];
            a += w.cross(&spin);
            w += spin;
        }
    }
}
