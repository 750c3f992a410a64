//! Continuous torque of the motors, and the pose in which the arm rests without torque.

use super::amount::{Units, amount, names, percent};
use super::{CheckRule, Finding, JointLoad, Severity};
use crate::describe::draft::{Draft, JointPlaces};
use crate::describe::robot::RobotJoint;
use dynamics_core::JointKind;

pub(super) fn findings(draft: &Draft, loads: Option<&[JointLoad]>) -> Vec<Finding> {
    let mut found: Vec<Finding> = [no_rating(draft), no_time_constant(draft)].into_iter().flatten().collect();
    let joints = draft.robot.joints.iter().zip(&draft.places).zip(loads.unwrap_or_default());
    for (index, ((joint, places), load)) in joints.enumerate() {
        found.extend(continuous(draft, joint, places, load));
        found.extend(sinks(draft, index, joint, places, load));
    }
    found
}

/// Distance from a limit, rad or m, within which a joint that gravity presses against it counts as resting on its stop: it cannot fall further.
#[must_use]
pub const fn on_stop_distance(kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => 0.05,
        JointKind::Prismatic => 0.005,
    }
}

/// Joints with a drive.
fn driven(draft: &Draft, wanted: impl Fn(&RobotJoint) -> bool) -> Vec<(&RobotJoint, &JointPlaces)> {
    let all = draft.robot.joints.iter().zip(&draft.places);
    all.filter(|(joint, _)| joint.drive.is_some() && wanted(joint)).collect()
}

/// A drive without a known continuous torque: it is then unknown for how long the arm can hold itself.
fn no_rating(draft: &Draft) -> Option<Finding> {
    let without = driven(draft, |joint| joint.heat.rated.is_none());
    let (_, first) = without.first()?;
    let problem = format!(
        "no rated torque of {}: how long the motor holds a load is unknown",
        names(without.iter().map(|(joint, _)| *joint))
    );
    let advice =
        "write heat = { rated, peak } with the continuous and the greatest torque of the data sheet, at the joint"
            .to_owned();
    Some(Finding::new(draft, (CheckRule::Heat, Severity::Note), &first.heat, problem, advice))
}

/// A motor without a known time constant: its heat cannot be followed.
fn no_time_constant(draft: &Draft) -> Option<Finding> {
    let without = driven(draft, |joint| joint.heat.rated.is_some() && joint.heat.time_constant.is_none());
    let (_, first) = without.first()?;
    let problem = format!(
        "no thermal time constant of {}: the motor's heat is unknown",
        names(without.iter().map(|(joint, _)| *joint))
    );
    let advice = "write heat = { time_constant } in s: hold the rated torque from cold, and take the time to 63 % of the final rise of \
                  temperature"
        .to_owned();
    Some(Finding::new(draft, (CheckRule::Heat, Severity::Note), &first.heat, problem, advice))
}

/// Continuous torque of a motor, compared with the largest load of gravity: `rated < max |G_i(q)|`.
///
/// A doubt, because an arm need not stay in its worst posture. There the heat rises to `(G / rated)^2` times the motor's continuous limit.
fn continuous(draft: &Draft, joint: &RobotJoint, places: &JointPlaces, load: &JointLoad) -> Option<Finding> {
    let rated = joint.heat.rated.filter(|rated| *rated < load.holding)?;
    let unit = Units::of(joint).torque;
    let q: Vec<String> = load.posture.iter().map(|q| format!("{q:.3}")).collect();
    let problem = format!(
        "takes {} to hold still at q = {}, and the motor gives {} for ever: its heat would settle at {} of what it bears",
        amount(load.holding, unit),
        q.join(","),
        amount(rated, unit),
        percent((load.holding / rated).powi(2))
    );
    let advice =
        "let the arm rest elsewhere, narrow the positions, or take a motor with more continuous torque".to_owned();
    Some(Finding::new(draft, (CheckRule::Heat, Severity::Doubt), &places.heat, problem, advice))
}

/// A joint that sinks from the rest pose: gravity's torque exceeds its Coulomb friction, and there is no stop on the side to which gravity pushes.
fn sinks(draft: &Draft, index: usize, joint: &RobotJoint, places: &JointPlaces, load: &JointLoad) -> Option<Finding> {
    let (held, q) = (load.rest?, *draft.robot.rest.as_ref()?.get(index)?);
    let friction = joint.friction.map_or(0.0, |friction| friction.coulomb);
    let (lo, hi) = joint.spec.limits.position;
    let near = on_stop_distance(joint.spec.kind);
    // A torque above zero holds a joint that gravity moves towards its lower limit.
    let on_stop = if held > 0.0 { q - lo <= near } else { hi - q <= near };
    (held.abs() > friction && !on_stop).then(|| {
        let unit = Units::of(joint);
        let problem = format!(
            "{} sinks from the rest pose: it takes {} to hold, its friction is {}, and the limit that gravity pushes it to, {}, is {} away",
            joint.name,
            amount(held.abs(), unit.torque),
            amount(friction, unit.torque),
            amount(if held > 0.0 { lo } else { hi }, unit.position),
            amount(if held > 0.0 { q - lo } else { hi - q }, unit.position)
        );
        let advice = "choose a pose in which friction holds each joint, or in which gravity presses it onto a stop".to_owned();
        Finding::new(draft, (CheckRule::Rest, Severity::Note), &places.rest, problem, advice)
    })
}
