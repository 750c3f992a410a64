//! Generalised momentum by recursion, compared with the inertia matrix and Christoffel symbols, which share no code with it.
#![allow(clippy::unwrap_used, reason = "a random arm that cannot be built should stop the test")]
#![allow(clippy::float_cmp, reason = "what is absent, zero, live or constant is promised to the bit")]

use crate::common::moving::{Moving, worst_over_arms};
use crate::common::{along, derivative, relative_error, turns};
use dynamics_core::chapter::lagrange::{coriolis_matrix, generalized_force, gravity};
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::momentum::{GeneralizedMomentum, Momentum};
use dynamics_core::{Dynamics, InverseDynamics, JointKind, Live, Scene, Term};
use nalgebra::SVector;

fn momentum<const N: usize>(case: &Moving<N>, scene: Scene<f64, N>, live: &Live<f64, N>) -> Momentum<f64, N> {
    Dynamics::new(case.model, scene).momentum(&turns(&case.q), &case.q, &case.qd, live)
}

#[test]
fn momentum_is_the_inertia_matrix_times_the_velocity() {
    fn error<const N: usize>(case: &Moving<N>) -> f64 {
        let dynamics = case.dynamics();
        let wanted = mass_matrix(&dynamics, &turns(&case.q), &case.q, &Live::zero()) * SVector::from(case.qd);
        relative_error(&momentum(case, *dynamics.scene(), &Live::zero()).momentum, wanted.as_slice())
    }
    let worst = worst_over_arms!(error);
    println!("{worst:e}");
    assert!(worst < 1e-13, "{worst:e}");
}

#[test]
fn its_rate_is_that_of_christoffel_symbols_weight_and_contact() {
    fn error<const N: usize>(case: &Moving<N>) -> f64 {
        let posture = case.posture();
        let c = coriolis_matrix(&posture, &case.qd);
        let from_velocity = c.transpose() * SVector::from(case.qd);
        let weight = gravity(&posture, &case.gravity);
        let pushed = generalized_force(&posture, &[0.0; N], &case.push());
        let wanted: [f64; N] = core::array::from_fn(|i| from_velocity[i] - weight[i] + pushed[i]);
        // Large terms may cancel: the error is relative to the terms.
        let size =
            (0..N).fold(0.0_f64, |size, i| size.max(from_velocity[i].abs()).max(weight[i].abs()).max(pushed[i].abs()));
        let found = momentum(case, *case.dynamics().scene(), &Live::zero()).rate;
        assert!(found.iter().all(|x| x.is_finite()));
        (0..N).fold(0.0_f64, |worst, i| worst.max((found[i] - wanted[i]).abs())) / size
    }
    let worst = worst_over_arms!(error);
    println!("{worst:e}");
    assert!(worst < 1e-12, "{worst:e}");
}

/// `dp/dt = tau + rate` along a motion, with `tau` from the recursion and `dp/dt` by differences: independent of Lagrange's equations.
#[test]
fn momentum_changes_by_torque_and_rate() {
    fn error<const N: usize>(case: &Moving<N>) -> f64 {
        let dynamics = case.dynamics();
        let at = |t: f64| {
            let (q, qd) = along(&case.q, &case.qd, &case.qdd, t);
            dynamics.momentum(&turns(&q), &q, &qd, &Live::zero())
        };
        let tau = dynamics.inverse_dynamics(&turns(&case.q), &case.q, &case.qd, &case.qdd, &Live::zero());
        let rate = at(0.0).rate;
        let changed: [f64; N] = core::array::from_fn(|i| derivative(|t| at(t).momentum[i]));
        relative_error(&core::array::from_fn::<f64, N, _>(|i| tau[i] + rate[i]), &changed)
    }
    let worst = worst_over_arms!(error);
    println!("{worst:e}");
    assert!(worst < 1e-5, "{worst:e}");
}

#[test]
fn absent_terms_are_zero_live_ones_are_constant_and_velocity_terms_are_always_there() {
    fn error<const N: usize>(case: &Moving<N>) -> f64 {
        let full = *case.dynamics().scene();
        let none = Live::zero();
        let found = momentum(case, full, &none);
        let live = Live {
            gravity: case.gravity,
            payload: case.dynamics().payload_in_last_link(&case.payload),
            tip_wrench: case.contact,
            rotor: case.model.links().map(|link| link.rotor),
        };
        let all_live =
            Scene { gravity: Term::Live, payload: Term::Live, tip_wrench: Term::Live, rotor: Term::Live, ..full };
        assert_eq!(momentum(case, all_live, &live), found);
        for coriolis in [Term::Absent, Term::Constant([0.3; N])] {
            assert_eq!(momentum(case, Scene { coriolis, ..full }, &none), found);
        }
        let absent = Scene {
            gravity: Term::Absent,
            payload: Term::Absent,
            tip_wrench: Term::Absent,
            rotor: Term::Absent,
            ..full
        };
        assert_eq!(momentum(case, absent, &live), momentum(case, all_live, &none));
        // A rotor adds to the momentum of its joint and to nothing else.
        let without = momentum(case, Scene { rotor: Term::Absent, ..full }, &none);
        assert_eq!(without.rate, found.rate);
        let rotors: [f64; N] = core::array::from_fn(|i| found.momentum[i] - without.momentum[i]);
        relative_error(&rotors, &core::array::from_fn::<f64, N, _>(|i| case.model.links()[i].rotor * case.qd[i]))
    }
    let worst = worst_over_arms!(error);
    println!("{worst:e}");
    assert!(worst < 1e-10, "{worst:e}");
}

#[test]
fn the_arms_above_turn_and_slide() {
    fn sliding<const N: usize>(case: &Moving<N>) -> f64 {
        let slides = case.model.links().iter().filter(|link| link.kind == JointKind::Prismatic).count();
        if slides > 1 && slides < N { 1.0 } else { 0.0 }
    }
    assert_eq!(worst_over_arms!(sliding), 1.0);
}
