//! Contents read from a URDF, on small files with known answers.
#![allow(clippy::unwrap_used, reason = "a test file that cannot be handled should stop the test")]
#![allow(clippy::float_cmp, reason = "numbers from a file must come through unchanged")]

use nalgebra::{Matrix3, Vector3};
use robot_compiler::{Ends, JointFriction, Robot};
use std::path::Path;

const TWO: &str = include_str!("data/two.urdf");

fn load(text: &str) -> Robot {
    Robot::from_urdf_str(text, "test.urdf", Ends::default()).unwrap()
}

fn changed(old: &str, new: &str) -> Robot {
    assert!(TWO.contains(old), "{old}");
    load(&TWO.replacen(old, new, 1))
}

#[test]
fn a_urdf_and_a_toml_of_the_same_arm_give_the_same_joints() {
    let toml = r#"
        name = "two"
        [[joint]]
        name = "shoulder"
        type = "revolute"
        placement = { xyz = [0.0, 0.0, 0.1] }
        axis = [0, 1, 0]
        mass = 2.0
        com = [0.0, 0.0, 0.2]
        inertia = { xx = 0.03, yy = 0.03, zz = 0.002 }
        friction = { viscous = 0.1, coulomb = 0.2 }
        limits = { position = [-2, 2], velocity = 3, torque = 50 }
        [[joint]]
        name = "elbow"
        type = "revolute"
        placement = { xyz = [0.0, 0.0, 0.4] }
        axis = [0, 1, 0]
        mass = 1.0
        com = [0.0, 0.0, 0.15]
        inertia = { xx = 0.01, yy = 0.01, zz = 0.001 }
    "#;
    let (urdf, toml) = (load(TWO), Robot::from_toml_str(toml, "two.toml").unwrap());
    assert_eq!((urdf.name, urdf.joints, urdf.tool), (toml.name, toml.joints, toml.tool));
}

#[test]
fn a_continuous_joint_has_no_position_limits_even_with_a_limit_element() {
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    assert_eq!(load(TWO).joints[1].spec.limits.position, free);
    let robot = changed("0.4\" rpy=\"0 0 0\"/>", "0.4\"/><limit lower=\"0\" upper=\"0\" effort=\"9\" velocity=\"4\"/>");
    let limits = robot.joints[1].spec.limits;
    assert_eq!((limits.position, limits.torque, limits.velocity), (free, 9.0, 4.0));
}

#[test]
fn friction_is_read_from_dynamics_and_absent_when_zero() {
    let friction = |robot: Robot| robot.joints[0].friction;
    assert_eq!(friction(load(TWO)), Some(JointFriction { viscous: 0.1, coulomb: 0.2, ..JointFriction::default() }));
    assert_eq!(friction(changed("damping=\"0.1\" friction=\"0.2\"", "damping=\"0\"")), None);
}

#[test]
fn an_axis_is_brought_to_unit_length() {
    for axis in ["0 2 0", "0 1e-30 0", "0 1e30 0"] {
        let robot = changed("<axis xyz=\"0 1 0\"/>", &format!("<axis xyz=\"{axis}\"/>"));
        assert_eq!(robot.joints, load(TWO).joints, "{axis}");
    }
    // Without the element the axis is x.
    let robot = changed("<axis xyz=\"0 1 0\"/>", "");
    let dynamics_core::Frame::Placement { axis, .. } = robot.joints[0].spec.frame else { unreachable!() };
    assert_eq!(axis, Vector3::x());
}

#[test]
fn the_orientation_of_an_inertial_turns_its_tensor() {
    // A quarter turn about x swaps y and z; the file's zz = 0.002 becomes yy.
    let quarter = std::f64::consts::FRAC_PI_2;
    let robot = changed("xyz=\"0 0 0.2\" rpy=\"0 0 0\"", &format!("xyz=\"0 0 0.2\" rpy=\"{quarter:?} 0 0\""));
    let body = robot.joints[0].spec.body;
    assert_eq!(body.inertia, Matrix3::from_diagonal(&Vector3::new(0.03, 0.002, 0.03)));
    assert_eq!(body.com, Vector3::new(0.0, 0.0, 0.2));
}

