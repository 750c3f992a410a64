//! URDF files of other projects, from the package `example-robot-data`, which the set-up unpacks and git does not contain.
//!
//! The tests look for them in `NEWTAU_URDF_DIR`, otherwise in `target/robot-data` of the workspace. Without the files the tests
//! report it and pass, except in the continuous integration.
#![allow(clippy::unwrap_used, reason = "a broken data file should stop the test")]

use dynamics_core::kinematics::tip_pose;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Scene, Trig};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::{Ends, FileError, Robot, with_dof};
use std::path::PathBuf;

use crate::common::{skipped, top};

/// Result for each file if no tip is named: the number of the arm's joints, or the start of the error.
///
/// Two-legged, four-legged and two-armed robots are rejected because of their branches; seven joints are rejected by name.
const EXPECTED: [(&str, Result<usize, &str>); 26] = [
    ("a1_description/urdf/a1.urdf", Err("the tree branches at link \"trunk\"")),
    ("asr_twodof_description/urdf/TwoDofs.urdf", Ok(2)),
    ("baxter_description/urdf/baxter.urdf", Err("the tree branches at link \"torso\"")),
    ("borinot_description/urdf/borinot_flying_arm_2.urdf", Ok(2)),
    // Limits of zero are treated as gaps.
    ("double_pendulum_description/urdf/double_pendulum.urdf", Ok(2)),
    ("double_pendulum_description/urdf/double_pendulum_continuous.urdf", Ok(2)),
    ("finger_edu_description/robots/finger_edu.urdf", Ok(3)),
    ("hextilt_description/urdf/hextilt_flying_arm_5.urdf", Ok(5)),
    ("icub_description/robots/icub.urdf", Err("the tree branches at link")),
    ("iris_description/robots/iris_simple.urdf", Err("the chain has no moving joint")),
    ("kinova_description/robots/kinova.urdf", Ok(6)),
    ("panda_description/urdf/panda.urdf", Err("the tree branches at link \"panda_hand\"")),
    ("pr2_description/urdf/pr2.urdf", Err("the tree branches at link \"torso_lift_link\"")),
    ("so_arm_description/urdf/so100.urdf", Ok(6)),
    ("so_arm_description/urdf/so101.urdf", Ok(6)),
    ("talos_data/robots/talos_left_arm.urdf", Err("the chain has 7 moving joints: arm_left_2_joint, ")),
    ("ur_description/urdf/ur3.urdf", Err("there is no link")),
    ("ur_description/urdf/ur3_gripper.urdf", Ok(6)),
    ("ur_description/urdf/ur3_joint_limited_robot.urdf", Ok(6)),
    ("ur_description/urdf/ur3_robot.urdf", Ok(6)),
    ("ur_description/urdf/ur5_gripper.urdf", Ok(6)),
    ("ur_description/urdf/ur5_joint_limited_robot.urdf", Ok(6)),
    ("ur_description/urdf/ur5_robot.urdf", Ok(6)),
    ("ur_description/urdf/ur10_robot.urdf", Ok(6)),
    ("xarm_description/urdf/xarm7.urdf", Err("the chain has 7 moving joints: joint1, joint2, ")),
    ("z1_description/urdf/z1.urdf", Err("the chain has 7 moving joints: joint1, joint2, ")),
];

/// The folder that contains the `*_description` folders.
fn corpus() -> Option<PathBuf> {
    let root = std::env::var_os("NEWTAU_URDF_DIR").map_or_else(|| top("target/robot-data"), PathBuf::from);
    let inside = root.join("cmeel.prefix/share/example-robot-data/robots");
    let found = [inside, root].into_iter().find(|folder| folder.join("ur_description").is_dir());
    if found.is_none() {
        skipped("no example-robot-data here (NEWTAU_URDF_DIR, or target/robot-data)");
    }
    found
}

fn load(name: &str, tip: Option<&str>) -> Option<Result<Robot, FileError>> {
    Some(Robot::from_urdf(&corpus()?.join(name), Ends { base: None, tip }))
}

