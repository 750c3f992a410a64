//! Settings of a scene that matter to a person near an arm with drives.

use super::{Finding, Rule, Severity};
use crate::describe::diagnostics::FileError;
use crate::describe::scene::{FIRST_MOTION, SceneFile};
use dynamics_core::safety::{LiveInput, SafeAction};

/// Notes on the safety settings of a scene: a first motion without limits, and live inputs without an age limit. None for an arm without
/// drives, which moves nothing real.
#[must_use]
pub fn scene_findings(scene: &SceneFile) -> Vec<Finding> {
    if !scene.robot.joints.iter().any(|joint| joint.drive.is_some()) {
        return Vec::new();
    }
    let note = |rule, field: &str, problem: String, advice: String| Finding {
        rule,
        severity: Severity::Note,
        place: FileError::whole_file(&scene.path, field, problem, advice),
        quote: None,
    };
    let unlimited = scene.safety.first_motion.is_none().then(|| {
        note(
            Rule::FirstMotion,
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
            Rule::LiveAge,
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
                .map(|(problem, advice)| note(Rule::BrakeDelay, "safety.brake_delay_ms", problem, advice.into())),
        )
        .collect()
}

/// Problem and advice of the time that the brakes of a scene need.
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
