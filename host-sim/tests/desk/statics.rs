//! `statics` compared with the dynamics of the same arm and with closed forms, and as used by a person.
#![allow(clippy::float_cmp, reason = "a joint that is held stays where it is")]

use crate::compare_output;
use crate::program::{at_its_fixtures, told};
use crate::reference::relative;
use dynamics_core::Model;
use dynamics_core::kinematics::tip_pose;
use dynamics_core::trig::{Libm, Trig};
use nalgebra::Vector3;
use robot_compiler::{Robot, with_dof};
use serde_json::Value;
use std::path::{Path, PathBuf};
use studies::dynamics;
use studies::options::GravityArgs;
use studies::statics::WrenchFrame;
use studies::statics::{StaticLoads, StaticsRequest, answer};

const PLANAR: &str = "tests/fixtures/planar.toml";

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn at(q: &[f64]) -> StaticsRequest {
    StaticsRequest { q: Some(q.to_vec()), gravity: towards([0.0, -9.81, 0.0]), ..StaticsRequest::default() }
}

fn towards(gravity: [f64; 3]) -> GravityArgs {
    GravityArgs { gravity: Some(gravity.into()) }
}

fn ask(robot: &Robot, question: &StaticsRequest) -> StaticLoads {
    answer(robot, question, WrenchFrame::Link).unwrap()
}

fn planar(question: &StaticsRequest) -> StaticLoads {
    ask(&Robot::load(&here(PLANAR)).unwrap(), question)
}

/// Torques from `dynamics` for the same arm. It shares no code with statics except the robot file's reader.
fn torques(robot: &Robot, question: &StaticsRequest) -> Vec<f64> {
    let same = dynamics::DynamicsRequest {
        q: question.q.clone().unwrap(),
        qd: None,
        qdd: None,
        tau: None,
        wrench_tip: question.tip_wrench.clone(),
        gravity: question.gravity.gravity.clone(),
    };
    with_dof!(robot.dof(), N => dynamics::answer::<f64, N>(&robot.model::<N>().unwrap(), &[0.0, 0.0, -9.81], &same))
        .unwrap()
        .tau
}

#[test]
fn holding_torques_are_those_of_dynamics_at_rest() {
    let mut worst = 0.0_f64;
    for name in ["puma560", "ur5", "stanford", "scara", "planar2r", "planar3r"] {
        let robot = Robot::load(&here(&format!("../robots/{name}.toml"))).unwrap();
        for part in [0.2, 0.55, 0.8] {
            let inside = |(low, high): (f64, f64)| low + part * (high - low);
            let q: Vec<f64> = robot.joints.iter().map(|joint| inside(joint.spec.limits.position)).collect();
            let tip_wrench = Some(vec![5.0, -8.0, 11.0, 0.4, 0.9, -0.7]);
            let question = StaticsRequest { tip_wrench, gravity: towards([1.0, 2.0, -9.5]), ..at(&q) };
            worst = worst.max(relative(&ask(&robot, &question).tau, &torques(&robot, &question)));
        }
    }
    // Measured: 8.2e-16.
    assert!(worst < 2e-15 && worst > 0.0, "{worst:e}");
}