#[test]
fn every_file_loads_or_says_why_not() {
    for (name, expected) in EXPECTED {
        let Some(result) = load(name, None) else { return };
        match (result, expected) {
            (Ok(robot), Ok(joints)) => assert_eq!(robot.dof(), joints, "{name}"),
            (Err(error), Err(start)) => {
                assert!(error.problem().starts_with(start), "{error}");
                assert!(error.line_column().is_some(), "{error}");
            }
            (Ok(robot), Err(_)) => assert_eq!(robot.dof(), 0, "{name} was accepted"),
            (Err(error), Ok(_)) => assert_eq!(error.to_string(), "", "{name} was refused"),
        }
    }
}

#[test]
fn a_named_tip_takes_its_chain_out_of_a_tree() {
    let Some(head) = load("pr2_description/urdf/pr2.urdf", Some("head_tilt_link")) else { return };
    let head = head.unwrap();
    let names: Vec<&str> = head.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["torso_lift_joint", "head_pan_joint", "head_tilt_joint"]);
    // The arms are mounted on the torso, so they are carried, and the robot's source text lists them.
    assert!(head.source.contains("held at zero: ") && head.source.contains("r_shoulder_pan_joint"), "{}", head.source);
    let refused = |tip| load("panda_description/urdf/panda.urdf", Some(tip)).unwrap().unwrap_err();
    assert!(refused("panda_link8").problem().starts_with("the chain has 7 moving joints: panda_joint1, "));
    assert_eq!(refused("panda_link9").problem(), "there is no link \"panda_link9\"");
    assert!(refused("panda_link9").expected().contains("did you mean `panda_link"));
}

/// Merged fixed joints, turned inertials and slanted axes, compared with an independent reader and recursion.
#[test]
fn torques_are_those_of_pinocchio() {
    let mut rows = 0;
    for line in include_str!("data/urdf_torques.txt").lines().filter(|line| !line.starts_with('#')) {
        let fields: Vec<&str> = line.split("; ").collect();
        let tip = Some(fields[1]).filter(|tip| *tip != "-");
        let Some(robot) = load(fields[0], tip) else { return };
        let robot = robot.unwrap();
        with_dof!(robot.dof(), N => {
            let [q, qd, qdd, tau]: [[f64; N]; 4] = [2, 3, 4, 5].map(|i| {
                let list: Vec<f64> = fields[i].split(' ').map(|word| word.parse().unwrap()).collect();
                list.try_into().unwrap()
            });
            let model = robot.model::<N>().unwrap();
            let dynamics = Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, 0.0, -9.81), &model));
            let found = dynamics.inverse_dynamics(&Libm.sin_cos_all(&q), &q, &qd, &qdd, &Live::zero());
            let largest = tau.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            for i in 0..N {
                assert!((found[i] - tau[i]).abs() <= 1e-11 * largest, "{} {found:?} {tau:?}", fields[0]);
            }
        });
        rows += 1;
    }
    assert_eq!(rows, 30);
}

/// Two descriptions of one arm: the manufacturer's DH table, and an older ROS description.
#[test]
fn our_ur5_has_the_kinematics_of_the_urdf() {
    let Some(theirs) = load("ur_description/urdf/ur5_robot.urdf", Some("tool0")) else { return };
    let theirs = theirs.unwrap().model::<6>().unwrap();
    let ours = Robot::load(&top("robots/ur5.toml")).unwrap().model::<6>().unwrap();
    // ROS turns the base by half a turn about z.
    let half_turn = Matrix3::from_diagonal(&Vector3::new(-1.0, -1.0, 1.0));
    for k in 0..50 {
        let q = std::array::from_fn(|i| (1.7 * f64::from(k) + 2.3 * i as f64).sin() * 3.0);
        let turn = Libm.sin_cos_all(&q);
        let (a, b) = (tip_pose(&ours, &turn, &q), tip_pose(&theirs, &turn, &q));
        // The URDF prints right angles with twelve digits.
        assert!((half_turn * a.translation - b.translation).amax() < 1e-10, "{q:?}");
        assert!((half_turn * a.rotation - b.rotation).amax() < 1e-10, "{q:?}");
    }
}
