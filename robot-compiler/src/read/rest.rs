//! The rest pose of a robot or scene file.

use crate::describe::diagnostics::FileError;
use crate::describe::robot::{Robot, RobotJoint};
use crate::read::shown::counted;
use crate::read::table::Value;
use dynamics_core::JointKind;
use std::f64::consts::TAU;

/// A position for every joint, inside its limits.
///
/// # Errors
/// A wrong number of positions, a position that is not finite or beyond a limit of its joint, or a slide without limits, for which the
/// speed of the tip cannot be bounded.
pub(super) fn read(value: &Value<'_>, joints: &[RobotJoint]) -> Result<Vec<f64>, FileError> {
    let expected =
        format!("{}, each inside the joint's limits, rad or m", counted(joints.len(), "position", "positions"));
    let positions = value.numbers(joints.len(), &expected)?;
    let items = value.array(&expected)?;
    for (index, ((joint, q), item)) in joints.iter().zip(&positions).zip(&items).enumerate() {
        let (lo, hi) = joint.spec.limits.position;
        let label = Robot::joint_label(index, &joint.name);
        if joint.spec.kind == JointKind::Prismatic && !(lo.is_finite() && hi.is_finite()) {
            let problem =
                format!("{label} slides and has no position limits, so that no speed of the tip can be bounded");
            return Err(item.error(problem, "`limits.position` for every prismatic joint, or no `rest`"));
        }
        if !(lo..=hi).contains(q) {
            // Degrees are the likely cause if the number, taken as degrees, would fit.
            let degrees = joint.spec.kind == JointKind::Revolute && (lo..=hi).contains(&(q * TAU / 360.0));
            let hint = if degrees { "; are these degrees?" } else { "" };
            return Err(item.error(format!("found {q}, the limits of {label} are [{lo}, {hi}]{hint}"), &expected));
        }
    }
    Ok(positions)
}
