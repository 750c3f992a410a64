//! Numbers that seem to be in another unit: angles beyond a turn, and powers of ten.

use super::amount::{Units, amount, digits};
use super::{CheckRule, Finding, JointLoad, Severity};
use crate::describe::draft::{Draft, Place};
use dynamics_core::JointKind;
use std::f64::consts::TAU;

/// Largest plausible angle in radians: a turn, rounded.
const TURN: f64 = TAU * 1.003;
/// Longest arm, m: the arms of space stations measure 18 m.
pub(super) const LONGEST: f64 = 20.0;
/// Usual length of an arm, m, to choose between units.
const USUAL: f64 = 0.8;
/// Heaviest cube as long as the arm, kg/m^3, and lightest link that is judged by this, kg. The arms in `robots` and in `example-robot-data` that are
/// longer than 0.25 m have at most 20 kg/m^3; with masses in grams it is a thousand times that.
const DENSEST: (f64, f64) = (300.0, 50.0);
/// A pound, kg.
const POUND: f64 = 0.453_592_37;
/// Multiple of the arm's largest inertia beyond which a reflected rotor inertia is implausible.
const ROTOR_MOST: f64 = 30.0;
/// Multiple of gravity's torque beyond which a torque limit is in another unit, and the least such limit, N m.
const TORQUE_MOST: (f64, f64) = (300.0, 300.0);

/// Units of length in one metre.
const LENGTHS: [(f64, &str); 3] = [(1e3, "mm"), (1e2, "cm"), (39.37, "inches")];
/// Units of inertia in one kg m^2.
const INERTIAS: [(f64, &str); 6] =
    [(1e9, "g mm^2"), (1e7, "g cm^2"), (1e6, "kg mm^2"), (1e4, "kg cm^2"), (3417.0, "lb in^2"), (1e3, "g m^2")];

/// Units of rotors in data sheets, in one kg m^2.
const ROTORS: [(f64, &str); 3] = [(1e9, "g mm^2"), (1e7, "g cm^2"), (1e4, "kg cm^2")];

/// The unit in which a number is nearest to a usual one, and the number in SI units; `None` if no unit explains it.
fn guess<'a>(value: f64, usual: f64, units: &[(f64, &'a str)], spread: f64) -> Option<(&'a str, f64)> {
    let off = |scale: f64| (value / scale / usual).ln().abs();
    let best = units.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)))?;
    (value > 0.0 && usual > 0.0 && off(best.0) < spread.ln()).then(|| (best.1, value / best.0))
}

/// Returns "; is it in mm? Then it is 0.3 m", or nothing.
pub(super) fn length(value: f64, usual: f64) -> String {
    guess(value, usual, &LENGTHS, 10.0)
        .map_or(String::new(), |(unit, length)| format!("; in {unit}? Then it is {}", amount(length, "m")))
}

/// As [`length`] for a moment of inertia, kg m^2.
pub(super) fn inertia(value: f64, usual: f64) -> String {
    guess(value, usual, &INERTIAS, 30.0)
        .map_or(String::new(), |(unit, moment)| format!("; in {unit}? Then it is {}", amount(moment, "kg m^2")))
}

/// As [`length`] for a speed: rpm or degrees a second.
pub(super) fn speed(value: f64) -> String {
    let (rpm, degrees) = (value * TAU / 60.0, value.to_radians());
    format!("; in rpm ({} rad/s) or degrees a second ({} rad/s)?", digits(rpm), digits(degrees))
}

pub(super) fn findings(draft: &Draft, loads: Option<&[JointLoad]>) -> Vec<Finding> {
    let mut found: Vec<Finding> = arm_length(draft).into_iter().chain(grams(draft)).collect();
    found.extend(angles(draft));
    for ((joint, places), load) in draft.robot.joints.iter().zip(&draft.places).zip(loads.unwrap_or_default()) {
        let (low, high) = joint.spec.limits.position;
        let wide = [low, high].into_iter().filter(|q| q.is_finite()).fold(0.0_f64, |most, q| most.max(q.abs()));
        if joint.spec.kind == JointKind::Revolute && wide > TURN {
            found.push(angle(draft, &places.position, wide));
        }
        let most = loads.into_iter().flatten().map(|load| load.inertia.1).fold(0.0_f64, f64::max);
        let reflected = joint.spec.rotor.reflected();
        if most > 0.0 && reflected > ROTOR_MOST * most {
            found.push(large_rotor(
                draft,
                &places.rotor,
                joint.spec.rotor.inertia,
                joint.spec.rotor.gear,
                load.inertia.1,
            ));
        }
        let torque = joint.spec.limits.torque;
        let (share, least) = TORQUE_MOST;
        if joint.spec.kind == JointKind::Revolute
            && torque.is_finite()
            && torque > least
            && load.holding > super::load::NOTHING
            && torque > share * load.holding
        {
            let problem = format!(
                "{}, {} times what gravity needs at most; in N mm? Then it is {}",
                amount(torque, Units::of(joint).torque),
                digits(torque / load.holding),
                amount(torque / 1e3, Units::of(joint).torque)
            );
            let advice = "write the torque in N m that the actuator can give at the joint".to_owned();
            found.push(Finding::new(draft, (CheckRule::Unit, Severity::Doubt), &places.torque, problem, advice));
        }
    }
    found
}

