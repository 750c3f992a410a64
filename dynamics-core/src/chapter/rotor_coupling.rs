//! Coupling of a rotor's spin with the motion of the link that carries it: the term missing from the usual rotor model
//! (eq. 12.404).
//!
//! The rotor of joint `i` rides on the link before the joint and spins about the joint's axis `k`, `gear` times as fast as the
//! joint turns. With `omega` the angular velocity of the link that carries it, its energy about that axis is
//!
//! ```text
//! 1/2 I_r (gear qd_i + k . omega)^2  =  1/2 gear^2 I_r qd_i^2  +  gear I_r qd_i (k . omega)  +  1/2 I_r (k . omega)^2
//!                                       reflected inertia         coupling                      part of the link
//! ```
//!
//! Eq. 12.404 has only the first part, and so have [`crate::Model`] and its recursions. The last part, together with the rotor's
//! mass and its inertia across the axis, treats the rotor as a rigid piece of the link that carries it. The tensor of that link
//! contains it if the link was weighed or drawn with its motor in place. No tensor contains the coupling.
//!
//! Torques by Lagrange's equation, with `s` the spin in question, `gear qd_i` or `gear qd_i + k . omega`, and `j` a revolute
//! joint before `i`; a prismatic one feels nothing:
//!
//! ```text
//! on joint i    I_r gear (k . alpha)
//! on joint j    I_r (ds/dt (k . k_j) + s k . (k_j x omega))
//! ```
//!
//! `k` turns with `omega`, so `d(k . omega)/dt = k . alpha`; and `d(k . k_j)/dt` less `d(k . omega)/dq_j` is `k . (k_j x omega)`.
//! The second line is the rate of change of the angular momentum `I_r s k`, along joint `j`.
//!
//! The sign of `gear` counts here: it gives the direction in which the rotor turns. [`crate::joint::Rotor::reflected`] loses the sign, so
//! inertia and gear are separate arguments.

use crate::chapter::posture::Posture;
use crate::joint::JointKind;
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// The rotors of an arm. The rotor of joint `i` rides on the link before the joint, the first one on the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotors<S, const N: usize> {
    /// Inertia about the rotor's own axis, kg m^2.
    pub inertia: [S; N],
    /// Rotor turns per joint turn (rad per m), with its sign.
    pub gear: [S; N],
}

/// Presence of the rotors' inertia about their own axes in the links' tensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carried {
    /// In the tensor of the link that carries it: only the coupling is missing.
    ByLink,
    /// Nowhere: `1/2 I_r (k . omega)^2` is missing too.
    ByNone,
}

impl<S: Scalar, const N: usize> Rotors<S, N> {
    /// Energy of the rotors by their reflected inertia alone, J: `1/2 sum_i gear_i^2 I_i qd_i^2` (eq. 12.404). O(N).
    #[must_use]
    pub fn reflected_energy(&self, qd: &[S; N]) -> S {
        let spin: [S; N] = core::array::from_fn(|i| self.gear[i] * qd[i]);
        self.energy(&spin)
    }

    /// Energy of the rotors' spin about their own axes, J: `1/2 sum_i I_i (gear_i qd_i + k_i . omega_{i-1})^2`
    /// (eq. 12.404, completed).
    ///
    /// Energy across those axes and of the rotors' mass belongs to the links. `qd` in rad/s or m/s. O(N).
    #[must_use]
    pub fn complete_energy(&self, posture: &Posture<S, N>, qd: &[S; N]) -> S {
        let carrier = carriers(posture, qd, &[S::zero(); N]);
        let spin: [S; N] =
            core::array::from_fn(|i| self.gear[i] * qd[i] + posture.links[i].axis.dot(&carrier[i].omega));
        self.energy(&spin)
    }

    fn energy(&self, spin: &[S; N]) -> S {
        let twice = (0..N).fold(S::zero(), |sum, i| sum + self.inertia[i] * spin[i] * spin[i]);
        twice * S::literal(0.5)
    }

    /// Joint torques that the reflected inertia alone leaves out, to be added to those of the usual model.
    ///
    /// `extra_i = I_i gear_i (k_i . alpha_{i-1}) + sum_{m > i} I_m (ds_m/dt (k_m . k_i) + s_m k_m . (k_i x omega_{m-1}))`, the
    /// sum for a revolute joint `i` (Lagrange's equation of the completed eq. 12.404)
    ///
    /// | name | quantity | unit | shape |
    /// |---|---|---|---|
    /// | `posture` | the arm at `q` | | |
    /// | `carried` | whether the links' tensors have the rotors in them | | |
    /// | `qd`, `qdd` | joint velocity and acceleration | rad/s, rad/s^2 (m/s, m/s^2) | N |
    /// | return | torque or force | N m, N | N |
    ///
    /// O(N^2); no branch on data, no division.
    #[must_use]
    pub fn extra_torque(&self, posture: &Posture<S, N>, carried: Carried, qd: &[S; N], qdd: &[S; N]) -> [S; N] {
        let carrier = carriers(posture, qd, qdd);
        let mut torque = [S::zero(); N];
        for m in 0..N {
            let (axis, Carrier { omega, alpha }) = (&posture.links[m].axis, &carrier[m]);
            let own = self.gear[m] * self.inertia[m];
            torque[m] += own * axis.dot(alpha);
            let (mut momentum, mut rate) = (own * qd[m], own * qdd[m]);
            if carried == Carried::ByNone {
                momentum += self.inertia[m] * axis.dot(omega);
                rate += self.inertia[m] * axis.dot(alpha);
            }
            for i in 0..m {
                let before = &posture.links[i];
                if before.kind == JointKind::Revolute {
                    torque[i] += rate * axis.dot(&before.axis) + momentum * axis.dot(&before.axis.cross(omega));
                }
            }
        }
        torque
    }
}

/// Angular motion of the body that carries a rotor.
#[derive(Clone, Copy)]
struct Carrier<S> {
    /// Angular velocity, rad/s.
    omega: Vector3<S>,
    /// Angular acceleration, rad/s^2.
    alpha: Vector3<S>,
}

/// The link before each joint; the base does not turn.
fn carriers<S: Scalar, const N: usize>(posture: &Posture<S, N>, qd: &[S; N], qdd: &[S; N]) -> [Carrier<S>; N] {
    let motion = posture.motion(qd, qdd);
    core::array::from_fn(|i| match i.checked_sub(1) {
        Some(before) => Carrier { omega: motion[before].omega, alpha: motion[before].alpha },
        None => Carrier { omega: Vector3::zeros(), alpha: Vector3::zeros() },
    })
}
