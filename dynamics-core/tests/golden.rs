//! External reference data: Pinocchio and a 50-digit computation (`robots/golden/README.md`).
#![allow(clippy::unwrap_used, reason = "a broken data file should stop the test")]

use crate::common::{Golden, cast, numbers, relative_error, square, torque, turns};
use dynamics_core::forward_dynamics::forward_dynamics;
use dynamics_core::kinematics::tip_pose;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::{Dynamics, Live, Model, Real, Scene, Term, Wrench, energy};
use nalgebra::Vector3;
use serde_json::Value;

/// The largest relative error of each quantity over all states.
#[derive(Debug, Default, Clone, Copy)]
struct Errors {
    tau: f64,
    gravity: f64,
    coriolis: f64,
    matrix: f64,
    forward: f64,
    wrench: f64,
    forward_wrench: f64,
    tip: f64,
    energy: f64,
}

fn raise(worst: &mut f64, error: f64) {
    *worst = worst.max(error);
}

/// Every quantity of every state, for one model in one scalar.
fn errors<S: Real + Into<f64>, const N: usize>(golden: &Golden, model: &Model<f64, N>) -> Errors {
    let free = Scene { gravity: Term::Constant(golden.gravity()), ..Scene::free_space() };
    let dynamics = Dynamics::new(model.cast::<S>(), free.cast());
    let weightless = Dynamics::new(model.cast::<S>(), Scene { gravity: Term::Absent, ..free }.cast());
    let still = [0.0; N];
    let mut worst = Errors::default();
    for state in golden.states() {
        let [q, qd, qdd, tau_in] = ["q", "qd", "qdd", "tau_in"].map(|key| numbers::<N>(&state[key]));
        let list = |key: &str| numbers::<N>(&state[key]);
        raise(&mut worst.tau, relative_error(&torque(&dynamics, &q, &qd, &qdd), &list("tau")));
        raise(&mut worst.gravity, relative_error(&torque(&dynamics, &q, &still, &still), &list("gravity")));
        raise(&mut worst.coriolis, relative_error(&torque(&weightless, &q, &qd, &still), &list("coriolis_qd")));
        let matrix = mass_matrix(&dynamics, &turns(&q), &cast(&q), &Live::zero());
        raise(&mut worst.matrix, relative_error(matrix.as_slice(), square::<N>(&state["M"]).as_slice()));
        let qdd_fd = forward(&dynamics, &q, &qd, &tau_in);
        raise(&mut worst.forward, relative_error(&qdd_fd, &list("qdd_fd")));

        let contact = wrench(&state["wrench_tip"]);
        let pushed = Dynamics::new(model.cast::<S>(), Scene { tip_wrench: Term::Constant(contact), ..free }.cast());
        raise(&mut worst.wrench, relative_error(&torque(&pushed, &q, &qd, &qdd), &list("tau_wrench")));
        let qdd_fd = forward(&pushed, &q, &qd, &tau_in);
        raise(&mut worst.forward_wrench, relative_error(&qdd_fd, &list("qdd_fd_wrench")));

        let pose = tip_pose(&model.cast::<S>(), &turns(&q), &cast(&q));
        raise(&mut worst.tip, relative_error(pose.translation.as_slice(), &numbers::<3>(&state["tip_p"])));
        raise(
            &mut worst.tip,
            relative_error(pose.rotation.as_slice(), crate::common::matrix(&state["tip_R"]).as_slice()),
        );

        let kinetic = energy::kinetic(&dynamics, &turns(&q), &cast(&q), &cast(&qd), &Live::zero());
        let potential = energy::potential(&dynamics, &turns(&q), &cast(&q), &Live::zero());
        let wanted = ["kinetic", "potential"].map(|key| state[key].as_f64().unwrap());
        raise(&mut worst.energy, relative_error(&[kinetic, potential], &wanted));
    }
    worst
}

fn forward<S: Real, const N: usize>(dynamics: &Dynamics<S, N>, q: &[f64; N], qd: &[f64; N], tau: &[f64; N]) -> [S; N] {
    forward_dynamics(dynamics, &turns(q), &cast(q), &cast(qd), &cast(tau), &Live::zero()).unwrap()
}

fn wrench(value: &Value) -> Wrench<f64> {
    let w = numbers::<6>(value);
    Wrench { force: Vector3::new(w[0], w[1], w[2]), moment: Vector3::new(w[3], w[4], w[5]) }
}