/// Angles of placements and rows.
fn angles(draft: &Draft) -> Vec<Finding> {
    let large = draft.angles.iter().filter(|(_, angle)| angle.abs() > TURN);
    large.map(|(place, q)| angle(draft, place, q.abs())).collect()
}

/// An angle beyond a turn.
fn angle(draft: &Draft, place: &Place, angle: f64) -> Finding {
    let problem = format!(
        "an angle of {} rad, {} turns: degrees? {} degrees are {} rad",
        digits(angle),
        digits(angle / TAU),
        digits(angle),
        digits(angle.to_radians())
    );
    let advice = "write angles in rad".to_owned();
    Finding::new(draft, (CheckRule::Angle, Severity::Doubt), place, problem, advice)
}

/// An arm that is longer than any existing one.
fn arm_length(draft: &Draft) -> Option<Finding> {
    let all = draft.length();
    let first = draft.bodies.first()?;
    (all > LONGEST).then(|| {
        let guess = guess(all, USUAL, &LENGTHS, 10.0).map_or(String::new(), |(unit, length)| {
            format!(": is this file in {unit}? Then the arm is {} long", amount(length, "m"))
        });
        let place = Place { field: "lengths".to_owned(), ..first.com.clone() };
        let problem = format!("{} from the first joint to the tip{guess}", amount(all, "m"));
        let advice = "write all lengths in m: origins, mass centres, travels".to_owned();
        Finding::new(draft, (CheckRule::Unit, Severity::Wrong), &place, problem, advice)
    })
}

/// Masses in grams, or in pounds of a heavy arm.
///
/// All links together weigh more than [`DENSEST`] times the cube of the arm's length, in kg/m^3. Every link above the least mass is named: one
/// wrong link among right ones, or all of them.
fn grams(draft: &Draft) -> Vec<Finding> {
    let length = draft.length();
    let (density, least) = DENSEST;
    let most = density * length.powi(3);
    let total = draft.bodies.iter().map(|body| body.body.mass.max(0.0)).sum::<f64>();
    if length <= 0.0 || total <= most {
        return Vec::new();
    }
    let finding = |body: &crate::describe::draft::DraftBody| {
        let mass = body.body.mass;
        let grams = amount(mass / 1e3, "kg");
        let mut problem =
            format!("{} on an arm of {}: is it in grams? Then it is {grams}", amount(mass, "kg"), amount(length, "m"));
        if total * POUND <= most {
            problem += &format!("; in pounds, {}", amount(mass * POUND, "kg"));
        }
        Finding::new(draft, (CheckRule::Unit, Severity::Doubt), &body.mass, problem, "write masses in kg".to_owned())
    };
    draft.bodies.iter().filter(|body| body.body.mass > least).map(finding).collect()
}

/// A rotor that outweighs the arm.
fn large_rotor(draft: &Draft, place: &Place, inertia: f64, gear: f64, own: f64) -> Finding {
    let squared = gear * gear;
    let guess = guess(inertia, own.max(1e-3) / squared, &ROTORS, 1e3).map_or(String::new(), |(unit, moment)| {
        format!("; in {unit}? Then the joint feels {}", amount(moment * squared, "kg m^2"))
    });
    let problem = format!(
        "the joint feels {} of its rotor, {} times its links' {}{guess}",
        amount(inertia * squared, "kg m^2"),
        digits(inertia * squared / own.max(f64::MIN_POSITIVE)),
        amount(own, "kg m^2")
    );
    let advice = "write the inertia at the motor's shaft in kg m^2 (1 g cm^2 is 1e-7), or a gear of 1 if it is what the joint feels".to_owned();
    Finding::new(draft, (CheckRule::Rotor, Severity::Doubt), place, problem, advice)
}
