//! Settings of a scene that matter to a person near an arm with drives.

use super::amount::digits;
use super::{CheckRule, Finding, Severity, units};
use crate::describe::diagnostics::FileError;
use crate::describe::draft::{bones, skeleton};
use crate::describe::scene::{FIRST_MOTION, SceneFile};
use dynamics_core::safety::{LiveInput, SafeAction};
use dynamics_core::{Body, Term};
use nalgebra::Vector3;
use std::path::Path;

/// Doubts about gravity and payload, and notes on the safety settings of a scene: a first motion without limits, and live inputs without
/// an age limit. The notes are given only for an arm with drives, which moves something real.
#[must_use]
pub fn scene_findings(scene: &SceneFile) -> Vec<Finding> {
    let mut found = Vec::new();
    if let Term::Constant(gravity) = scene.model.gravity {
        found.extend(gravity_finding(&scene.path, "model.gravity", &gravity, Some(scene.robot.gravity())));
    }
    found
        .extend(gravity_finding(&scene.path, "plant.gravity", &scene.plant.gravity, None).filter(|_| found.is_empty()));
    if let Term::Constant(body) = scene.model.payload {
        found.extend(payload(scene, "model.payload", &body));
    }
    if let Some(body) = scene.plant.payload {
        let alone = found.iter().all(|finding| finding.rule != CheckRule::Payload);
        found.extend(payload(scene, "plant.payload", &body).filter(|_| alone));
    }
    if scene.robot.joints.iter().any(|joint| joint.drive.is_some()) {
        found.extend(of_drives(scene));
    }
    found
}

/// A doubt about gravity: its magnitude is neither 0 nor 9.7 to 9.9 m/s^2, or its direction contradicts the robot file's
/// mounting.
#[must_use]
pub fn gravity_finding(
    path: &Path,
    field: &str,
    gravity: &Vector3<f64>,
    mounted: Option<Vector3<f64>>,
) -> Option<Finding> {
    let size = gravity.norm();
    let [x, y, z] = [gravity.x, gravity.y, gravity.z].map(digits);
    let (problem, advice) = if size > 0.0 && !(9.7..=9.9).contains(&size) {
        let cause = [(981.0, "cm/s^2"), (9810.0, "mm/s^2"), (1.0, "units of g"), (32.17, "ft/s^2")];
        let guess = cause.iter().find(|(unit, _)| (size / unit - 1.0).abs() < 0.02);
        let guess = guess.map_or(String::new(), |(_, unit)| format!(": in {unit}?"));
        (
            format!("({x}, {y}, {z}) is {} m/s^2{guess}", digits(size)),
            "write m/s^2: 9.81 on earth, (0, 0, 0) without gravity",
        )
    } else {
        let turned = mounted.filter(|g| (g - Vector3::new(0.0, 0.0, -9.81)).amax() > 1e-9)?;
        if size == 0.0 || gravity.dot(&turned) > 0.99 * size * turned.norm() {
            return None;
        }
        let [a, b, c] = [turned.x, turned.y, turned.z].map(digits);
        (
            format!("({x}, {y}, {z}), but the robot file's mounting has ({a}, {b}, {c})"),
            "leave the key out, or correct the mounting",
        )
    };
    let place = FileError::whole_file(path, field, problem, advice);
    Some(Finding { rule: CheckRule::Gravity, severity: Severity::Doubt, place, quote: None })
}

/// A payload whose mass centre is farther from the tip than the arm is long.
fn payload(scene: &SceneFile, field: &str, body: &Body) -> Option<Finding> {
    let model = skeleton(&scene.robot);
    let length: f64 = bones(&model).iter().map(|bone| bone.end.norm()).sum();
    let far = body.com.norm();
    (body.mass > 0.0 && far > length.max(0.2)).then(|| {
        let problem = format!(
            "its mass centre is {} m from the tip of an arm of {} m{}",
            digits(far),
            digits(length),
            units::length(far, 0.1)
        );
        let advice = "write the mass centre in m, in the tip frame";
        let place = FileError::whole_file(&scene.path, field, problem, advice);
        Finding { rule: CheckRule::Payload, severity: Severity::Doubt, place, quote: None }
    })
}

/// Notes on the safety settings of an arm with drives.
fn of_drives(scene: &SceneFile) -> Vec<Finding> {
    let note = |rule, field: &str, problem: String, advice: String| Finding {
        rule,
        severity: Severity::Note,
        place: FileError::whole_file(&scene.path, field, problem, advice),
        quote: None,
    };
    let unlimited = scene.safety.first_motion.is_none().then(|| {
        note(
            CheckRule::FirstMotion,
            "safety.first_motion",
            "is 1: after homing the arm may use its full speed and torque at once, also with a wrong sign, zero or torque constant".into(),
            format!("leave the key out, for {FIRST_MOTION} of the limits until the operator enters `full-range`"),
        )
    });
    let live = scene.model.live_inputs();
    let ageless = (live != 0 && scene.safety.live_age.is_none()).then(|| {
        let names: Vec<&str> =
            LiveInput::ALL.into_iter().filter(|input| live & input.bit() != 0).map(live_input_name).collect();
        note(
            CheckRule::LiveAge,
            "safety.live_age_ms",
            format!(
                "no age limit for {}: a program that stops sending leaves its last values in force",
                names.join(", ")
            ),
            "write the longest time in ms between two frames of live inputs; `connect` sends four in that time".into(),
        )
    });
    unlimited
        .into_iter()
        .chain(ageless)
        .chain(
            brake_delay(scene)
                .map(|(problem, advice)| note(CheckRule::BrakeDelay, "safety.brake_delay_ms", problem, advice.into())),
        )
        .collect()
}

/// Problem and advice about the time that the brakes of a scene need.
fn brake_delay(scene: &SceneFile) -> Option<(String, &'static str)> {
    let safety = &scene.safety;
    match (safety.safe_action, safety.brake_delay_given) {
        (SafeAction::Brake, true) if safety.brake_delay == 0.0 => Some((
            "is 0: torque ends with the brakes' power, and the arm sags until they have engaged, at each `disarm` too"
                .into(),
            "write the longest time in ms that the brakes and their relay need, from the data sheet",
        )),
        (SafeAction::Brake, false) => Some((
            format!(
                "is not given: {:.0} ms is assumed; slower brakes let the arm sag at each `disarm`",
                1e3 * safety.brake_delay
            ),
            "write the longest time in ms that the brakes and their relay need, from the data sheet; without brakes choose another `safe_action`",
        )),
        _ => None,
    }
}

const fn live_input_name(input: LiveInput) -> &'static str {
    match input {
        LiveInput::Gravity => "gravity",
        LiveInput::Payload => "payload",
        LiveInput::TipWrench => "tip_wrench",
        LiveInput::Rotors => "rotor",
    }
}