/// Asserts that in f64 the error of every quantity is below 1e-11.
fn assert_double<const N: usize>(golden: &Golden, model: &Model<f64, N>, name: &str) {
    let e = errors::<f64, N>(golden, model);
    println!("{name} f64 {e:?}");
    for (quantity, error) in [
        ("tau", e.tau),
        ("gravity", e.gravity),
        ("coriolis_qd", e.coriolis),
        ("mass matrix", e.matrix),
        ("forward dynamics", e.forward),
        ("tip wrench", e.wrench),
        ("forward dynamics with tip wrench", e.forward_wrench),
        ("tip pose", e.tip),
        ("energy", e.energy),
    ] {
        assert!(error < 1e-11, "{name} {quantity}: {error:e}");
    }
}

/// Asserts the measured errors of torques, mass matrix and forward dynamics in f32 (`docs/theory/numerics.md` has the greatest). They are pinned
/// from both sides, so that an unexplained improvement is noticed too.
fn assert_single<const N: usize>(golden: &Golden, model: &Model<f64, N>, name: &str, pinned: [f64; 3]) -> Errors {
    let e = errors::<f32, N>(golden, model);
    println!("{name} f32 {e:?}");
    let found = [("torque", e.tau.max(e.wrench)), ("matrix", e.matrix), ("forward", e.forward.max(e.forward_wrench))];
    for ((quantity, error), pinned) in found.into_iter().zip(pinned) {
        assert_pinned(error, pinned, &format!("{name} {quantity}"));
    }
    e
}

fn assert_pinned(error: f64, pinned: f64, what: &str) {
    assert!(error < 1.05 * pinned && error > 0.95 * pinned, "{what}: {error:e}, pinned at {pinned:e}");
}

#[test]
fn planar_2r_agrees() {
    let golden = Golden::load("planar2r");
    assert_double::<2>(&golden, &golden.placed(), "planar2r placed");
    assert_double::<2>(&golden, &golden.classical(), "planar2r DH");
    assert_single::<2>(&golden, &golden.classical(), "planar2r DH", [5.27e-7, 9.43e-8, 8.02e-7]);
}

#[test]
fn puma_560_agrees() {
    let golden = Golden::load("puma560");
    assert_double::<6>(&golden, &golden.placed(), "puma560 placed");
    assert_double::<6>(&golden, &golden.classical(), "puma560 DH");
    assert_single::<6>(&golden, &golden.classical(), "puma560 DH", [7.77e-7, 1.40e-7, 5.36e-7]);
}

#[test]
fn scara_agrees() {
    let golden = Golden::load("scara");
    assert_double::<4>(&golden, &golden.placed(), "scara placed");
    assert_double::<4>(&golden, &golden.classical(), "scara DH");
    let single = assert_single::<4>(&golden, &golden.classical(), "scara DH", [6.76e-7, 1.12e-7, 1.15e-6]);
    // Velocity terms that cancel leave a small sum, so their relative error is larger; the whole torque is not affected.
    assert_pinned(single.coriolis, 1.74e-5, "scara velocity terms");
}

#[test]
fn random_arm_with_arbitrary_axes_agrees() {
    let golden = Golden::load("random6_generic");
    assert!(!golden.has_dh());
    assert_double::<6>(&golden, &golden.placed(), "random6");
    assert_single::<6>(&golden, &golden.placed(), "random6", [4.87e-7, 3.08e-7, 2.02e-6]);
}

#[test]
fn puma_560_with_rotors_agrees() {
    let golden = Golden::load("puma560");
    let model = golden.classical::<6>();
    let dynamics = Dynamics::new(model, Scene::with_gravity(golden.gravity(), &model));
    for state in golden.states() {
        let [q, qd, qdd, tau_in] = ["q", "qd", "qdd", "tau_in"].map(|key| numbers::<6>(&state[key]));
        let rotor = &state["rotor"];
        assert!(relative_error(&torque(&dynamics, &q, &qd, &qdd), &numbers::<6>(&rotor["tau"])) < 1e-11);
        let matrix = mass_matrix(&dynamics, &turns(&q), &q, &Live::zero());
        assert!(relative_error(matrix.as_slice(), square::<6>(&rotor["M"]).as_slice()) < 1e-11);
        assert!(relative_error(&forward(&dynamics, &q, &qd, &tau_in), &numbers::<6>(&rotor["qdd_fd"])) < 1e-11);
    }
}

#[test]
fn a_wrong_parameter_is_noticed() {
    let golden = Golden::load("puma560");
    let model = golden.classical::<6>();
    let mut links = *model.links();
    links[2].inertia.first_moment *= 1.0 + 1e-9;
    let wrong = Model::from_checked(links, *model.tip());
    assert!(errors::<f64, 6>(&golden, &wrong).tau > 1e-11);
}
