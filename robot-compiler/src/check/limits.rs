//! Limits of the joints: impossible, placeholders, missing, too wide.

use super::amount::{Units, amount, digits, names};
use super::{CheckRule, Finding, JointLoad, Severity};
use crate::describe::draft::{Draft, FileKind, JointPlaces, Place};
use crate::describe::robot::RobotJoint;
use dynamics_core::JointKind;
use std::f64::consts::TAU;

/// Fewest joints for which the same limit on all is remarkable.
const SAME: usize = 3;
/// Ratio of the largest and the smallest load of gravity beyond which one torque for all joints is no deliberate choice:
/// the sizes of one arm's actuators differ by factors of two to four.
const LOADS_DIFFER: f64 = 10.0;
/// Widest range of a turning joint, rad: cables allow two turns, hardly more.
const TURNS_WIDE: f64 = 2.0 * TAU;
/// Fastest turning joint, rad/s: about three turns a second, as the fastest industrial wrists. A larger number is probably the speed of a
/// motor without load, or the range of its frames.
const FAST: f64 = 20.0;
/// Fastest slide, m/s.
const FAST_SLIDE: f64 = 5.0;

const TORQUE: &str =
    "write the torque that the actuator can keep up at the joint: its data sheet, times the gear, less a margin";
const VELOCITY: &str = "write the speed that the joint may have: what the drive reaches under load, or less";

/// A joint, one of its limits, and the limit's position in the file.
struct JointPositions<'a> {
    spec: &'a RobotJoint,
    place: &'a Place,
    limit: f64,
    unit: &'static str,
}

impl<'a> JointPositions<'a> {
    fn torque(spec: &'a RobotJoint, place: &'a Place) -> Self {
        Self { spec, place, limit: spec.spec.limits.torque, unit: Units::of(spec).torque }
    }

    fn velocity(spec: &'a RobotJoint, place: &'a Place) -> Self {
        Self { spec, place, limit: spec.spec.limits.velocity, unit: Units::of(spec).velocity }
    }
}

pub(super) fn findings(draft: &Draft, loads: Option<&[JointLoad]>) -> Vec<Finding> {
    let all = || draft.robot.joints.iter().zip(&draft.places);
    let torques: Vec<_> = all().map(|(spec, at)| JointPositions::torque(spec, &at.torque)).collect();
    let velocities: Vec<_> = all().map(|(spec, at)| JointPositions::velocity(spec, &at.velocity)).collect();
    let positions =
        all().flat_map(|(joint, at)| [reversed(draft, joint, &at.position), wide(draft, joint, &at.position)]);
    let mut found: Vec<Finding> = positions.flatten().collect();
    found.extend(fast(draft, &velocities));
    found.extend(no_travel(draft));
    for (joints, advice) in [(&torques, TORQUE), (&velocities, VELOCITY)] {
        found.extend(not_positive(draft, joints, advice));
        found.extend(missing(draft, joints, advice));
    }
    found.extend(placeholder(draft, &torques, TORQUE).or_else(|| same(draft, &torques, loads)));
    found.extend(placeholder(draft, &velocities, VELOCITY));
    found
}

/// A limit of zero or below: no torque, no speed.
fn not_positive(draft: &Draft, joints: &[JointPositions<'_>], advice: &str) -> Vec<Finding> {
    let found = joints.iter().filter(|joint| joint.limit <= 0.0);
    let finding = |joint: &JointPositions<'_>| {
        let problem =
            format!("{}: with this limit the joint cannot work, and every other command refuses it", joint.limit);
        let kind = (CheckRule::ImpossibleLimit, Severity::Wrong);
        Finding::new(draft, kind, joint.place, problem, advice.to_owned())
    };
    found.map(finding).collect()
}

/// Position limits `[lo, hi]` with `lo >= hi`: no position is allowed.
fn reversed(draft: &Draft, joint: &RobotJoint, place: &Place) -> Option<Finding> {
    let (low, high) = joint.spec.limits.position;
    (low >= high).then(|| {
        let problem = format!("from {low} to {high} {}: there is no position between", Units::of(joint).position);
        let advice = "write the lowest and the highest position that the stops or the cables allow".to_owned();
        Finding::new(draft, (CheckRule::ImpossibleLimit, Severity::Wrong), place, problem, advice)
    })
}

/// Position limits of which one or both are missing. A joint that turns without an end declares it, in URDF by its type, in TOML by
/// `[-inf, inf]`.
fn no_travel(draft: &Draft) -> Option<Finding> {
    let all = draft.robot.joints.iter().zip(&draft.places);
    let missing = |(joint, place): &(&RobotJoint, &JointPlaces)| {
        let (low, high) = joint.spec.limits.position;
        let declared = match draft.kind {
            FileKind::Toml => place.position.given || draft.robot.ideal.is_some(),
            FileKind::Urdf => place.turns_on,
        };
        !(declared || low.is_finite() && high.is_finite())
    };
    let without: Vec<_> = all.filter(missing).collect();
    let (_, first) = without.first()?;
    let problem = format!("no position limits on {}", names(without.iter().map(|(joint, _)| *joint)));
    let advice = "write the lowest and the highest position, both, that the stops or the cables allow; [-inf, inf] for a joint that \
                  turns on"
        .to_owned();
    Some(Finding::new(draft, (CheckRule::MissingLimit, Severity::Note), &first.position, problem, advice))
}

