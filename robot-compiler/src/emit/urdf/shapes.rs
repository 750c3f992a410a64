//! Shapes for viewers, for an arm without shapes in its file: a rod along every link, a drum or a box on every axis.

use super::text::{number, numbers};
use super::tree::LinkTree;
use dynamics_core::JointKind;
use nalgebra::Vector3;

/// Radius of the rods, as a share of the arm's length, and for an arm without a length, m.
const SHARE: f64 = 0.025;
const SMALLEST: f64 = 0.005;
/// Radius and length of the drum on an axis, in radii of a rod.
const DRUM: (f64, f64) = (1.6, 3.6);

/// Radius of the rods, m.
pub(super) fn radius(tree: &LinkTree) -> f64 {
    let length: f64 = tree.joints.iter().map(|joint| joint.origin.translation.norm()).sum();
    // Three digits are enough for a shape.
    ((SHARE * length).max(SMALLEST) * 1e3).round() / 1e3
}

/// A rod from the origin of a link's frame to this point of it, m.
pub(super) fn rod(to: Option<Vector3<f64>>, radius: f64) -> String {
    let Some(to) = to.filter(|to| to.norm() > 1e-6) else { return String::new() };
    let geometry = format!("<cylinder radius=\"{}\" length=\"{}\"/>", number(radius), number(to.norm()));
    visual(&(to * 0.5), &to, &geometry, "rod", "0.75 0.77 0.8 1")
}

/// A drum about the axis of a joint that turns, a box on the axis of one that slides.
pub(super) fn axis(motion: Option<(JointKind, Vector3<f64>)>, radius: f64) -> String {
    let Some((kind, axis)) = motion else { return String::new() };
    let (wide, long) = (DRUM.0 * radius, DRUM.1 * radius);
    let geometry = match kind {
        JointKind::Revolute => format!("<cylinder radius=\"{}\" length=\"{}\"/>", number(wide), number(long)),
        JointKind::Prismatic => format!("<box size=\"{}\"/>", numbers(&[2.0 * wide, 2.0 * wide, long])),
    };
    visual(&Vector3::zeros(), &axis, &geometry, "axis", "0.9 0.45 0.1 1")
}

/// A shape with its z along a direction.
fn visual(at: &Vector3<f64>, along: &Vector3<f64>, geometry: &str, material: &str, colour: &str) -> String {
    // Rz(yaw) Ry(pitch) turns z to that direction.
    let (pitch, yaw) = (along.x.hypot(along.y).atan2(along.z), along.y.atan2(along.x));
    format!(
        "    <visual>\n      <origin xyz=\"{}\" rpy=\"{}\"/>\n      <geometry>{geometry}</geometry>\n      \
         <material name=\"{material}\"><color rgba=\"{colour}\"/></material>\n    </visual>\n",
        numbers(at.as_slice()),
        numbers(&[0.0, pitch, yaw])
    )
}
