//! A URDF written from a robot file contains the same arm: read back, it gives the same torques.
#![allow(clippy::unwrap_used, reason = "a robot that cannot be handled should stop the test")]
#![allow(clippy::float_cmp, reason = "numbers from a file must come through unchanged")]

use crate::common::{files, top};
use dynamics_core::kinematics::tip_pose;
use dynamics_core::model::Placement;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Scene, Trig};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::emit::robot_file;
use robot_compiler::emit::urdf::{LinkTree, urdf};
use robot_compiler::{Ends, Robot, UrdfArm, with_dof};
use std::path::PathBuf;

/// Every shipped arm, with its file.
fn shipped() -> Vec<(PathBuf, Robot)> {
    let folders = ["robots", "robots/chapter12", "robots/examples"];
    let all = folders.iter().flat_map(|folder| files(&top(folder), &["toml"]));
    // Linkages are in the same folder, but are not arms.
    let arms: Vec<_> = all.filter_map(|path| Robot::load(&path).ok().map(|robot| (path, robot))).collect();
    assert!(arms.len() >= 30, "{} arms", arms.len());
    arms
}

fn read_back(text: &str) -> UrdfArm {
    UrdfArm::from_urdf_str(text, "exported.urdf", Ends::default()).unwrap()
}

/// States of an arm, the same in every run.
fn states<const N: usize>() -> [[[f64; N]; 3]; 12] {
    core::array::from_fn(|k| {
        let wave = |i: usize, rate: f64, size: f64| size * libm::sin(rate * (k * N + i + 1) as f64);
        [
            core::array::from_fn(|i| wave(i, 1.7, 2.9)),
            core::array::from_fn(|i| wave(i, 2.3, 3.1)),
            core::array::from_fn(|i| wave(i, 3.1, 8.0)),
        ]
    })
}

/// Largest difference of two lists over the largest entry of the first, or over 1.
fn off(a: &[f64], b: &[f64]) -> f64 {
    let size = a.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
    a.iter().zip(b).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs())) / size
}

fn worst_torque<const N: usize>(one: &Robot, other: &Robot) -> f64 {
    let gravity = Vector3::new(1.3, -2.1, -9.81);
    let [one, other] = [one, other].map(|robot| {
        let model = robot.model::<N>().unwrap();
        Dynamics::new(model, Scene::with_gravity(gravity, &model))
    });
    states::<N>().iter().fold(0.0, |worst: f64, [q, qd, qdd]| {
        let turn = Libm.sin_cos_all(q);
        let [a, b] = [&one, &other].map(|dynamics| dynamics.inverse_dynamics(&turn, q, qd, qdd, &Live::zero()));
        worst.max(off(&a, &b))
    })
}

#[test]
fn every_shipped_arm_asks_for_the_same_torques_after_its_way_through_a_urdf_and_an_import() {
    for (path, robot) in shipped() {
        let arm = read_back(&urdf(&robot));
        let imported = Robot::from_toml_str(&robot_file(&arm), "imported.toml").unwrap();
        for other in [&arm.robot, &imported] {
            let worst = with_dof!(robot.dof(), N => worst_torque::<N>(&robot, other));
            assert!(worst < 1e-12, "{}: {worst:e}", path.display());
            assert_eq!((&robot.name, &robot.allow_unphysical), (&other.name, &other.allow_unphysical));
            for (joint, other) in robot.joints.iter().zip(&other.joints) {
                let (spec, found) = (joint.spec, other.spec);
                assert_eq!((&joint.name, spec.kind), (&other.name, found.kind));
                assert_eq!(
                    (spec.limits.position, spec.limits.velocity),
                    (found.limits.position, found.limits.velocity)
                );
                assert_eq!(spec.limits.torque, found.limits.torque);
                assert_eq!(spec.rotor.reflected(), found.rotor.reflected(), "{}", path.display());
                let friction = joint.friction.filter(|friction| friction.viscous > 0.0 || friction.coulomb > 0.0);
                assert_eq!(friction, other.friction);
            }
        }
    }
}

/// A negative control: the bound above distinguishes arms whose numbers differ in the eighth digit.
#[test]
fn a_mass_that_is_off_by_a_hundred_millionth_is_seen() {
    let robot = Robot::load(&top("robots/ur5.toml")).unwrap();
    let mut other = read_back(&urdf(&robot)).robot;
    other.joints[2].spec.body.mass *= 1.0 + 1e-8;
    assert!(worst_torque::<6>(&robot, &other) > 1e-12);
}

