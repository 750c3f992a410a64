//! Joints that a chain may have.

use super::description::{Description, UrdfJointKind};
use super::markup::{Markup, child};
use crate::describe::diagnostics::FileError;

pub(super) fn moves(urdf: &Description<'_>, joint: usize) -> bool {
    urdf.joints[joint].kind != UrdfJointKind::Fixed
}

/// Rejects joints other than those with one free variable of their own.
pub(super) fn supported(markup: &Markup<'_>, urdf: &Description<'_>, index: usize) -> Result<(), FileError> {
    let joint = &urdf.joints[index];
    let node = &urdf.joints[index].node;
    let kind = match joint.kind {
        UrdfJointKind::Revolute | UrdfJointKind::Continuous | UrdfJointKind::Prismatic | UrdfJointKind::Fixed => {
            if child(node, "mimic").is_none() {
                return Ok(());
            }
            let field = format!("joint {}.mimic", joint.name);
            let problem = "the joint follows another one";
            return Err(markup.error_in(node, "mimic", field, problem, "joints that move on their own"));
        }
        UrdfJointKind::Floating => "floating",
        UrdfJointKind::Planar => "planar",
        UrdfJointKind::Spherical => "spherical",
    };
    let field = format!("joint {}.type", joint.name);
    let problem = format!("a {kind} joint is in the chain");
    let expected = format!(
        "revolute, continuous, prismatic or fixed; for the arm that {} carries, `--base {}`",
        joint.name, joint.child
    );
    Err(markup.error(node, field, problem, expected))
}