/// A plate on a bracket, both fixed, with the bracket turned: inertia computed by hand.
#[test]
fn fixed_links_add_their_inertia_where_they_are() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let extra = format!(
        r#"<link name="bracket"/>
        <link name="plate">
          <inertial>
            <origin xyz="0.1 0 0"/>
            <mass value="1.0"/>
            <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.003"/>
          </inertial>
        </link>
        <joint name="screws" type="fixed">
          <parent link="fore"/><child link="bracket"/><origin xyz="0 0 0.3" rpy="0 0 {quarter:?}"/>
        </joint>
        <joint name="glue" type="fixed"><parent link="bracket"/><child link="plate"/><origin xyz="0.2 0 0"/></joint>
        </robot>"#
    );
    let robot = load(&TWO.replace("</robot>", &extra));
    let body = robot.joints[1].spec.body;
    // The plate's centre is 0.3 along the bracket's x, which is y of the forearm, at a height of 0.3. Two bodies of 1 kg.
    let plate = Vector3::new(0.0, 0.3, 0.3);
    let own = Vector3::new(0.0, 0.0, 0.15);
    let com = (plate + own) * 0.5;
    let about = |diagonal: [f64; 3], c: Vector3<f64>| {
        let d = c - com;
        Matrix3::from_diagonal(&Vector3::from(diagonal)) + Matrix3::identity() * d.dot(&d) - d * d.transpose()
    };
    let tensor = about([0.01, 0.01, 0.001], own) + about([0.002, 0.001, 0.003], plate);
    assert!((body.mass - 2.0).abs() < 1e-15 && (body.com - com).amax() < 1e-15);
    assert!((body.inertia - tensor).amax() < 1e-15, "{} {tensor}", body.inertia);
    // The plate is the last fixed link: its frame is the tip.
    assert!((robot.tool.translation - Vector3::new(0.0, 0.2, 0.3)).amax() < 1e-15);
    assert!((robot.tool.rotation - Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)).amax() == 0.0);
}

#[test]
fn a_fixed_link_on_the_way_moves_the_next_joint() {
    let between = r#"<parent link="upper"/><child link="flange"/><origin xyz="0 0 0.1"/></joint>
        <link name="flange"/>
        <joint name="elbow" type="continuous"><parent link="flange"/>"#;
    let robot = load(&TWO.replace("name=\"elbow\" type=\"continuous\"", "name=\"weld\" type=\"fixed\"").replacen(
        "<parent link=\"upper\"/>",
        between,
        1,
    ));
    let dynamics_core::Frame::Placement { translation, .. } = robot.joints[1].spec.frame else { unreachable!() };
    assert_eq!(translation, Vector3::new(0.0, 0.0, 0.5));
    assert_eq!(robot.joints[1].spec.body, load(TWO).joints[1].spec.body);
}

#[test]
fn a_branch_that_does_not_move_leaves_one_chain_and_a_named_tip_is_taken() {
    let frames = r#"<link name="ee"/><link name="camera"/>
        <joint name="a" type="fixed"><parent link="fore"/><child link="ee"/><origin xyz="0 0 0.3"/></joint>
        <joint name="b" type="fixed"><parent link="fore"/><child link="camera"/><origin xyz="0 0.1 0.2"/></joint>
        </robot>"#;
    let text = TWO.replace("</robot>", frames);
    let tip = |tip| Robot::from_urdf_str(&text, "test.urdf", Ends { base: None, tip }).unwrap().tool.translation;
    assert_eq!(tip(None), Vector3::new(0.0, 0.0, 0.3));
    assert_eq!(tip(Some("ee")), Vector3::new(0.0, 0.0, 0.3));
    assert_eq!(tip(Some("camera")), Vector3::new(0.0, 0.1, 0.2));
    assert_eq!(Robot::from_urdf_str(&text, "test.urdf", Ends::tip("upper")).unwrap().dof(), 1);
}

