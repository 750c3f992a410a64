//! Rotors, friction, and the resolution of torque and position.

use super::amount::{Units, amount, digits, names, percent};
use super::load::NOTHING;
use super::{CheckRule, Finding, JointLoad, Severity};
use crate::describe::draft::{Draft, FileKind, JointPlaces, Place};
use crate::describe::drive::JointDrive;
use crate::describe::robot::RobotJoint;
use dynamics_core::JointKind;

/// Least share of a link's own inertia that a rotor after a gear reflects. A smaller share suggests that the gear was not squared.
const ROTOR_LEAST: f64 = 0.01;
/// Largest step, as a share of the worst load of gravity: with coarser ones the arm's weight cannot be held smoothly.
const STEP: f64 = 0.02;
/// Highest code of a position in a MIT-mode frame, of 16 bits.
const POSITION_CODES: f64 = 65535.0;

pub(super) fn findings(draft: &Draft, loads: Option<&[JointLoad]>) -> Vec<Finding> {
    let mut found: Vec<Finding> = [no_rotor(draft, loads), no_friction(draft)].into_iter().flatten().collect();
    for ((joint, places), load) in draft.robot.joints.iter().zip(&draft.places).zip(loads.unwrap_or_default()) {
        let steps = [small_rotor(draft, joint, places, load), torque_step(draft, joint, places, load)];
        found.extend(steps.into_iter().chain([position_step(draft, joint, places, load)]).flatten());
    }
    found
}

/// Joints of a kind, with their index and the positions of their fields in the file.
fn joints(draft: &Draft, wanted: impl Fn(&RobotJoint) -> bool) -> Vec<(usize, &RobotJoint, &JointPlaces)> {
    let all = draft.robot.joints.iter().zip(&draft.places).enumerate();
    all.filter(|(_, (joint, _))| wanted(joint)).map(|(i, (joint, places))| (i, joint, places)).collect()
}

/// Rotor inertia that is missing, and not declared ideal by `rotor = { inertia = 0, gear = 1 }` or the key `ideal`.
///
/// The joint feels `gear^2 J` in addition to the link's own `D_ii`. On geared arms both are of similar size, and at the wrist the rotor's
/// is larger.
fn no_rotor(draft: &Draft, loads: Option<&[JointLoad]>) -> Option<Finding> {
    let urdf = draft.kind == FileKind::Urdf;
    let declared = |places: &JointPlaces| !urdf && (places.rotor.given || draft.robot.ideal.is_some());
    let mut without = joints(draft, |joint| joint.spec.rotor.reflected() == 0.0);
    without.retain(|(_, _, places)| !declared(places));
    let (_, _, first) = without.first()?;
    let own = |(i, joint, _): &(usize, &RobotJoint, &JointPlaces)| {
        let (low, high) = loads?.get(*i)?.inertia;
        Some(format!("{} {} to {}", joint.name, digits(low), amount(high, Units::of(joint).inertia)))
    };
    let own: Option<Vec<String>> = without.iter().map(own).collect();
    let problem = match own {
        Some(own) => format!("no rotor inertia beside that of the links: {}", own.join(", ")),
        None => format!("no rotor inertia on {}", names(without.iter().map(|(_, joint, _)| *joint))),
    };
    let import = if urdf { "`newtau import`, then " } else { "" };
    let advice = format!(
        "{import}write rotor = {{ inertia, gear }}: J of the motor's data sheet, of which the joint feels gear^2 J, often as much as \
         the link has; or accelerate the joint with a known torque and take the link's share off"
    );
    Some(Finding::new(draft, (CheckRule::Rotor, Severity::Note), &first.rotor, problem, advice))
}

