//! The control laws.

use super::Reference;
use crate::newton_euler::InverseDynamics;
use crate::scalar::Real;
use crate::scene::Live;
use crate::trig::{SinCos, Trig};

/// How torques follow from the reference and the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// `tau = ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q))`: the error obeys `e'' + Kd e' + Kp e = 0`.
    ComputedTorque,
    /// `tau = M0 (Kd (qd_ref - qd) + Kp (q_ref - q))`, with a fixed inertia `M0` per joint: no model in the loop.
    Pd,
    /// [`Law::Pd`] plus the torque that holds the arm still where it is, `ID(q, 0, 0)`.
    PdGravity,
    /// [`Law::Pd`] plus the torque of the reference motion, `ID(q_ref, qd_ref, qdd_ref)`.
    Feedforward,
}

/// Gains of one joint: what makes an error of one joint behave as a mass on a spring with a damper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains<S> {
    /// `Kp = omega^2`, 1/s^2.
    pub position: S,
    /// `Kd = 2 zeta omega`, 1/s.
    pub velocity: S,
    /// `M0`, the inertia that turns an acceleration into a torque in the laws without a model in the loop, kg m^2 or kg.
    pub inertia: S,
}

impl<S: Real> Gains<S> {
    /// From natural frequency (rad/s), damping ratio, and the joint's inertia (kg m^2 or kg).
    #[must_use]
    pub fn new(natural_frequency: f64, damping: f64, inertia: f64) -> Self {
        Self {
            position: S::literal(natural_frequency * natural_frequency),
            velocity: S::literal(2.0 * damping * natural_frequency),
            inertia: S::literal(inertia),
        }
    }
}

/// What a law may read.
pub(super) struct State<'a, S, const N: usize> {
    pub(super) reference: &'a Reference<S, N>,
    pub(super) q: &'a [S; N],
    pub(super) qd: &'a [S; N],
    pub(super) live: &'a Live<S, N>,
}

/// Torques before friction and limits, N m or N.
#[inline]
pub(super) fn torques<S: Real, const N: usize>(
    law: Law,
    gains: &[Gains<S>; N],
    dynamics: &impl InverseDynamics<S, N>,
    trig: &impl Trig<S>,
    state: &State<'_, S, N>,
) -> [S; N] {
    let State { reference, q, qd, live } = state;
    let spring: [S; N] = core::array::from_fn(|i| {
        gains[i].velocity * (reference.qd[i] - qd[i]) + gains[i].position * (reference.q[i] - q[i])
    });
    let weighted = |with: [S; N]| core::array::from_fn(|i| with[i] + gains[i].inertia * spring[i]);
    let zero = [S::zero(); N];
    let turn = |angles: &[S; N]| -> [SinCos<S>; N] { trig.sin_cos_all(angles) };
    match law {
        Law::ComputedTorque => {
            let wanted = core::array::from_fn(|i| reference.qdd[i] + spring[i]);
            dynamics.inverse_dynamics(&turn(q), q, qd, &wanted, live)
        }
        Law::Pd => weighted(zero),
        Law::PdGravity => weighted(dynamics.inverse_dynamics(&turn(q), q, &zero, &zero, live)),
        Law::Feedforward => {
            weighted(dynamics.inverse_dynamics(&turn(&reference.q), &reference.q, &reference.qd, &reference.qdd, live))
        }
    }
}