#[test]
fn a_load_is_a_tip_wrench_of_its_weight_and_in_base_axes_the_base_carries_it_all() {
    let robot = Robot::load(&here("../robots/puma560.toml")).unwrap();
    let q = [0.3, 0.9, -1.6, 0.4, 0.5, 0.2];
    let floor = StaticsRequest { gravity: towards([0.0, 0.0, -9.81]), ..at(&q) };
    let place = Vector3::new(0.02, -0.05, 0.1);
    let loaded = StaticsRequest { load: Some(vec![2.0, place.x, place.y, place.z]), ..floor.clone() };
    let model: Model<f64, 6> = robot.model().unwrap();
    let tip = tip_pose(&model, &Libm.sin_cos_all(&q), &q);
    let weight = tip.rotation.transpose() * Vector3::new(0.0, 0.0, -2.0 * 9.81);
    let moment = place.cross(&weight);
    let pushed = StaticsRequest {
        tip_wrench: Some([weight, moment].map(|v| v.iter().copied().collect::<Vec<_>>()).concat()),
        ..floor.clone()
    };
    assert!(relative(&ask(&robot, &loaded).tau, &ask(&robot, &pushed).tau) < 1e-14);

    let base = answer(&robot, &loaded, WrenchFrame::Base).unwrap();
    let mass: f64 = robot.joints.iter().map(|joint| joint.spec.body.mass).sum::<f64>() + robot.tool.body.mass + 2.0;
    assert!(relative(&base.joints[0].force, &[0.0, 0.0, 9.81 * mass]) < 1e-14, "{:?}", base.joints[0]);
    for (a, b) in base.joints.iter().zip(&ask(&robot, &loaded).joints) {
        let sizes = |joint: &studies::statics::JointLoad| {
            [joint.actuator, joint.radial, joint.axial.unwrap_or(0.0), joint.tilting, joint.twisting.unwrap_or(0.0)]
        };
        assert!(relative(&sizes(a), &sizes(b)) < 1e-13, "{a:?} {b:?}");
    }
}

/// As in exercise 33: the second joint at 45 degrees, the first one free.
#[test]
fn the_posture_of_least_potential_is_the_one_that_hangs_and_needs_no_shoulder() {
    let elbow = core::f64::consts::FRAC_PI_4;
    let held = |what: &str| StaticsRequest {
        minimise: Some(what.to_owned()),
        hold: vec!["elbow".to_owned()],
        ..at(&[0.5, elbow])
    };
    // V = g (a sin q1 + b sin(q1 + q2)), least with the whole arm's mass centre below the shoulder.
    let (a, b) = (2.0 * 0.5 + 1.5 * 1.0, 1.5 * 0.4);
    let angle = -core::f64::consts::FRAC_PI_2 - (b * elbow.sin()).atan2(a + b * elbow.cos());
    let least = -9.81 * (a * a + b * b + 2.0 * a * b * elbow.cos()).sqrt();

    let potential = planar(&held("potential"));
    assert!((potential.q[0] - angle).abs() < 1e-7, "{:?} {angle}", potential.q);
    assert_eq!(potential.q[1], elbow);
    assert!((potential.potential / least - 1.0).abs() < 1e-14);
    assert!(potential.tau[0].abs() < 1e-6, "the slope of V: {:?}", potential.tau);

    // Hanging or upright, the shoulder's torque is zero, and the sum of squares is least there too. The elbow's torque varies.
    let shoulder = planar(&held("shoulder"));
    assert!(shoulder.tau[0].abs() < 1e-6, "{:?}", shoulder.tau);
    assert_eq!(shoulder.minimised.as_ref().map(|m| m.what.as_str()), Some("shoulder"));
    assert_eq!(planar(&held("1")), shoulder, "by number");

    // Q1^2 + Q2^2 along the first joint, on a grid with steps of 1e-5 rad.
    let total = planar(&held("total"));
    let squares = |q1: f64| {
        let second = 9.81 * b * (q1 + elbow).cos();
        let first = 9.81 * a * q1.cos() + second;
        first * first + second * second
    };
    let grid = (-300_000..=300_000).map(|k| squares(f64::from(k) * 1e-5)).fold(f64::INFINITY, f64::min);
    let value = total.minimised.unwrap().value;
    assert!(value <= grid && value > grid - 1e-6, "{value} {grid}");
    assert!((squares(total.q[0]) / value - 1.0).abs() < 1e-12);
}

