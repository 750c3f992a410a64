//! The arms in `robots/`, read from their files, compared with Pinocchio (`robots/golden/make.py`).
#![allow(clippy::unwrap_used, reason = "a broken data file should stop the test")]

use dynamics_core::forward_dynamics::forward_dynamics;
use dynamics_core::kinematics::tip_pose;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::regressor::inverse_dynamics_regressor;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Frame, Inertia, InverseDynamics, Live, Scene, Term, Trig, Wrench};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::{Robot, with_dof};
use serde_json::Value;

use crate::common::{files, top};

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    core::array::from_fn(|i| value[i].as_f64().unwrap())
}

/// Largest difference over the largest entry wanted.
fn assert_close(found: &[f64], wanted: &[f64], what: &str) {
    let size = wanted.iter().fold(0.0_f64, |m, x| m.max(x.abs())).max(f64::MIN_POSITIVE);
    for (f, w) in found.iter().zip(wanted) {
        assert!((f - w).abs() <= 1e-11 * size, "{what}: {found:?}, wanted {wanted:?}");
    }
}

fn check<const N: usize>(robot: &Robot, golden: &Value) {
    let model = robot.model::<N>().unwrap();
    let gravity = Vector3::from(numbers::<3>(&golden["gravity"]));
    let dynamics = Dynamics::new(model, Scene::with_gravity(gravity, &model));
    let still = [0.0; N];
    let states = golden["states"].as_array().unwrap();
    assert!(states.len() >= 20);
    for (index, state) in states.iter().enumerate() {
        let [q, qd, qdd, tau_in] = ["q", "qd", "qdd", "tau_in"].map(|key| numbers::<N>(&state[key]));
        let what = |quantity: &str| format!("{} state {index} {quantity}", robot.name);
        let turn = Libm.sin_cos_all(&q);
        let tau = |d: &Dynamics<f64, N>, qd, qdd| d.inverse_dynamics(&turn, &q, qd, qdd, &Live::zero());
        assert_close(&tau(&dynamics, &qd, &qdd), &numbers::<N>(&state["tau"]), &what("tau"));
        assert_close(&tau(&dynamics, &still, &still), &numbers::<N>(&state["gravity"]), &what("gravity"));
        let matrix = mass_matrix(&dynamics, &turn, &q, &Live::zero());
        let wanted: Vec<f64> = (0..N).flat_map(|row| numbers::<N>(&state["M"][row])).collect();
        assert_close(matrix.as_slice(), &wanted, &what("M"));
        let qdd_fd = forward_dynamics(&dynamics, &turn, &q, &qd, &tau_in, &Live::zero()).unwrap();
        assert_close(&qdd_fd, &numbers::<N>(&state["qdd_fd"]), &what("qdd_fd"));
        let w = numbers::<6>(&state["wrench_tip"]);
        let wrench = Wrench { force: Vector3::new(w[0], w[1], w[2]), moment: Vector3::new(w[3], w[4], w[5]) };
        let pushed = Dynamics::new(model, Scene { tip_wrench: Term::Constant(wrench), ..*dynamics.scene() });
        assert_close(&tau(&pushed, &qd, &qdd), &numbers::<N>(&state["tau_wrench"]), &what("tau_wrench"));
        let tip = tip_pose(&model, &turn, &q);
        assert_close(tip.translation.as_slice(), &numbers::<3>(&state["tip_p"]), &what("tip_p"));
    }
}

fn golden(path: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(top(path)).unwrap()).unwrap()
}

fn agrees(name: &str) {
    let robot = Robot::load(&top(&format!("robots/{name}.toml"))).unwrap();
    let golden = golden(&format!("robots/golden/shipped/{name}.json"));
    with_dof!(robot.dof(), N => check::<N>(&robot, &golden));
}

/// Pinocchio's index of each of our parameters: it has `Iyy` before `Ixz`.
const PLACES: [usize; 10] = [0, 1, 2, 3, 4, 5, 7, 6, 8, 9];

/// The ten parameters, in our link's frame, of a body that has only one parameter in Pinocchio's. Pinocchio's joints turn about any axis of
/// their frame, ours about z.
fn in_link(robot: &Robot, link: usize, parameter: usize) -> [f64; 10] {
    let mut unit = [0.0; 10];
    unit[parameter] = 1.0;
    let frame = robot.joints[link].spec.frame;
    if !matches!(frame, Frame::Placement { .. }) {
        return unit;
    }
    let [mass, x, y, z, xx, xy, xz, yy, yz, zz] = unit;
    let body = Inertia {
        mass,
        first_moment: Vector3::new(x, y, z),
        about_origin: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
    };
    let placed = frame.link_from_body();
    body.in_parent(&placed.rotation, &placed.translation).parameters()
}

