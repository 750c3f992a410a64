//! Estimated payload of the arm, in the tip frame.

use super::subject::Subject;
use identification::identify::{Identified, Settings, TORQUE_CUTOFF};
use identification::log::Log;
use identification::payload::{Known, Payload, torque_scale};
use identification::prepare::Filters;
use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};

/// Relative standard deviation of the torque scale: of currents times a data-sheet constant, and of torques in N m.
const TORQUE_DEVIATION: (f64, f64) = (0.1, 0.02);
/// Half-width of the reported interval, in standard deviations.
const WIDE: f64 = 1.96;

/// Estimates the payload relative to an arm that was identified before.
#[must_use]
pub fn against(subject: &Subject, found: &Identified, logs: &[Log], deviation: Option<f64>) -> Payload {
    weighed(subject, &Known::of(found), logs, deviation)
}

/// Estimates the payload relative to the robot file's values.
#[must_use]
pub fn against_file(subject: &Subject, logs: &[Log], settings: &Settings, deviation: Option<f64>) -> Payload {
    let rate = logs.iter().map(Log::rate).fold(f64::MAX, f64::min);
    let torque = settings.torque_cutoff.unwrap_or(TORQUE_CUTOFF).min(0.2 * rate);
    let filters = Filters { motion: settings.motion_cutoff.unwrap_or(torque), torque };
    let joints = &subject.robot.joints;
    let friction: Vec<(f64, f64)> = joints
        .iter()
        .map(|joint| joint.friction.map_or((0.0, 0.0), |friction| (friction.viscous, friction.coulomb)))
        .collect();
    let known = Known::of_numbers(subject.arm.as_ref(), &subject.parameters, &friction, filters);
    // The file's masses are taken as exact, so they cannot correct the torque scale.
    let scale = (1.0, deviation.unwrap_or(TORQUE_DEVIATION.1));
    known.payload(subject.arm.as_ref(), logs, scale)
}

fn weighed(subject: &Subject, known: &Known, logs: &[Log], deviation: Option<f64>) -> Payload {
    let current = logs.iter().any(|log| log.from_current);
    let usual = if current { TORQUE_DEVIATION.0 } else { TORQUE_DEVIATION.1 };
    let arm = subject.arm.as_ref();
    let scale = torque_scale(arm, known, &subject.maker, deviation.unwrap_or(usual));
    known.payload(arm, logs, scale)
}

/// Centre of mass and inertia in the tip frame.
fn at_tip(payload: &Payload, subject: &Subject) -> (Option<Vector3<f64>>, Matrix3<f64>) {
    let Some(joint) = subject.robot.joints.last() else { return (None, payload.inertia) };
    let (rotation, translation) = (subject.robot.tool.rotation, subject.robot.tool.translation);
    let link_from_body = joint.spec.frame.link_from_body();
    let turn = (link_from_body.rotation * rotation).transpose();
    let origin = link_from_body.rotation * translation + link_from_body.translation;
    (payload.com.map(|com| turn * (com - origin)), turn * payload.inertia * turn.transpose())
}

/// Result as JSON: `{"payload": {..}}`.
#[must_use]
pub fn json(payload: &Payload, subject: &Subject) -> Value {
    let (com, i) = at_tip(payload, subject);
    let half = WIDE * payload.mass_deviation;
    json!({ "payload": {
        "mass": payload.mass,
        "mass_deviation": payload.mass_deviation,
        "mass_interval_95": [payload.mass - half, payload.mass + half],
        "mass_as_the_torques_say": payload.unscaled,
        "mass_as_the_torques_say_deviation": payload.unscaled_deviation,
        "torque_scale": payload.scale.0,
        "torque_scale_deviation": payload.scale.1,
        "com": com.map(|c| c.as_slice().to_vec()),
        "com_deviation": payload.com_deviation.as_slice(),
        "inertia": { "xx": i.m11, "yy": i.m22, "zz": i.m33, "xy": i.m12, "xz": i.m13, "yz": i.m23 },
        "rms": payload.rms,
    }})
}

/// Result as text.
#[must_use]
pub fn text(payload: &Payload, subject: &Subject) -> String {
    let half = WIDE * payload.mass_deviation;
    let (com, i) = at_tip(payload, subject);
    let place = com.map_or_else(
        || "no mass that the log could tell from none".to_owned(),
        |c| {
            format!(
                "at {:.4}, {:.4}, {:.4} m of the tip; xx {:.2e}, yy {:.2e}, zz {:.2e} kg m^2 about it",
                c.x, c.y, c.z, i.m11, i.m22, i.m33
            )
        },
    );
    format!(
        "payload             {:.3} kg, 95 %: {:.3} to {:.3}; {place}\n\
         \u{20}                   as the torques say {:.3} +- {:.3} kg; their scale {:.3} +- {:.3} by the maker's masses\n",
        payload.mass,
        payload.mass - half,
        payload.mass + half,
        payload.unscaled,
        payload.unscaled_deviation,
        payload.scale.0,
        payload.scale.1,
    )
}
