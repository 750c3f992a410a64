//! An arm as a URDF, which viewers, simulators and [`Robot::from_urdf_str`](crate::Robot::from_urdf_str) read.

mod shapes;
mod text;
mod tree;

use super::angles::roll_pitch_yaw;
use crate::describe::cut::NAMESPACE;
use crate::describe::robot::{Robot, RobotJoint};
use dynamics_core::model::Placement;
use dynamics_core::{Body, JointKind, Limits, Rotor};
use std::fmt::Write as _;
use text::{escaped, number, numbers};
pub use tree::{LinkTree, TreeJoint};

/// XML text of an arm.
///
/// | in the robot file | in the URDF |
/// |---|---|
/// | rows, placements, axes | origins and axes; see [`LinkTree`] for the frames |
/// | masses, mass centres, inertias, including the tool's | `<inertial>`, its origin turned like the robot file's frame |
/// | limits of position, velocity, torque | `<limit>`; version 1.2 if one of them is missing |
/// | viscous and Coulomb friction | `<dynamics>` |
/// | rotor and gear | `<transmission>` with Drake's `drake:rotor_inertia` and `drake:gear_ratio` |
/// | permission for unphysical bodies | an attribute in this project's namespace |
/// | a turned base | a link `world`, and a fixed joint that turns the base in it |
/// | other terms of friction, torque rates, encoders, drives | not exported |
///
/// The shapes are made up: a cylinder along every link, and a cylinder about every revolute or a box on every prismatic axis.
#[must_use]
pub fn urdf(robot: &Robot) -> String {
    let tree = LinkTree::new(robot);
    let limited = |joint: &RobotJoint| is_limited(joint.spec.kind, &joint.spec.limits);
    let version = if robot.joints.iter().all(limited) { "1.0" } else { "1.2" };
    let mut text =
        String::from("<?xml version=\"1.0\"?>\n<!-- Written by `newtau model export`. SI units and radians. -->\n");
    let name = escaped(&robot.name);
    push(&mut text, format_args!("<robot name=\"{name}\" version=\"{version}\"{}>\n", extensions(robot)));
    if let Some(rotation) = robot.mounting {
        let place = Placement { rotation, translation: tree::here().translation };
        let joint = escaped(&unused(robot, "mounting"));
        push(
            &mut text,
            format_args!(
                "  <link name=\"world\"/>\n  <joint name=\"{joint}\" type=\"fixed\">\n    {}\n    <parent link=\"world\"/>\n    \
                 <child link=\"{}\"/>\n  </joint>\n",
                origin(&place),
                escaped(&tree.base)
            ),
        );
    }
    let radius = shapes::radius(&tree);
    let ends = |i: usize| tree.joints.get(i).map(|joint| joint.origin.translation);
    link(&mut text, &tree.base, "", &shapes::rod(ends(0), radius));
    for (i, joint) in tree.joints.iter().enumerate() {
        let shapes = shapes::axis(joint.motion, radius) + &shapes::rod(ends(i + 1), radius);
        let (body, place) = match (robot.joints.get(i), tree.link_from_body.get(i)) {
            (Some(joint), Some(place)) => (joint.spec.body, Some(place)),
            _ => (robot.tool.body, None),
        };
        // Readers treat a moving link without an <inertial> as an error; a tip without one is usual.
        let inertial = if place.is_some() || body != Body::massless() { inertial(&body, place) } else { String::new() };
        let of_robot = robot.joints.get(i);
        push(&mut text, format_args!("{}", joint_element(joint, of_robot)));
        link(&mut text, &joint.child, &inertial, &shapes);
    }
    for joint in &robot.joints {
        text += &transmission(&joint.name, &joint.spec.rotor);
    }
    text + "</robot>\n"
}

/// A name that no joint of the robot has.
fn unused(robot: &Robot, name: &str) -> String {
    let mut name = name.to_owned();
    while robot.joints.iter().any(|joint| joint.name == name) {
        name.push('_');
    }
    name
}

/// Namespaces of everything that URDF cannot express, and the attributes of the root element.
fn extensions(robot: &Robot) -> String {
    let mut text = String::new();
    if robot.joints.iter().any(|joint| joint.spec.rotor.reflected() > 0.0) {
        text += " xmlns:drake=\"https://drake.mit.edu\"";
    }
    if let Some(reason) = &robot.allow_unphysical {
        let reason = escaped(reason);
        push(&mut text, format_args!(" xmlns:newtau=\"{NAMESPACE}\" newtau:allow_unphysical=\"{reason}\""));
    }
    text
}

/// Appends to a text, which cannot fail.
fn push(text: &mut String, more: std::fmt::Arguments<'_>) {
    text.write_fmt(more).ok();
}

