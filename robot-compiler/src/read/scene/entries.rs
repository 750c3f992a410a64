//! Entries of a list with one number for each joint.

use crate::describe::diagnostics::FileError;
use crate::describe::robot::{Robot, RobotJoint};
use crate::read::table::{Table, Value};
use dynamics_core::JointKind;

/// Checks each entry of a list in the file against bounds of its joint, both included; the text explains the bounds.
pub(super) fn each(
    table: &Table<'_>,
    key: &str,
    joints: &[RobotJoint],
    list: &[f64],
    bounds: impl Fn(usize, &RobotJoint) -> (f64, f64, String),
) -> Result<(), FileError> {
    let Some(value) = table.get(key) else { return Ok(()) };
    for (index, (joint, found)) in joints.iter().zip(list).enumerate() {
        let (least, most, why) = bounds(index, joint);
        if !(least..=most).contains(found) {
            let label = Robot::joint_label(index, &joint.name);
            let place = entry(&value, index);
            let guess = if key == "reach" && joint.spec.kind == JointKind::Revolute { degrees(*found) } else { "" };
            return Err(place.error(format!("found {found} for {label}{guess}"), why));
        }
    }
    Ok(())
}

/// The entry of a list, or the one number for all.
pub(super) fn entry<'a>(value: &Value<'a>, index: usize) -> Value<'a> {
    value.array("").ok().and_then(|list| list.into_iter().nth(index)).unwrap_or_else(|| value.clone())
}

/// Returns a question about degrees if an angle is larger than usual for its kind.
pub(super) const fn degrees(angle: f64) -> &'static str {
    if angle > 1.0 { "; degrees?" } else { "" }
}

pub(super) const fn unit(joint: &RobotJoint) -> &'static str {
    match joint.spec.kind {
        JointKind::Revolute => "rad",
        JointKind::Prismatic => "m",
    }
}
