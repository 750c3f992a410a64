//! Example 338: no gravity and no contact, eq. 12.284-12.285.

use super::support_b::{
    Equations, STATED_3, State, assert_equal, assert_stated, difference, floating, larger, mass_matrix_slope, posture,
    states,
};
use crate::common::arms::arm;
use crate::common::{torque, turns};
use dynamics_core::chapter::lagrange;
use dynamics_core::{Dynamics, Live, Scene, Wrench, energy, forward_dynamics};
use nalgebra::{SMatrix, SVector, Vector3};

/// Christoffel symbols of the first kind, `[i][(l, m)]` (eq. 12.281).
fn first_kind<const N: usize>(dynamics: &Dynamics<f64, N>, q: &[f64; N]) -> [SMatrix<f64, N, N>; N] {
    let slope: [SMatrix<f64, N, N>; N] = core::array::from_fn(|k| mass_matrix_slope(dynamics, q, k));
    core::array::from_fn(|i| SMatrix::from_fn(|l, m| (slope[m][(i, l)] + slope[l][(i, m)] - slope[i][(l, m)]) / 2.0))
}

/// `Gamma^i_lm qd_l qd_m`
fn contracted<const N: usize>(symbols: &[SMatrix<f64, N, N>; N], qd: &[f64; N]) -> [f64; N] {
    let qd = SVector::from(*qd);
    symbols.map(|symbol| (symbol * qd).dot(&qd))
}

/// The core's equations by Jacobians, without gravity and contact; equal to the recursion's up to rounding.
fn by_lagrange(free: &Dynamics<f64, 3>, State { q, qd, qdd }: &State<3>) -> [f64; 3] {
    let found = lagrange::inverse_dynamics(&posture(free, q), qd, qdd, &Vector3::zeros(), &Wrench::zero());
    assert!(difference(&found, &torque::<f64, 3>(free, q, qd, qdd)) < 1e-12);
    found
}

/// 12.284: the Lagrangian is the kinetic energy.
#[test]
fn lagrangian_is_12_284() {
    assert_equal("12.284", (arm::<4>(), states()), |(model, state): (_, State<4>)| {
        let dynamics = Dynamics::new(model, Scene::free_space());
        let d = Equations::of(&dynamics, &state.q, &state.qd).d;
        let qd = SVector::from(state.qd);
        let found = energy::kinetic(&dynamics, &turns(&state.q), &state.q, &state.qd, &Live::zero());
        let weight = energy::potential(&dynamics, &turns(&state.q), &state.q, &Live::zero());
        let lagrangian = lagrange::lagrangian(&posture(&dynamics, &state.q), &state.qd, &Vector3::zeros());
        let wanted = [(d * qd).dot(&qd) / 2.0];
        larger(difference(&[found - weight], &wanted), difference(&[lagrangian], &wanted))
    });
}

/// 12.285 corrected: row `i` is `D_ij qdd_j + Gamma^i_lm qd_l qd_m`. If `D_ij` is factored out, the symbols must be of the second
/// kind, `D_ij (qdd_j + Gamma2^j_lm qd_l qd_m)` with `Gamma2 = D^-1 Gamma`.
#[test]
fn equations_are_the_corrected_12_285() {
    let free = floating(&super::example_342::stated());
    assert_equal("12.285", states::<3>(), |State { q, qd, qdd }| {
        let d = Equations::of(&free, &q, &qd).d;
        let contracted = contracted(&first_kind(&free, &q), &qd);
        let second_kind = forward_dynamics::solve(&d, &contracted).unwrap();
        let found = SVector::from(by_lagrange(&free, &State { q, qd, qdd }));
        let first = d * SVector::from(qdd) + SVector::from(contracted);
        let second = d * (SVector::from(qdd) + SVector::from(second_kind));
        let size = d.amax() * 10.0;
        ((found - first).amax() / size).max((found - second).amax() / size)
    });
}

/// As printed, it is summed over `i` and gives one number for all joints. Even row by row and with corrected indices, symbols of the first
/// kind inside the bracket do not give a torque.
#[test]
fn printed_12_285_is_wrong() {
    let free = floating(&super::example_342::stated());
    let State { q, qd, qdd } = STATED_3;
    let d = Equations::of(&free, &q, &qd).d;
    let wanted = by_lagrange(&free, &STATED_3);
    let contracted = contracted(&first_kind(&free, &q), &qd);
    let total: f64 =
        (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).map(|(i, j)| d[(i, j)] * (qdd[i] + contracted[j])).sum();
    let rows: [f64; 3] = (d * (SVector::from(qdd) + SVector::from(contracted))).into();
    assert_stated(&[difference(&[total; 3], &wanted), difference(&rows, &wanted)], &[1.084, 0.1246]);
}