#[test]
fn a_free_search_finds_the_hanging_arm_and_the_same_one_every_time() {
    let free = |what: &str| StaticsRequest { q: None, minimise: Some(what.to_owned()), ..at(&[]) };
    let hanging = planar(&free("potential"));
    assert!(relative(&hanging.q, &[-core::f64::consts::FRAC_PI_2, 0.0]) < 1e-7, "{:?}", hanging.q);
    assert_eq!(planar(&free("potential")), hanging);
    assert!(planar(&free("total")).minimised.unwrap().value < 1e-10);

    // Held straight up or straight down, a Puma needs no torque, except in its wrist, whose masses almost balance.
    let puma = Robot::load(&here("../robots/puma560.toml")).unwrap();
    let floor = StaticsRequest { gravity: towards([0.0, 0.0, -9.81]), ..free("total") };
    let found = ask(&puma, &floor);
    assert!(found.minimised.unwrap().value < 1e-6, "{:?}", found.tau);
    for (q, joint) in found.q.iter().zip(&puma.joints) {
        let (low, high) = joint.spec.limits.position;
        assert!((low..=high).contains(q), "{}: {q}", joint.name);
    }
}

#[test]
fn a_joint_that_slides_without_limits_cannot_be_searched() {
    let text = r#"
name = "slider"
[[joint]]
name = "rail"
type = "prismatic"
dh = { a = 0.0, alpha = 0.0, d = 0.0, theta = 0.0 }
mass = 1.0
com = [0.0, 0.0, 0.1]
"#;
    let robot = Robot::from_toml_str(text, "slider.toml").unwrap();
    let search = StaticsRequest { minimise: Some("potential".to_owned()), ..at(&[0.0]) };
    let report = answer(&robot, &search, WrenchFrame::Link).unwrap_err().report().to_string();
    assert!(report.contains("joint 1, rail, slides without limits"), "{report}");
    let held = StaticsRequest { hold: vec!["rail".to_owned()], ..search };
    assert!(ask(&robot, &held).q == [0.0]);
}

fn command(arguments: &[&str]) -> (i32, String, String) {
    told(at_its_fixtures().args(arguments).output().unwrap())
}

#[test]
fn the_table_and_the_json_say_the_same() {
    let (code, table, error) =
        command(&["model", "statics", PLANAR, "--q", "0.5,-1", "--gravity", "0,-9.81,0", "--load", "1"]);
    assert_eq!((code, error.as_str()), (0, ""));
    for word in ["planar: at rest", "shoulder", "elbow", "actuator", "radial", "tilting", "potential energy"] {
        assert!(table.contains(word), "{word} in {table}");
    }
    let (_, json, _) =
        command(&["model", "statics", PLANAR, "--q", "0.5,-1", "--gravity", "0,-9.81,0", "--load", "1", "--json"]);
    let json: Value = serde_json::from_str(&json).unwrap();
    let question = StaticsRequest { load: Some(vec![1.0]), ..at(&[0.5, -1.0]) };
    assert_eq!(json, serde_json::to_value(planar(&question)).unwrap());
    assert!(json.get("minimised").is_none() && json["joints"][1]["twisting"].is_null());
}

#[test]
fn bad_questions_are_named_with_what_was_expected() {
    let cases: [&[&str]; 15] = [
        &[],
        &["--q", "0"],
        &["--q", "0,4"],
        &["--q", "-3.1,0"],
        &["--q", "0,NaN"],
        &["--q", "0,x"],
        &["--q", "0,0", "--gravity", "0,-9.81"],
        &["--q", "0,0", "--load", "-1"],
        &["--q", "0,0", "--load", "1,2"],
        &["--q", "0,0", "--tip-wrench", "1,2,3"],
        &["--q", "0,0", "--tip-wrench", "1e308,1e308,1e308,1e308,1e308,1e308"],
        &["--minimise", "wrist"],
        &["--minimise", "total", "--hold", "elbow"],
        &["--q", "0,0", "--hold", "elbow"],
        &["--q", "0,0", "--minimise", "total", "--hold", "3"],
    ];
    let refused = cases.map(|arguments| {
        let (code, out, error) = command(&[&["model", "statics", PLANAR], arguments].concat());
        assert_eq!(out, "");
        format!("{}\nexit code {code}\n{error}", arguments.join(" "))
    });
    compare_output("bad_questions_are_named_with_what_was_expected", refused.join("\n"));
}