/// A rotor after a gear that adds almost nothing to its link: `gear^2 J < 0.01 min D_ii`.
fn small_rotor(draft: &Draft, joint: &RobotJoint, places: &JointPlaces, load: &JointLoad) -> Option<Finding> {
    let (rotor, least) = (joint.spec.rotor, load.inertia.0);
    let small = rotor.inertia > 0.0 && rotor.gear.abs() > 1.0 && rotor.reflected() < ROTOR_LEAST * least;
    small.then(|| {
        let unit = Units::of(joint).inertia;
        let problem = format!(
            "the joint feels {} of it, {} of the {} that its link has at least",
            amount(rotor.reflected(), unit),
            percent(rotor.reflected() / least),
            amount(least, unit)
        );
        let advice =
            "write the inertia at the motor's shaft in kg m^2 (1 g cm^2 is 1e-7), and the turns of the motor per turn \
                      of the joint"
                .to_owned();
        Finding::new(draft, (CheckRule::Rotor, Severity::Doubt), &places.rotor, problem, advice)
    })
}

/// Friction that is missing, and not declared ideal by `friction = {}` or the key `ideal`: geared joints lose a tenth or more of their torque to it.
fn no_friction(draft: &Draft) -> Option<Finding> {
    let urdf = draft.kind == FileKind::Urdf;
    let declared = |places: &JointPlaces| !urdf && (places.friction.given || draft.robot.ideal.is_some());
    let mut without = joints(draft, |joint| joint.friction.is_none());
    without.retain(|(_, _, places)| !declared(places));
    let (_, _, first) = without.first()?;
    let problem = format!("no friction on {}", names(without.iter().map(|(_, joint, _)| *joint)));
    let advice = "turn each joint at two steady speeds, both ways; half the difference of the torques is coulomb + viscous x speed"
        .to_owned();
    Some(Finding::new(draft, (CheckRule::Friction, Severity::Note), &first.friction, problem, advice))
}

/// A step of the drive's torque that is coarse compared with the load: `|ratio| (highest - lowest) / (2^bits - 1) > 0.02 max |G_i|`.
fn torque_step(draft: &Draft, joint: &RobotJoint, places: &JointPlaces, load: &JointLoad) -> Option<Finding> {
    let Some(JointDrive::Mit(drive)) = joint.drive else { return None };
    let step = drive.ratio.abs() * (drive.torque.1 - drive.torque.0)
        / (f64::from(1_u32 << drive.protocol.facts().torque_bits) - 1.0);
    let advice = "narrow the torque range in the actuator and here, or gear it up";
    coarse(draft, (CheckRule::TorqueStep, &places.drive_torque), (joint, load), step, advice)
}

/// A step of the measured position that is coarse compared with the load.
///
/// Gravity changes by at most about `max |G_i|` per radian, so a step of 0.02 rad is 2 % of it.
fn position_step(draft: &Draft, joint: &RobotJoint, places: &JointPlaces, load: &JointLoad) -> Option<Finding> {
    let counted = joint.per_count().map(|step| (step, &places.encoder));
    let (step, place) = match joint.drive {
        Some(JointDrive::Mit(drive)) => {
            let range = drive.position.1 - drive.position.0;
            (range / POSITION_CODES / drive.ratio.abs(), &places.drive_position)
        }
        _ => counted?,
    };
    let torque = step * load.holding;
    let turns = joint.spec.kind == JointKind::Revolute;
    let advice = "write the counts of a whole turn of the joint, four for each line of the encoder, times the gear";
    turns.then(|| coarse(draft, (CheckRule::PositionStep, place), (joint, load), torque, advice)).flatten()
}

/// A step of torque beyond [`STEP`] of the worst load.
fn coarse(
    draft: &Draft,
    (rule, place): (CheckRule, &Place),
    (joint, load): (&RobotJoint, &JointLoad),
    step: f64,
    advice: &str,
) -> Option<Finding> {
    // Friction holds a weight below this torque, however coarse the step.
    let held = joint.friction.map_or(NOTHING, |friction| friction.coulomb.max(NOTHING));
    (load.holding > held && step > STEP * load.holding).then(|| {
        let unit = Units::of(joint).torque;
        let problem = format!(
            "a step is {}, {} of the {} of gravity in the worst posture",
            amount(step, unit),
            percent(step / load.holding),
            amount(load.holding, unit)
        );
        Finding::new(draft, (rule, Severity::Doubt), place, problem, advice.to_owned())
    })
}
