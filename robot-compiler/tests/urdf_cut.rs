//! Arms cut out of a URDF with branches, and the robot files written from them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test file that cannot be handled should stop the test")]
#![allow(clippy::float_cmp, reason = "numbers from a file must come through unchanged")]

use dynamics_core::kinematics::tip_pose;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Frame, InverseDynamics, JointSpec, Live, Scene, Trig};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::emit::robot_file;
use robot_compiler::{Ends, FileError, Robot, UrdfArm, with_dof};
use std::path::Path;

const GRIPPER: &str = include_str!("data/gripper.urdf");
const TWO: &str = include_str!("data/two.urdf");

fn cut(base: Option<&str>, tip: &str) -> Robot {
    Robot::from_urdf_str(GRIPPER, "gripper.urdf", Ends { base, tip: Some(tip) }).unwrap()
}

fn refused(base: Option<&str>, tip: Option<&str>) -> FileError {
    Robot::from_urdf_str(GRIPPER, "gripper.urdf", Ends { base, tip }).unwrap_err()
}

fn names(robot: &Robot) -> Vec<&str> {
    robot.joints.iter().map(|joint| joint.name.as_str()).collect()
}

fn place(spec: &JointSpec) -> (Matrix3<f64>, Vector3<f64>) {
    let Frame::Placement { rotation, translation, .. } = spec.frame else { unreachable!("a URDF has placements") };
    (rotation, translation)
}