/// Limits that are missing, for all joints together: nothing then bounds what the controller commands. In TOML, `inf` declares that there is
/// no limit.
fn missing(draft: &Draft, joints: &[JointPositions<'_>], advice: &str) -> Option<Finding> {
    let toml = draft.kind == FileKind::Toml;
    let declared = |joint: &&JointPositions<'_>| toml && (joint.place.given || draft.robot.ideal.is_some());
    let without: Vec<_> = joints.iter().filter(|joint| joint.limit == f64::INFINITY && !declared(joint)).collect();
    let first = without.first()?;
    let problem = format!("no limit on {}", names(without.iter().map(|joint| joint.spec)));
    Some(Finding::new(draft, (CheckRule::MissingLimit, Severity::Note), first.place, problem, advice.to_owned()))
}

/// The same power of ten on all joints: typical for exporters, and for people who do not know the limit.
fn placeholder(draft: &Draft, joints: &[JointPositions<'_>], advice: &str) -> Option<Finding> {
    let first = joints.first()?;
    let power = first.limit.log10();
    let all = joints.len() >= SAME && first.limit > 0.0 && joints.iter().all(|joint| equal(joint.limit, first.limit));
    (all && power.is_finite() && (power - power.round()).abs() < 1e-9).then(|| {
        let problem = format!("{} {} on all {} joints: a placeholder", first.limit, first.unit, joints.len());
        Finding::new(draft, (CheckRule::Placeholder, Severity::Doubt), first.place, problem, advice.to_owned())
    })
}

/// True if two numbers of a file are the same.
fn equal(a: f64, b: f64) -> bool {
    a.total_cmp(&b).is_eq()
}

/// One torque for all joints, though gravity loads them very differently.
///
/// `max G_i / min G_i > 10` over the joints that gravity loads, each in its worst posture.
fn same(draft: &Draft, joints: &[JointPositions<'_>], loads: Option<&[JointLoad]>) -> Option<Finding> {
    let first = joints.first()?;
    let alike =
        |joint: &JointPositions<'_>| equal(joint.limit, first.limit) && joint.spec.spec.kind == first.spec.spec.kind;
    if joints.len() < SAME || !first.limit.is_finite() || first.limit <= 0.0 || !joints.iter().all(alike) {
        return None;
    }
    let loaded = loads?.iter().map(|load| load.holding).filter(|torque| *torque > super::load::NOTHING);
    let (least, most) = loaded.fold((f64::INFINITY, 0.0_f64), |(lo, hi), torque| (lo.min(torque), hi.max(torque)));
    (most > LOADS_DIFFER * least).then(|| {
        let unit = first.unit;
        let problem = format!(
            "{} on all joints, though gravity loads them with {} to {}",
            amount(first.limit, unit),
            digits(least),
            amount(most, unit)
        );
        Finding::new(draft, (CheckRule::Placeholder, Severity::Doubt), first.place, problem, TORQUE.to_owned())
    })
}

/// A position range of a turning joint beyond two turns.
fn wide(draft: &Draft, joint: &RobotJoint, place: &Place) -> Option<Finding> {
    let (low, high) = joint.spec.limits.position;
    let (range, turns) = (high - low, joint.spec.kind == JointKind::Revolute);
    let turns = turns && low.abs().max(high.abs()) <= TAU * 1.003;
    // Limits of exactly two turns are rounded ones.
    (turns && range.is_finite() && range > TURNS_WIDE * (1.0 + 1e-6)).then(|| {
        let problem = format!("a range of {}, {} turns", amount(range, "rad"), digits(range / TAU));
        let advice =
            "write where the stops or the cables end the turn; a joint that turns on is without limits".to_owned();
        Finding::new(draft, (CheckRule::WideLimit, Severity::Doubt), place, problem, advice)
    })
}

/// Speeds that no arm has.
fn fast(draft: &Draft, joints: &[JointPositions<'_>]) -> Option<Finding> {
    let most = |joint: &JointPositions<'_>| if joint.spec.spec.kind == JointKind::Revolute { FAST } else { FAST_SLIDE };
    let fast: Vec<_> = joints.iter().filter(|joint| joint.limit.is_finite() && joint.limit > most(joint)).collect();
    let first = fast.first()?;
    let speeds: Vec<String> =
        fast.iter().map(|joint| format!("{} {}", joint.spec.name, amount(joint.limit, joint.unit))).collect();
    let turns = first.spec.spec.kind == JointKind::Revolute;
    let guess = if turns { super::units::speed(first.limit) } else { String::new() };
    let problem = format!("{}: arms stay below {} {}{guess}", speeds.join(", "), most(first), first.unit);
    Some(Finding::new(draft, (CheckRule::WideLimit, Severity::Doubt), first.place, problem, VELOCITY.to_owned()))
}
