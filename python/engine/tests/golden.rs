//! Torques of the core for the tests in Python: `tests/golden/inverse_dynamics.json`.
//!
//! The numbers are written as hexadecimal bits. After a change of the core that is meant to change bits:
//! `GOLDEN=write cargo test -p batch-engine --test golden`.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use dynamics_core::trig::Polynomial;
use dynamics_core::{Dynamics, InverseDynamics, Live, Scene, Trig};
use robot_compiler::{Robot, with_dof};
use std::fmt::Write as _;
use std::path::Path;

const ROBOTS: [&str; 5] = ["planar3r", "puma560", "scara", "stanford", "ur5"];
const STATES: usize = 8;

/// The state's numbers: exact in single precision, so that both precisions get the same ones.
fn number(state: usize, list: usize, joint: usize) -> f64 {
    // The last state is at rest in the zero position.
    if state + 1 == STATES { 0.0 } else { ((state * 131 + list * 37 + joint * 59) % 97) as f64 / 16.0 - 3.0 }
}

fn golden() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let mut rows = Vec::new();
    for name in ROBOTS {
        let robot = Robot::load(&folder.join(name).with_extension("toml")).unwrap();
        with_dof!(robot.dof(), N => {
            let model = robot.model::<N>().unwrap();
            let scene = Scene::with_gravity(robot.gravity(), &model);
            let double = Dynamics::<f64, N>::new(model, scene);
            let single = Dynamics::<f32, N>::new(model.cast(), scene.cast());
            for state in 0..STATES {
                let list = |list: usize| -> [f64; N] { core::array::from_fn(|joint| number(state, list, joint)) };
                let (q, qd, qdd) = (list(0), list(1), list(2));
                let tau = double.inverse_dynamics(&Polynomial.sin_cos_all(&q), &q, &qd, &qdd, &Live::zero());
                let [a, b, c] = [q, qd, qdd].map(|list| list.map(|x| x as f32));
                let tau32 = single.inverse_dynamics(&Polynomial.sin_cos_all(&a), &a, &b, &c, &Live::zero());
                let (tau, tau32) = (tau.map(|x| format!("{:016x}", x.to_bits())), tau32.map(|x| format!("{:08x}", x.to_bits())));
                let mut row = String::new();
                write!(
                    row,
                    "{{\"robot\": {name:?}, \"q\": {q:?}, \"qd\": {qd:?}, \"qdd\": {qdd:?}, \"float64\": {tau:?}, \"float32\": {tau32:?}}}"
                )
                .unwrap();
                rows.push(row);
            }
        });
    }
    format!("[\n{}\n]\n", rows.join(",\n"))
}

#[test]
fn the_golden_torques_are_those_of_the_core() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden/inverse_dynamics.json");
    let golden = golden();
    if std::env::var("GOLDEN").is_ok_and(|value| value == "write") {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, &golden).unwrap();
    }
    assert!(std::fs::read_to_string(&path).unwrap() == golden, "{} differs from the core", path.display());
}