#[test]
fn shapes_that_cannot_be_read_do_not_matter() {
    let odd = "<visual><geometry><blob/></geometry><material name=\"m\"><texture/></material></visual>";
    assert_eq!(changed("<link name=\"fore\">", &format!("<link name=\"fore\">{odd}")).joints, load(TWO).joints);
}

#[test]
fn what_neither_moves_nor_weighs_anything_is_not_read() {
    let odd = "<limit lower=\"-2\"><blob/></limit><calibration rising=\"?\"/><safety_controller/>";
    let held =
        "<link name=\"lid\"/><joint name=\"hinge\" type=\"revolute\"><parent link=\"base\"/><child link=\"lid\"/>";
    let text = TWO.replace("</robot>", &format!("{held}{odd}<mimic multiplier=\"?\"/></joint></robot>"));
    assert_eq!(Robot::from_urdf_str(&text, "test.urdf", Ends::tip("fore")).unwrap().joints, load(TWO).joints);
}

#[test]
fn a_quaternion_turns_an_origin_from_version_1_1_on() {
    let turned = |version: &str, turn: &str| {
        let text = TWO.replacen("<robot ", &format!("<robot version=\"{version}\" "), 1);
        let (old, new) = ("xyz=\"0 0 0.2\" rpy=\"0 0 0\"", format!("xyz=\"0 0 0.2\" {turn}"));
        assert!(text.contains(old));
        load(&text.replacen(old, &new, 1)).joints[0].spec.body.inertia
    };
    // The quaternion may have any length.
    let (half, quarter) = ("quat_xyzw=\"2 0 0 2\"", std::f64::consts::FRAC_PI_2);
    let (found, known) = (turned("1.1", half), turned("1.1", &format!("rpy=\"{quarter:?} 0 0\"")));
    assert!((found - known).amax() < 1e-15 && (found.m22 - 0.002).abs() < 1e-15, "{found}");
    // Pitched straight up, roll and yaw are the same rotation.
    let down = turned("1.2", "quat_xyzw=\"0 1 0 1\"");
    assert!((down - Matrix3::from_diagonal(&Vector3::new(0.002, 0.03, 0.03))).amax() < 1e-15, "{down}");
    for version in ["1.0", "one", "1"] {
        assert_eq!(turned(version, half), load(TWO).joints[0].spec.body.inertia, "{version}");
    }
}

#[test]
fn limits_may_be_left_out_from_version_1_2_on() {
    let limited = |version: &str, limit: &str| {
        let text = TWO.replacen("<robot ", &format!("<robot version=\"{version}\" "), 1);
        let old = "<limit lower=\"-2\" upper=\"2\" effort=\"50\" velocity=\"3\"/>";
        assert!(text.contains(old));
        Robot::from_urdf_str(&text.replacen(old, limit, 1), "test.urdf", Ends::default())
    };
    let limits = limited("1.2", "<limit lower=\"-2\"/>").unwrap().joints[0].spec.limits;
    assert_eq!((limits.position, limits.torque), ((-2.0, f64::INFINITY), f64::INFINITY));
    assert_eq!(limits.velocity, f64::INFINITY);
    // Before version 1.2, speed and torque are gaps.
    assert_eq!(limited("1.1", "<limit lower=\"-2\"/>").unwrap().joints[0].spec.limits.torque, f64::INFINITY);
    // In version 1.0 a missing travel limit is zero.
    let limits = limited("1.0", "<limit lower=\"-2\" effort=\"50\" velocity=\"3\"/>").unwrap().joints[0].spec.limits;
    assert_eq!(limits.position, (-2.0, 0.0));
}

#[test]
fn the_extension_decides_how_a_file_is_read() {
    assert_eq!(Robot::load(Path::new("tests/data/two.urdf")).unwrap().joints, load(TWO).joints);
}