fn import(file: &Path, ends: Ends<'_>) -> (Robot, Robot) {
    let arm = UrdfArm::load(file, ends).unwrap();
    let text = robot_file(&arm);
    let read = Robot::from_toml_str(&text, "arm.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    (arm.robot, read)
}

#[test]
fn a_base_leaves_out_what_is_above_it() {
    let (whole, upper) = (cut(None, "palm"), cut(Some("link3"), "palm"));
    assert_eq!(names(&whole), ["turn", "lift", "bend", "roll", "pitch", "yaw"]);
    assert_eq!(upper.joints, whole.joints[3..]);
    assert_eq!(upper.tool, whole.tool);
    assert!(upper.source.contains("chain from link3 to palm"), "{}", upper.source);
    // If the base is a link between two fixed joints, the placement is that of the second joint alone.
    let from_spacer = cut(Some("spacer"), "palm");
    assert_eq!(names(&from_spacer), ["roll", "pitch", "yaw"]);
    assert_eq!(place(&from_spacer.joints[0].spec).1, Vector3::new(0.06, -0.06, 0.0));
    assert_eq!(from_spacer.joints[1..], upper.joints[1..]);
    // The root as base gives the same arm as no base; above it only fixed joints are left out.
    assert_eq!(cut(Some("world"), "palm").joints, whole.joints);
    assert_eq!(
        place(&cut(Some("stand"), "palm").joints[0].spec),
        (Matrix3::identity(), Vector3::new(0.0, 0.0, 0.0834))
    );
}

#[test]
fn ends_that_make_no_chain_are_refused_with_the_links_to_take() {
    let branched = refused(None, None);
    assert!(branched.expected().contains("`--tip LINK` (in a scene: `tip`, `base`)"), "{}", branched.expected());
    assert!(
        branched.expected().ends_with("the tips: palm (6 joints), finger_left (7 joints), finger_right (7 joints)"),
        "{}",
        branched.expected()
    );
    // Without a named tip, only the branches below the base count.
    assert!(refused(Some("palm"), None).expected().contains("tips: finger_left (1 joint), finger_right (1 joint)"));
    let unknown = refused(Some("lnk3"), Some("palm"));
    assert_eq!((unknown.field(), unknown.problem()), ("base", "there is no link \"lnk3\""));
    assert!(unknown.expected().ends_with("did you mean `link3`?"), "{}", unknown.expected());
    let unknown = refused(None, Some("plam"));
    assert_eq!(unknown.field(), "tip");
    assert!(unknown.expected().ends_with("did you mean `palm`?"), "{}", unknown.expected());
    let beside = refused(Some("finger_left"), Some("palm"));
    assert_eq!(beside.problem(), "\"finger_left\" is not on the way from the root to the tip \"palm\"");
    assert!(beside.expected().starts_with("a link above the tip: flange, link5, "), "{}", beside.expected());
    assert_eq!(
        beside.line_column().map(|(line, _)| GRIPPER.lines().nth(line - 1)),
        Some(Some("  <link name=\"finger_left\">"))
    );
    let long = refused(None, Some("finger_left"));
    assert!(long.problem().starts_with("the chain has 7 moving joints: turn, "), "{long}");
    assert!(long.expected().contains("`--tip flange`") && long.expected().contains("`--base link1`"));
    for (base, tip) in [(None, "flange"), (Some("link1"), "palm"), (Some("flange"), "finger_left")] {
        assert!(cut(base, tip).dof() <= 6);
    }
    let none = refused(Some("flange"), Some("palm"));
    assert_eq!(none.problem(), "the chain has no moving joint");
    assert!(none.expected().contains("`--base LINK` and `--tip LINK`"), "{}", none.expected());
}

#[test]
fn ends_of_a_toml_robot_are_refused() {
    let path = crate::common::top("robots/planar2r.toml");
    for (end, ends) in [("tip", Ends::tip("x")), ("base", Ends { base: Some("x"), tip: None })] {
        let error = Robot::load_between(&path, ends).unwrap_err();
        assert_eq!((error.field(), error.problem()), (end, "given for a TOML robot, which has one chain only"));
    }
    assert_eq!(UrdfArm::load(&path, Ends::default()).unwrap_err().expected(), "a URDF file: .urdf or .xml");
}

#[test]
fn a_moved_link_without_inertial_is_judged_with_what_is_fixed_to_it() {
    // The flange of the gripper has no mass; the palm and the fingers on it have.
    let mass = cut(None, "palm").joints[5].spec.body.mass;
    assert!((mass - 0.47).abs() < 1e-15, "{mass}");
    let start = GRIPPER.find("<link name=\"palm\">").unwrap() + "<link name=\"palm\">".len();
    let end = start + GRIPPER[start..].find("</link>").unwrap();
    let light = format!("{}{}", &GRIPPER[..start], &GRIPPER[end..]).replace("value=\"0.06\"", "value=\"0\"");
    let light = ["2e-5", "8e-6"].iter().fold(light, |text, moment| text.replace(&format!("\"{moment}\""), "\"0\""));
    let error = Robot::from_urdf_str(&light, "light.urdf", Ends::tip("palm")).unwrap_err();
    assert_eq!(error.field(), "link flange.inertial");
    assert!(error.problem().ends_with("and nothing fixed to it has a mass"), "{error}");
}

#[test]
fn an_imported_arm_has_the_dynamics_of_the_urdf() {
    let mut furthest = 0.0_f64;
    for (file, ends) in [
        ("tests/data/gripper.urdf", Ends::tip("palm")),
        ("tests/data/gripper.urdf", Ends { base: Some("link2"), tip: Some("finger_left") }),
        ("tests/data/two.urdf", Ends::default()),
    ] {
        let (urdf, toml) = import(Path::new(file), ends);
        assert_eq!((&urdf.name, &urdf.source), (&toml.name, &toml.source));
        for (ours, theirs) in toml.joints.iter().zip(&urdf.joints) {
            assert_eq!((&ours.name, ours.friction), (&theirs.name, theirs.friction));
            assert_eq!((ours.spec.kind, ours.spec.limits), (theirs.spec.kind, theirs.spec.limits));
            assert_eq!(place(&ours.spec).1, place(&theirs.spec).1);
            assert_eq!((ours.spec.body.mass, ours.spec.body.com), (theirs.spec.body.mass, theirs.spec.body.com));
            assert!((ours.spec.body.inertia - theirs.spec.body.inertia).amax() < 1e-18);
        }
        with_dof!(urdf.dof(), N => {
            let [(ours, pose), (theirs, wanted)] = [&toml, &urdf].map(|robot| {
                let model = robot.model::<N>().unwrap();
                (Dynamics::new(model, Scene::with_gravity(Vector3::new(0.4, -0.9, -9.7), &model)), model)
            });
            for k in 0..200 {
                let [q, qd, qdd]: [[f64; N]; 3] = [3.0, 5.0, 20.0].map(|size| {
                    std::array::from_fn(|i| size * (1.7 * f64::from(k) + 2.3 * i as f64 + size).sin())
                });
                let turn = Libm.sin_cos_all(&q);
                let torque = |dynamics: &Dynamics<f64, N>| dynamics.inverse_dynamics(&turn, &q, &qd, &qdd, &Live::zero());
                let (found, right) = (torque(&ours), torque(&theirs));
                let largest = right.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                let off = (0..N).fold(0.0_f64, |m, i| m.max((found[i] - right[i]).abs() / largest));
                let (a, b) = (tip_pose(&pose, &turn, &q), tip_pose(&wanted, &turn, &q));
                furthest = furthest.max(off).max((a.translation - b.translation).amax()).max((a.rotation - b.rotation).amax());
            }
        });
    }
    println!("{furthest:e}");
    assert!(furthest < 4e-15, "{furthest:e}");
}

/// Angles with a few decimals, multiples of a right angle, and both at once, as in real files.
#[test]
fn angles_as_files_have_them_are_found_again_to_the_bit() {
    let words =
        ["0", "1.5708", "-1.5708", "1.5707963267948966", "3.14159265359", "-0.35", "0.785398163397448", "2.1e-3"];
    for i in 0..words.len().pow(3) {
        let rpy = [i / 64, i / 8 % 8, i % 8].map(|word| words[word]).join(" ");
        let old = "xyz=\"0 0 0.4\" rpy=\"0 0 0\"";
        assert!(TWO.contains(old));
        let path = std::env::temp_dir().join(format!("angles-{}.urdf", std::process::id()));
        std::fs::write(&path, TWO.replace(old, &format!("xyz=\"0 0 0.4\" rpy=\"{rpy}\""))).unwrap();
        let (urdf, toml) = import(&path, Ends::default());
        std::fs::remove_file(&path).unwrap();
        let [found, right] = [&toml, &urdf].map(|robot| place(&robot.joints[1].spec).0);
        // Pitched straight up, the split between roll and yaw is lost.
        let straight = right.m11.hypot(right.m21) == 0.0;
        assert!((found - right).amax() <= if straight { 4e-16 } else { 0.0 }, "{rpy}: {found} {right}");
    }
}

#[test]
fn an_imported_file_says_what_is_missing() {
    let arm = UrdfArm::load(Path::new("tests/data/gripper.urdf"), Ends::tip("palm")).unwrap();
    crate::common::compare_output("imported_gripper", robot_file(&arm));
}

#[test]
fn names_of_any_text_are_written_so_that_they_read_back() {
    let odd =
        TWO.replace("shoulder", "a \"b\" 'c' \\d # e").replace("a \"b\"", "a &quot;b&quot;").replace("fore", "f # g");
    let path = std::env::temp_dir().join(format!("names-{}.urdf", std::process::id()));
    std::fs::write(&path, odd).unwrap();
    let (urdf, toml) = import(&path, Ends::default());
    std::fs::remove_file(&path).unwrap();
    assert_eq!(urdf.joints[0].name, "a \"b\" 'c' \\d # e");
    assert_eq!((urdf.name, urdf.joints, urdf.tool), (toml.name, toml.joints, toml.tool));
}
