//! Collision shapes of a URDF file.
#![allow(clippy::unwrap_used, reason = "a test file that cannot be handled should stop the test")]

use dynamics_core::Trig;
use dynamics_core::kinematics::link_poses;
use dynamics_core::model::Placement;
use dynamics_core::trig::Libm;
use nalgebra::{Matrix3, Vector3};
use robot_compiler::{Ends, Geometry, LinkShape, Robot};

/// Two joints about y and x; a flange and an open jaw are fixed to the second link.
const ARM: &str = r#"<robot name="shapes">
  <link name="ground"><collision><geometry><box size="0.2 0.3 0.4"/></geometry></collision></link>
  <link name="upper">
    <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.25"/><geometry><cylinder radius="0.05" length="0.5"/></geometry></collision>
    <collision><origin xyz="0 0.1 0"/><geometry><sphere radius="0.07"/></geometry></collision>
  </link>
  <link name="fore">
    <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="package://shapes/seen.dae"/></geometry></visual>
  </link>
  <link name="flange"><collision><geometry><mesh filename="package://shapes/flange.stl" scale="0.001 0.001 0.001"/></geometry></collision></link>
  <joint name="lift" type="revolute"><parent link="ground"/><child link="upper"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="10" velocity="2"/></joint>
  <joint name="bend" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0 0 0.5" rpy="0 0 0.3"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" effort="10" velocity="2"/></joint>
  <joint name="mount" type="fixed"><parent link="fore"/><child link="flange"/><origin xyz="0 0 0.3" rpy="0 0 -0.3"/></joint>
</robot>"#;

fn read(text: &str) -> Result<Vec<LinkShape>, robot_compiler::FileError> {
    LinkShape::from_urdf_str(text, "shapes.urdf", Ends::default())
}

#[test]
fn shapes_are_where_the_file_puts_them() {
    let shapes = read(ARM).unwrap();
    let found: Vec<(&str, usize)> = shapes.iter().map(|shape| (shape.link.as_str(), shape.frame)).collect();
    assert_eq!(found, [("ground", 0), ("upper", 1), ("upper", 1), ("flange", 2)]);
    assert_eq!(shapes[1].geometry, Geometry::Cylinder { radius: 0.05, length: 0.5 });
    let Geometry::Mesh { file, scale } = &shapes[3].geometry else { unreachable!("the flange has a mesh") };
    assert_eq!((file.as_str(), *scale), ("package://shapes/flange.stl", Vector3::repeat(0.001)));
    // In base axes at a posture, computed by hand: upright except for the lift, and the flange turned back to the upper link's yaw.
    let model = Robot::from_urdf_str(ARM, "shapes.urdf", Ends::default()).unwrap().model::<2>().unwrap();
    let q = [0.5, 0.0];
    let links = link_poses(&model, &Libm.sin_cos_all(&q), &q);
    let seen = |shape: &LinkShape| -> Placement<f64> { links[shape.frame - 1].then(&shape.place) };
    let (sin, cos) = 0.5_f64.sin_cos();
    let along = |length: f64| Vector3::new(length * sin, 0.0, 0.4 + length * cos);
    let upright = Matrix3::new(cos, 0.0, sin, 0.0, 1.0, 0.0, -sin, 0.0, cos);
    for (index, place, turned) in
        [(1, along(0.25), upright), (2, along(0.0) + Vector3::new(0.0, 0.1, 0.0), upright), (3, along(0.8), upright)]
    {
        let found = seen(&shapes[index]);
        assert!((found.translation - place).norm() < 1e-12, "{index}: {found:?}, {place}");
        assert!((found.rotation - turned).norm() < 1e-12, "{index}: {found:?}");
    }
}

#[test]
fn shapes_that_are_none_are_refused_with_their_place() {
    let cases = [
        (
            "<box size=\"0.2 0.3 0.4\"/>",
            "<box size=\"0.2 0 0.4\"/>",
            "link ground.collision.geometry.box.size",
            "above zero",
        ),
        ("<box size=\"0.2 0.3 0.4\"/>", "<box size=\"0.2 0.3\"/>", "box.size", "3 finite numbers"),
        ("<box size=\"0.2 0.3 0.4\"/>", "<cone/>", "link ground.collision.geometry", "<mesh>"),
        ("<box size=\"0.2 0.3 0.4\"/>", "", "link ground.collision.geometry", "one of"),
        ("<sphere radius=\"0.07\"/>", "<sphere radius=\"-1\"/>", "sphere.radius", "above zero"),
        ("radius=\"0.05\" length", "length", "cylinder.radius", "one finite number"),
        (
            "filename=\"package://shapes/flange.stl\"",
            "",
            "link flange.collision.geometry.mesh.filename",
            "path of a mesh",
        ),
    ];
    for (from, to, field, expected) in cases {
        let error = read(&ARM.replace(from, to)).unwrap_err();
        let text = format!("{:?}", miette::Report::new(error));
        assert!(text.contains(field) && text.contains(expected), "{to}: {text}");
    }
}

#[test]
fn a_robot_file_in_toml_has_no_shapes() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/yam.toml");
    assert_eq!(LinkShape::load(&path, Ends::default()).unwrap(), []);
}
