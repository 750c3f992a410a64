//! Locations of an arm's numbers in a URDF file, and its links before fixed ones are merged.

use super::chain::Chain;
use super::description::{Description, UrdfJointKind};
use super::markup::{Markup, child};
use super::merge;
use crate::describe::draft::{DraftBody, JointPlaces, Place, own_joint};
use crate::describe::robot::Robot;
use nalgebra::Vector3;
use roxmltree::Node;

/// The links that the `i`-th moving joint moves: its own, then those fixed to it that have an `<inertial>`.
pub(super) fn bodies(
    markup: &Markup<'_>,
    urdf: &Description<'_>,
    chain: &Chain,
    robot: &Robot,
    i: usize,
) -> Vec<DraftBody> {
    let parts = merge::parts(chain, i).into_iter().enumerate();
    let stated = parts.filter(|&(part, link)| part == 0 || child(&urdf.links[link].node, "inertial").is_some());
    let body = |(part, index): (usize, usize)| {
        let link = &urdf.links[index];
        let mut points = match robot.joints.get(i) {
            Some(joint) if part == 0 => own_joint(&joint.spec, axis(urdf, chain, i)),
            _ => vec![Vector3::zeros()],
        };
        points.extend(chain.below[index].iter().map(|&joint| chain.place[joint].translation));
        let field = |name: &str| format!("link {}.inertial.{name}", link.name);
        let inertial = child(&link.node, "inertial");
        let place = |name: &str| match &inertial {
            Some(inertial) => markup.place(inertial, name, field(name)),
            None => markup.place(&link.node, "inertial", field(name)),
        };
        DraftBody {
            joint: i,
            fixed: part > 0,
            body: link.body,
            centre: link.body.com,
            points,
            mass: place("mass"),
            com: place("origin"),
            inertia: place("inertia"),
        }
    };
    stated.map(body).collect()
}

/// Unit axis of a joint in its own frame.
fn axis(urdf: &Description<'_>, chain: &Chain, i: usize) -> Vector3<f64> {
    let axis = urdf.joints[chain.moving[i]].axis;
    (axis / axis.amax()).normalize()
}

/// Locations of a joint's other numbers.
pub(super) fn joint(markup: &Markup<'_>, urdf: &Description<'_>, chain: &Chain, i: usize) -> JointPlaces {
    let joint = &urdf.joints[chain.moving[i]];
    let label = Robot::joint_label(i, joint.name);
    let of = |name: &str, field: &str| markup.place(&joint.node, name, format!("{label}.{field}"));
    let limit = |keys: &[&str]| limit(markup, &joint.node, keys, &label);
    // Values without an element in URDF are missing from the joint.
    let none = |field: &str| of("", field);
    JointPlaces {
        position: limit(&["lower", "upper"]),
        turns_on: joint.kind == UrdfJointKind::Continuous,
        velocity: limit(&["velocity"]),
        torque: limit(&["effort"]),
        rotor: none("rotor"),
        friction: of("dynamics", "dynamics"),
        encoder: none("encoder"),
        drive_torque: none("drive.torque"),
        drive_position: none("drive.position"),
        heat: none("heat"),
        rest: none("rest"),
    }
}

/// The location of the first of these attributes of a `<limit>` that is present.
fn limit(markup: &Markup<'_>, joint: &Node<'_, '_>, keys: &[&str], label: &str) -> Place {
    let name = keys.first().copied().unwrap_or_default();
    let place = markup.place(joint, "limit", format!("{label}.limit.{name}"));
    let found = child(joint, "limit").and_then(|limit| keys.iter().find_map(|key| limit.attribute_node(*key)));
    match found {
        Some(attribute) => Place { span: attribute.range(), ..place },
        None => Place { given: false, ..place },
    }
}

/// Roll, pitch and yaw of joints and bodies of the arm.
pub(super) fn angles(urdf: &Description<'_>, chain: &Chain) -> Vec<(Place, f64)> {
    let mut found = Vec::new();
    let mut add = |origin: Option<Node<'_, '_>>, label: String| {
        let Some(attribute) = origin.and_then(|origin| origin.attribute_node("rpy")) else { return };
        let numbers = attribute.value().split_whitespace().filter_map(|word| word.parse().ok());
        let place = Place { span: attribute.range(), field: format!("{label}.origin.rpy"), given: true };
        found.extend(numbers.map(|angle: f64| (place.clone(), angle)));
    };
    for link in (0..chain.moving.len()).flat_map(|i| merge::parts(chain, i)) {
        let part = &urdf.links[link];
        let inertial = child(&part.node, "inertial");
        add(inertial.and_then(|inertial| child(&inertial, "origin")), format!("link {}.inertial", part.name));
    }
    // Joints from the tip's side up to the root, including those above the base, which turn gravity.
    for (index, joint) in urdf.joints.iter().enumerate() {
        let below = chain.moving.first().is_some_and(|first| chain.is_below(index, chain.child[*first]));
        if below || chain.moving.first() == Some(&index) || chain.is_above(index, chain.tip) {
            add(child(&joint.node, "origin"), format!("joint {}", joint.name));
        }
    }
    found
}