fn check_columns<const N: usize>(robot: &Robot, golden: &Value) {
    let model = robot.model::<N>().unwrap();
    let gravity = Vector3::from(numbers::<3>(&golden["gravity"]));
    let dynamics = Dynamics::new(model, Scene::with_gravity(gravity, &model));
    for state in golden["states"].as_array().unwrap() {
        let [q, qd, qdd] = ["q", "qd", "qdd"].map(|key| numbers::<N>(&state[key]));
        let found = inverse_dynamics_regressor(&dynamics, &Libm.sin_cos_all(&q), &q, &qd, &qdd, &Live::zero());
        for (link, parameter) in (0..N).flat_map(|link| (0..10).map(move |parameter| (link, parameter))) {
            let of_link = in_link(robot, link, parameter);
            let sum = |row: &[f64; 10]| row.iter().zip(of_link).map(|(y, share)| y * share).sum();
            let column: [f64; N] = core::array::from_fn(|i| sum(&found[i][link]));
            let wanted: [f64; N] =
                core::array::from_fn(|i| state["regressor"][i][10 * link + PLACES[parameter]].as_f64().unwrap());
            let size = wanted.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
            let error = column.iter().zip(wanted).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(error <= 1e-12 * size, "{}, link {link}, {parameter}: {column:?}, {wanted:?}", robot.name);
        }
    }
}

#[test]
fn every_column_of_the_regressor_agrees_with_pinocchio() {
    for name in ["planar2r", "planar3r", "puma560", "rebot_b601_rs", "scara", "stanford", "ur5", "yam"] {
        let robot = Robot::load(&top(&format!("robots/{name}.toml"))).unwrap();
        let golden = golden(&format!("robots/golden/regressor/{name}.json"));
        with_dof!(robot.dof(), N => check_columns::<N>(&robot, &golden));
    }
}

#[test]
fn puma_560_agrees_with_pinocchio() {
    agrees("puma560");
}

#[test]
fn ur5_agrees_with_pinocchio() {
    agrees("ur5");
}

#[test]
fn the_yam_agrees_with_pinocchio() {
    agrees("yam");
}

#[test]
fn the_rebot_agrees_with_pinocchio() {
    agrees("rebot_b601_rs");
}

#[test]
fn the_stanford_arm_agrees_with_pinocchio() {
    agrees("stanford");
}

#[test]
fn the_scara_agrees_with_pinocchio() {
    agrees("scara");
}

#[test]
fn planar_arms_agree_with_pinocchio() {
    agrees("planar2r");
    agrees("planar3r");
}

fn check_with_rotors<const N: usize>(robot: &Robot, golden: &Value) {
    let model = robot.model::<N>().unwrap();
    let gravity = Vector3::from(numbers::<3>(&golden["gravity"]));
    let dynamics = Dynamics::new(model, Scene::with_gravity(gravity, &model));
    for state in golden["states"].as_array().unwrap() {
        let [q, qd, qdd] = ["q", "qd", "qdd"].map(|key| numbers::<N>(&state[key]));
        let turn = Libm.sin_cos_all(&q);
        let found = dynamics.inverse_dynamics(&turn, &q, &qd, &qdd, &Live::zero());
        // Data of arms without rotors have no such block.
        let wanted = state.get("rotor").unwrap_or(state);
        assert_close(&found, &numbers::<N>(&wanted["tau"]), &robot.name);
        let matrix = mass_matrix(&dynamics, &turn, &q, &Live::zero());
        let rows: Vec<f64> = (0..N).flat_map(|row| numbers::<N>(&wanted["M"][row])).collect();
        assert_close(matrix.as_slice(), &rows, &robot.name);
    }
}

/// `robots/golden/shipped` is made from the robot files, so a wrong number in one would go unnoticed. For these three arms there are
/// also reference data made elsewhere, from independent tables.
#[test]
fn arms_that_stand_in_outside_tables_too_are_the_same_arms() {
    for name in ["puma560", "scara", "planar2r"] {
        let robot = Robot::load(&top(&format!("robots/{name}.toml"))).unwrap();
        with_dof!(robot.dof(), N => check_with_rotors::<N>(&robot, &golden(&format!("robots/golden/{name}.json"))));
    }
}

/// An arm added to `robots/` without reference data would go untested.
#[test]
fn every_arm_that_ships_has_reference_data() {
    for path in files(&top("robots"), &["toml"]) {
        let golden = top("robots/golden/shipped").join(path.with_extension("json").file_name().unwrap());
        assert!(golden.is_file(), "no {}", golden.display());
    }
}
