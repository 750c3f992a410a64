//! Torque needed to hold the arm.

use super::amount::{Units, amount, digits};
use super::{CheckRule, Finding, JointLoad, Severity};
use crate::describe::draft::{Draft, JointPlaces, Place};
use crate::describe::drive::JointDrive;
use crate::describe::robot::RobotJoint;

/// Load of gravity below which it counts as zero, N m or N: below the friction of any joint.
pub(super) const NOTHING: f64 = 1e-3;
/// Least ratio of torque and load: a third is left for acceleration, friction, and the gripper's load.
const MARGIN: f64 = 1.5;

pub(super) fn findings(draft: &Draft, loads: &[JointLoad]) -> Vec<Finding> {
    let joints = draft.robot.joints.iter().zip(&draft.places).zip(loads);
    let finding = |((joint, places), load): ((&RobotJoint, &JointPlaces), &JointLoad)| {
        let limit = joint.spec.limits.torque;
        let drive = drive_torque(joint).unwrap_or(f64::INFINITY);
        let (has, place, what) = if drive < limit {
            (drive, &places.drive_torque, "the drive has")
        } else {
            (limit, &places.torque, "the limit is")
        };
        holding(draft, joint, (has, place, what), load)
    };
    joints.filter_map(finding).collect()
}

/// Torque of a joint compared with its largest load of gravity, `max |G_i(q)|` over the postures inside the limits.
///
/// Wrong below the load: the arm falls. A doubt below [`MARGIN`] times the load.
fn holding(
    draft: &Draft,
    joint: &RobotJoint,
    (has, place, what): (f64, &Place, &str),
    load: &JointLoad,
) -> Option<Finding> {
    // A limit that is missing or impossible has its own finding.
    if !has.is_finite() || has <= 0.0 || has >= MARGIN * load.holding || load.holding < NOTHING {
        return None;
    }
    let unit = Units::of(joint).torque;
    let (severity, fails) =
        if has < load.holding { (Severity::Wrong, "it falls") } else { (Severity::Doubt, "little is left to move") };
    let q: Vec<String> = load.posture.iter().map(|q| format!("{q:.3}")).collect();
    let problem = format!(
        "takes {} to hold still at q = {}, {what} {}: {fails}",
        amount(load.holding, unit),
        q.join(","),
        amount(has, unit)
    );
    let needed = digits(MARGIN * load.holding);
    let advice = format!(
        "write what the actuator can do, if it is more; else take one with {needed} {unit}, or narrow the positions"
    );
    Some(Finding::new(draft, (CheckRule::Holding, severity), place, problem, advice))
}

/// Torque that the drive of a joint can give in both directions, at the joint, N m or N.
///
/// In MIT mode `|ratio| min(|lowest|, highest)` of its frames; with an H-bridge `|ratio| k_t i_max`.
fn drive_torque(joint: &RobotJoint) -> Option<f64> {
    Some(match joint.drive? {
        JointDrive::Mit(drive) => drive.ratio.abs() * drive.torque.0.abs().min(drive.torque.1),
        JointDrive::Pwm(drive) => drive.ratio.abs() * drive.torque_constant * drive.current_max,
    })
}
