//! A joint of the chain: its limits and its friction.

use super::chain::Chain;
use super::description::{Description, UrdfJoint, UrdfJointKind};
use super::markup::Markup;
use super::{description, merge, rotor};
use crate::describe::diagnostics::FileError;
use crate::describe::friction::JointFriction;
use crate::describe::robot::{JointHeat, Robot, RobotJoint};
use dynamics_core::{Frame, JointKind, JointSpec, Limits};

/// The `i`-th moving joint of the chain, and the link that moves with it.
pub(super) fn joint(
    markup: &Markup<'_>,
    urdf: &Description<'_>,
    chain: &Chain,
    i: usize,
) -> Result<RobotJoint, FileError> {
    let index = chain.moving[i];
    let joint = &urdf.joints[index];
    let label = Robot::joint_label(i, joint.name);
    let body = merge::body(urdf, chain, i);
    let place = merge::joint_placement(chain, i);
    let largest = joint.axis.amax();
    if largest == 0.0 {
        let (field, problem) = (format!("{label}.axis"), "the axis has no direction");
        return Err(markup.error_in(&joint.node, "axis", field, problem, "a vector that is not zero"));
    }
    // Scaled first, so that the square of a tiny or huge axis neither vanishes nor overflows.
    let axis = (joint.axis / largest).normalize();
    Ok(RobotJoint {
        heat: JointHeat::default(),
        name: joint.name.to_owned(),
        spec: JointSpec {
            kind: if joint.kind == UrdfJointKind::Prismatic { JointKind::Prismatic } else { JointKind::Revolute },
            frame: Frame::Placement { rotation: place.rotation, translation: place.translation, axis },
            body,
            rotor: rotor::rotor(markup, joint.name, &label)?,
            limits: limits(markup, joint),
        },
        friction: friction(markup, joint, &label)?,
        encoder: None,
        drive: None,
    })
}

/// The limits in the file; exporters write zero for an unknown limit.
pub(super) fn limits(markup: &Markup<'_>, joint: &UrdfJoint<'_>) -> Limits<f64> {
    let limit = |get: fn(&description::Limit) -> Option<f64>| {
        joint.limit.as_ref().and_then(get).filter(|limit| *limit != 0.0).unwrap_or(f64::INFINITY)
    };
    Limits {
        position: travel(markup, joint).0,
        velocity: limit(|limit| limit.velocity),
        torque: limit(|limit| limit.effort),
        torque_rate: f64::INFINITY,
    }
}

/// Position limits, and the reason if one is missing. Before version 1.2 a single missing limit is zero.
pub(super) fn travel(markup: &Markup<'_>, joint: &UrdfJoint<'_>) -> ((f64, f64), Option<String>) {
    let none = (f64::NEG_INFINITY, f64::INFINITY);
    if joint.kind == UrdfJointKind::Continuous {
        return (none, None);
    }
    let Some(limit) = &joint.limit else { return (none, Some("no <limit>".to_owned())) };
    let zero = if markup.version < (1, 2) { Some(0.0) } else { None };
    let taken = if zero.is_some() { "0 is taken" } else { "none is taken" };
    match (limit.lower, limit.upper) {
        (None, None) => (none, Some("lower and upper are both missing".to_owned())),
        (Some(0.0), Some(0.0)) => (none, Some("lower and upper are 0, a placeholder".to_owned())),
        (Some(low), Some(high)) => ((low, high), None),
        (Some(low), None) => {
            let high = zero.filter(|high| low < *high).unwrap_or(none.1);
            ((low, high), Some(format!("no upper, {taken}")))
        }
        (None, Some(high)) => {
            let low = zero.filter(|low| *low < high).unwrap_or(none.0);
            ((low, high), Some(format!("no lower, {taken}")))
        }
    }
}

pub(super) fn friction(
    markup: &Markup<'_>,
    joint: &UrdfJoint<'_>,
    label: &str,
) -> Result<Option<JointFriction>, FileError> {
    for (key, value) in [("damping", joint.damping), ("friction", joint.friction)] {
        if value < 0.0 {
            let (field, problem) = (format!("{label}.dynamics.{key}"), format!("found {value}"));
            return Err(markup.error_in(&joint.node, "dynamics", field, problem, "zero or more"));
        }
    }
    let given = joint.damping > 0.0 || joint.friction > 0.0;
    Ok(given.then_some(JointFriction { viscous: joint.damping, coulomb: joint.friction, ..JointFriction::default() }))
}
