//! Example 337: Christoffel symbols, eq. 12.281-12.283.

use super::support_b::{
    Equations, STATED_2, STATED_3, assert_equal, assert_stated, coupling, difference, larger, mass_matrix_slope,
    posture, states,
};
use crate::common::arms::{arm, vector};
use dynamics_core::chapter::lagrange;
use dynamics_core::{Dynamics, Scene, Term};
use nalgebra::{SMatrix, SVector};

/// `dD_ij/dq_k` as `[k][(i, j)]`.
type Slopes<const N: usize> = [SMatrix<f64, N, N>; N];

fn slopes<const N: usize>(dynamics: &Dynamics<f64, N>, q: &[f64; N]) -> Slopes<N> {
    core::array::from_fn(|k| mass_matrix_slope(dynamics, q, k))
}

/// 12.281
fn christoffel<const N: usize>(slope: &Slopes<N>, i: usize, j: usize, k: usize) -> f64 {
    (slope[k][(i, j)] + slope[j][(i, k)] - slope[i][(j, k)]) / 2.0
}

/// The terms printed in 12.220, 12.238, 12.282 and 12.531, before the sum.
fn printed<const N: usize>(slope: &Slopes<N>, i: usize, j: usize, k: usize) -> f64 {
    slope[k][(i, j)] - slope[i][(j, k)] / 2.0
}

/// `C_ij = sum_k S_ijk qd_k`.
fn matrix<const N: usize>(
    slope: &Slopes<N>,
    qd: &[f64; N],
    symbol: fn(&Slopes<N>, usize, usize, usize) -> f64,
) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| (0..N).map(|k| symbol(slope, i, j, k) * qd[k]).sum())
}

#[test]
fn christoffel_symbols_give_the_velocity_torques() {
    assert_equal("12.281", (arm::<4>(), vector(12.0), states()), |(model, gravity, state)| {
        // Jacobians and transforms describe links only, so rotors are omitted.
        let scene = Scene { rotor: Term::Absent, ..Scene::with_gravity(gravity, &model) };
        let dynamics = Dynamics::new(model, scene);
        let c = matrix(&slopes(&dynamics, &state.q), &state.qd, christoffel);
        let (slopes, symbols) = (slopes(&dynamics, &state.q), lagrange::christoffel(&posture(&dynamics, &state.q)));
        let size = slopes.iter().fold(0.0_f64, |most, slope| most.max(slope.amax()));
        let every = (0..64).map(|n| (n / 16, n / 4 % 4, n % 4));
        let off = every.map(|(i, j, k)| (symbols[i][j][k] - christoffel(&slopes, i, j, k)).abs() / size);
        let equations = Equations { c, ..Equations::of(&dynamics, &state.q, &state.qd) };
        off.fold(equations.error(&dynamics, &state), larger)
    });
}

/// `dD/dt - 2 C` is skew-symmetric with 12.281. With the symbols of 12.282 it is not, although both give the same torques.
#[test]
fn contracted_12_282_is_right_and_its_elements_are_not() {
    let dynamics = super::example_342::stated();
    let slope = slopes(&dynamics, &STATED_3.q);
    let qd = STATED_3.qd;
    let rate: SMatrix<f64, 3, 3> = (0..3).map(|k| slope[k] * qd[k]).sum();
    let [right, wrong] = [christoffel, printed].map(|symbol| matrix(&slope, &qd, symbol));
    let posture = posture(&dynamics, &STATED_3.q);
    let wanted = lagrange::velocity_coupling(&posture, &qd);
    assert!(difference(&wanted, coupling(&dynamics, &STATED_3.q, &qd).as_slice()) < 1e-13);
    assert!(difference(lagrange::coriolis_matrix(&posture, &qd).as_slice(), right.as_slice()) < 1e-13);
    for c in [right, wrong] {
        let torque: [f64; 3] = (c * SVector::from(qd)).into();
        assert!(difference(&torque, &wanted) < 1e-13);
    }
    let unbalanced = |c: SMatrix<f64, 3, 3>| {
        let s = rate - c * 2.0;
        (s + s.transpose()).amax() / rate.amax()
    };
    assert!(unbalanced(right) < 1e-14);
    assert_stated(&[unbalanced(wrong), difference(wrong.as_slice(), right.as_slice())], &[2.0, 0.8368]);
}

/// 12.283 pairs the symbols' indices j, k with velocities k, m. With a free m nothing can be summed; with m = j it is the
/// velocity torque.
#[test]
fn velocities_of_12_283_belong_to_the_symbols_indices() {
    let dynamics = super::example_343::stated();
    let slope = slopes(&dynamics, &STATED_2.q);
    let qd = STATED_2.qd;
    let wanted = lagrange::velocity_coupling(&posture(&dynamics, &STATED_2.q), &qd);
    let sum = |partner: fn(usize, usize) -> usize| -> [f64; 2] {
        core::array::from_fn(|i| {
            (0..4).map(|n| (n / 2, n % 2)).map(|(j, k)| christoffel(&slope, i, j, k) * qd[k] * qd[partner(j, k)]).sum()
        })
    };
    assert!(difference(&sum(|j, _| j), &wanted) < 1e-14);
    // Reading m as k squares each velocity and loses the products.
    assert_stated(&[difference(&sum(|_, k| k), &wanted)], &[2.367]);
}