fn link(text: &mut String, name: &str, inertial: &str, shapes: &str) {
    let name = escaped(name);
    if inertial.is_empty() && shapes.is_empty() {
        push(text, format_args!("  <link name=\"{name}\"/>\n"));
    } else {
        push(text, format_args!("  <link name=\"{name}\">\n{inertial}{shapes}  </link>\n"));
    }
}

fn joint_element(joint: &TreeJoint, of_robot: Option<&RobotJoint>) -> String {
    let mut inside = format!(
        "    {}\n    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n",
        origin(&joint.origin),
        escaped(&joint.parent),
        escaped(&joint.child)
    );
    let mut kind = "fixed";
    if let (Some((motion, axis)), Some(of_robot)) = (joint.motion, of_robot) {
        let limits = &of_robot.spec.limits;
        kind = match motion {
            JointKind::Prismatic => "prismatic",
            JointKind::Revolute if limits.position == (f64::NEG_INFINITY, f64::INFINITY) => "continuous",
            JointKind::Revolute => "revolute",
        };
        push(&mut inside, format_args!("    <axis xyz=\"{}\"/>\n", numbers(axis.as_slice())));
        inside += &limit(limits, kind == "continuous");
        if let Some(friction) = of_robot.friction {
            let (damping, friction) = (number(friction.viscous), number(friction.coulomb));
            push(&mut inside, format_args!("    <dynamics damping=\"{damping}\" friction=\"{friction}\"/>\n"));
        }
    }
    format!("  <joint name=\"{}\" type=\"{kind}\">\n{inside}  </joint>\n", escaped(&joint.name))
}

/// True if `<limit>` of version 1.0 can express the limits: all of them present, or all missing on a joint that turns.
fn is_limited(kind: JointKind, limits: &Limits<f64>) -> bool {
    let (lowest, highest) = limits.position;
    let torque_and_speed = limits.velocity.is_finite() && limits.torque.is_finite();
    let free = lowest.is_infinite() && highest.is_infinite() && kind == JointKind::Revolute;
    let none = limits.velocity.is_infinite() && limits.torque.is_infinite();
    (lowest.is_finite() && highest.is_finite() && torque_and_speed) || (free && (none || torque_and_speed))
}

/// The limits that are present; only a joint without an end may omit the element.
fn limit(limits: &Limits<f64>, continuous: bool) -> String {
    let (lower, upper) = limits.position;
    let all = [("lower", lower), ("upper", upper), ("effort", limits.torque), ("velocity", limits.velocity)];
    let given = all.iter().filter(|(_, value)| value.is_finite());
    let text: String = given.map(|(key, value)| format!(" {key}=\"{}\"", number(*value))).collect();
    if text.is_empty() && continuous { text } else { format!("    <limit{text}/>\n") }
}

fn inertial(body: &Body, place: Option<&Placement<f64>>) -> String {
    let here = tree::here();
    let place = place.unwrap_or(&here);
    let centre = Placement { rotation: place.rotation, translation: place.translation + place.rotation * body.com };
    let i = &body.inertia;
    let entries = [("ixx", i.m11), ("ixy", i.m12), ("ixz", i.m13), ("iyy", i.m22), ("iyz", i.m23), ("izz", i.m33)];
    let tensor: String = entries.iter().map(|(key, value)| format!(" {key}=\"{}\"", number(*value))).collect();
    format!(
        "    <inertial>\n      {}\n      <mass value=\"{}\"/>\n      <inertia{tensor}/>\n    </inertial>\n",
        origin(&centre),
        number(body.mass)
    )
}

/// Rotor and gear in Drake's form. Other programs read the reduction or nothing.
fn transmission(joint: &str, rotor: &Rotor) -> String {
    if rotor.reflected() == 0.0 {
        return String::new();
    }
    let (joint, gear, inertia) = (escaped(joint), number(rotor.gear), number(rotor.inertia));
    format!(
        "  <transmission name=\"{joint}_transmission\">\n    <type>transmission_interface/SimpleTransmission</type>\n    \
         <joint name=\"{joint}\">\n      <hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>\n    </joint>\n    \
         <actuator name=\"{joint}_motor\">\n      <mechanicalReduction>{gear}</mechanicalReduction>\n      \
         <drake:rotor_inertia value=\"{inertia}\"/>\n      <drake:gear_ratio value=\"{gear}\"/>\n    </actuator>\n  </transmission>\n"
    )
}

fn origin(place: &Placement<f64>) -> String {
    let angles = roll_pitch_yaw(&place.rotation);
    format!("<origin xyz=\"{}\" rpy=\"{}\"/>", numbers(place.translation.as_slice()), numbers(&angles))
}
