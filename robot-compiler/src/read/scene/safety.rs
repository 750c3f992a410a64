//! The table `[safety]`: conditions for torque, and the reaction when they are not met.

use super::values::per_joint;
use crate::describe::diagnostics::FileError;
use crate::describe::robot::Robot;
use crate::describe::scene::{ControlSpec, SafetySpec};
use crate::read::rest;
use crate::read::table::{Table, Value};
use dynamics_core::safety::SafeAction;

/// Longest time that a file may set, ms.
const TIME_MAX: f64 = 60_000.0;

/// Longest time that brakes may need to engage, ms: ten times that of slow brakes.
const BRAKE_DELAY_MAX: f64 = 1000.0;

/// Shortest such time, ms: no brake is that fast, so a smaller number is probably in seconds.
const BRAKE_DELAY_MIN: f64 = 5.0;

/// Smallest share of the first motion. Friction alone uses a few per cent of a joint's torque limit, so with less the arm would not move,
/// and would sink because of a small error of its model.
const FIRST_MOTION_MIN: f64 = 0.05;

pub(super) fn read(table: &Table<'_>, robot: &Robot, control: &ControlSpec) -> Result<SafetySpec, FileError> {
    table.only(&[
        "safe_action",
        "heartbeat_ms",
        "hold_ms",
        "brake_delay_ms",
        "latency_ms",
        "payload_mass",
        "payload_radius",
        "supply",
        "temperature",
        "jump_factor",
        "deceleration",
        "resolution",
        "rest_speed",
        "reach",
        "reach_speed",
        "damping",
        "rest",
        "lowering_tip_speed",
        "first_motion",
        "live_age_ms",
        "bench_only",
    ])?;
    let mut safety = SafetySpec::default_for(robot, control);
    if let Some(value) = table.get("safe_action") {
        safety.safe_action = value.choice(&[
            ("brake", SafeAction::Brake),
            ("damped-stop", SafeAction::DampedStop),
            ("off", SafeAction::Off),
        ])?;
    }
    if let Some(value) = table.get("heartbeat_ms") {
        safety.heartbeat = 1e-3 * value.positive_up_to(TIME_MAX, "a time in ms, above zero and at most 60,000")?;
    }
    if let Some(value) = table.get("hold_ms") {
        safety.hold = 1e-3 * value.within(0.0, TIME_MAX, "a time in ms, 0 to 60,000")?;
    }
    match table.get("brake_delay_ms") {
        Some(value) if safety.safe_action != SafeAction::Brake => {
            return Err(value.error(
                "given without brakes",
                "it only with `safe_action = \"brake\"`: remove it, or set `safe_action = \"brake\"` if the arm has brakes",
            ));
        }
        Some(value) => {
            let delay = value.within(0.0, BRAKE_DELAY_MAX, "a time in ms, 5 to 1,000, or 0")?;
            if delay > 0.0 && delay < BRAKE_DELAY_MIN {
                let expected = "a time in ms, 5 to 1,000, or 0: brakes need 20 to 100 ms. Is this number in seconds?";
                return Err(value.error(format!("{delay} ms"), expected));
            }
            (safety.brake_delay, safety.brake_delay_given) = (1e-3 * delay, true);
        }
        None if safety.safe_action != SafeAction::Brake => safety.brake_delay = 0.0,
        None => {}
    }
    if let Some(value) = table.get("latency_ms") {
        safety.latency = 1e-3 * value.within(0.0, TIME_MAX, "a time in ms, 0 to 60,000")?;
    }
    if let Some(value) = table.get("payload_mass") {
        safety.payload.mass = value.not_negative("a mass in kg, zero or more")?;
    }
    if let Some(value) = table.get("payload_radius") {
        safety.payload.radius = value.within(1e-3, 100.0, "a distance in m, 0.001 to 100")?;
    }
    safety.supply = bounds(table, "supply", "V", safety.supply)?;
    safety.temperature = bounds(table, "temperature", "degrees Celsius", safety.temperature)?;
    if let Some(value) = table.get("jump_factor") {
        safety.jump_factor = value.at_least(1.0, "a factor of at least 1 on the velocity limit")?;
    }
    let list = |key, what: &str, default: Vec<f64>, one: fn(&Value<'_>, &str) -> Result<f64, FileError>| {
        table.get(key).map_or(Ok(default), |value| per_joint(&value, robot, what, |value| one(value, what)))
    };
    let above = |value: &Value<'_>, what: &str| value.positive(what);
    let zero_or_more = |value: &Value<'_>, what: &str| value.not_negative(what);
    safety.deceleration =
        list("deceleration", "a deceleration in rad/s^2 or m/s^2, above zero", safety.deceleration, above)?;
    safety.resolution = list("resolution", "a resolution in rad or m, zero or more", safety.resolution, zero_or_more)?;
    safety.rest_speed = list("rest_speed", "a speed in rad/s or m/s, above zero", safety.rest_speed, above)?;
    safety.reach = list("reach", "a distance in rad or m, above zero", safety.reach, above)?;
    safety.reach_speed = list("reach_speed", "a speed in rad/s or m/s, above zero", safety.reach_speed, above)?;
    safety.damping = list("damping", "a damping of zero or more, N m s/rad or N s/m", safety.damping, zero_or_more)?;
    if let Some(value) = table.get("rest") {
        safety.rest = Some(rest::read(&value, &robot.joints)?);
    }
    if let Some(value) = table.get("lowering_tip_speed") {
        const EXPECTED: &str = "a speed of the tip in m/s, above zero and at most 0.25";
        safety.lowering_tip_speed = value.positive_up_to(LOWERING_TIP_SPEED_MAX, EXPECTED)?;
        if safety.rest.is_none() {
            return Err(value.error("given without `rest`", "`rest` beside it, or in the robot file"));
        }
    }
    if let Some(value) = table.get("first_motion") {
        const EXPECTED: &str = "a share of the limits, 0.05 to 1; 1 for no limit of the first motion. With less than 0.05, friction and a small \
                                error of the model use up all torque beyond the weight: the arm stands still or sinks";
        let share = value.within(FIRST_MOTION_MIN, 1.0, EXPECTED)?;
        safety.first_motion = (share < 1.0).then_some(share);
    }
    if let Some(value) = table.get("live_age_ms") {
        let age = 1e-3 * value.positive_up_to(TIME_MAX, "a time in ms, above zero and at most 60,000")?;
        // Allows for a message period of a whole number of ticks and for a few lost frames.
        if age < 4.0 / control.rate {
            let least = 4000.0 / control.rate;
            return Err(
                value.error(format!("{:.3} ms", 1e3 * age), format!("at least four control periods, {least:.3} ms"))
            );
        }
        safety.live_age = Some(age);
    }
    if let Some(value) = table.get("bench_only") {
        safety.bench_only = value.boolean()?;
    }
    Ok(safety)
}

/// Highest speed of the tip while the arm is lowered, m/s: the reduced speed of ISO 10218-1, 250 mm/s.
const LOWERING_TIP_SPEED_MAX: f64 = 0.25;

/// `[lo, hi]`, in ascending order.
fn bounds(table: &Table<'_>, key: &str, unit: &str, default: (f64, f64)) -> Result<(f64, f64), FileError> {
    let Some(value) = table.get(key) else { return Ok(default) };
    let expected = format!("[lowest, highest] in {unit}, the lower one first");
    match value.numbers(2, &expected)?[..] {
        [lo, hi] if lo < hi => Ok((lo, hi)),
        [lo, hi] => Err(value.error(format!("found {lo} to {hi}"), expected)),
        _ => Err(value.error("not two numbers", expected)),
    }
}