fn tip<const N: usize>(tree: &LinkTree, robot: &Robot) {
    let model = robot.model::<N>().unwrap();
    for [q, _, _] in states::<N>() {
        let all = q.into_iter().chain([0.0]);
        let base = Placement { rotation: Matrix3::identity(), translation: Vector3::zeros() };
        let found = tree.joints.iter().zip(all).fold(base, |place, (joint, q)| {
            let next = joint.place(q);
            Placement {
                rotation: place.rotation * next.rotation,
                translation: place.translation + place.rotation * next.translation,
            }
        });
        let wanted = tip_pose(&model, &Libm.sin_cos_all(&q), &q);
        let worst = off(wanted.translation.as_slice(), found.translation.as_slice())
            .max(off(wanted.rotation.as_slice(), found.rotation.as_slice()));
        assert!(worst < 1e-13, "{}: {worst:e}", robot.name);
    }
}

#[test]
fn the_frames_of_the_tree_lead_to_the_tip_that_the_model_has() {
    for (_, robot) in shipped() {
        with_dof!(robot.dof(), N => tip::<N>(&LinkTree::new(&robot), &robot));
    }
}

#[test]
fn links_of_the_tree_are_those_of_the_urdf() {
    for (_, robot) in shipped() {
        let (tree, arm) = (LinkTree::new(&robot), read_back(&urdf(&robot)));
        assert_eq!((&tree.base, &tree.joints.last().unwrap().child), (&arm.base, &arm.tip));
        let moving: Vec<&String> = tree.joints[..robot.dof()].iter().map(|joint| &joint.child).collect();
        assert_eq!(moving, arm.links.iter().map(|links| &links[0]).collect::<Vec<_>>());
    }
}

#[test]
fn names_with_the_letters_of_xml_and_names_that_meet_come_through() {
    let toml = r#"
        name = "a <b> & \"c\""
        allow_unphysical = "because <x> & 'y'"
        [[joint]]
        name = "tip_joint"
        type = "prismatic"
        dh = { a = 0.1, alpha = 0.3, d = 0.2, theta = 0.4 }
        mass = 1.0
        com = [0.1, 0.2, -0.1]
        [[joint]]
        name = "<\"&>"
        type = "revolute"
        mdh = { a = 0.1, alpha = 0.3, d = 0.2, theta = 0.4 }
        mass = 1.0
        com = [0.1, 0.2, -0.1]
        rotor = { inertia = 1e-5, gear = -50.0 }
        [tool]
        placement = { xyz = [0.1, 0.0, 0.2], rpy = [0.1, 0.2, 0.3] }
        mass = 0.5
        com = [0.0, 0.0, 0.1]
    "#;
    let robot = Robot::from_toml_str(toml, "odd.toml").unwrap();
    let text = urdf(&robot);
    assert!(text.contains("version=\"1.2\""), "no limits at all on a joint that slides");
    let found = read_back(&text);
    assert_eq!((&found.robot.name, &found.robot.allow_unphysical), (&robot.name, &robot.allow_unphysical));
    assert_eq!(found.robot.joints[1].name, "<\"&>");
    assert_eq!(found.robot.joints[1].spec.rotor, robot.joints[1].spec.rotor);
    assert!(worst_torque::<2>(&robot, &found.robot) < 1e-13);
}

#[test]
fn a_rotor_that_is_wrong_is_refused_at_its_place() {
    let robot = Robot::load(&top("robots/puma560.toml")).unwrap();
    let text = urdf(&robot);
    let start = text.find("<drake:rotor_inertia").unwrap();
    let element = &text[start..start + text[start..].find("/>").unwrap() + 2];
    let refused = |with: &str| {
        let text = text.replacen(element, with, 1);
        Robot::from_urdf_str(&text, "arm.urdf", Ends::default()).unwrap_err().to_string()
    };
    let negative = refused("<drake:rotor_inertia value=\"-1\"/>");
    assert!(negative.contains("joint 1 (waist).rotor_inertia") && negative.contains("found -1"), "{negative}");
    assert!(refused("<drake:rotor_inertia value=\"x\"/>").contains("found \"x\""));
    assert!(refused("<drake:rotor_inertia/>").contains("missing"));
}
