//! The tables `[plant]`, `[sensors]` and `[actuators]`: the simulated world.

use super::{BODY, GRAVITY, WRENCH, payload, per_joint_text};
use crate::body_fields::wrench;
use crate::diagnostics::FileError;
use crate::reader::{Table, Value};
use crate::robot::Robot;
use crate::scene::{ActuatorSpec, ControlSpec, ModelSpec, PlantSpec, SensorSpec};
use nalgebra::Vector3;

pub(super) fn plant(
    table: &Table<'_>,
    robot: &Robot,
    model: &ModelSpec,
    control: &ControlSpec,
    start: &[f64],
) -> Result<PlantSpec, FileError> {
    table.only(&["step", "payload", "tip_wrench", "friction", "gravity", "start"])?;
    let mut plant = PlantSpec::default_for(robot, model, control, start);
    if let Some(value) = table.get("step") {
        plant.step = step(&value, 1.0 / control.rate)?;
    }
    if let Some(value) = table.get("payload") {
        plant.payload = absent_or(&value, BODY, payload)?;
    }
    if let Some(value) = table.get("tip_wrench") {
        plant.tip_wrench = absent_or(&value, WRENCH, |value| wrench(&value.table()?))?;
    }
    if let Some(value) = table.get("friction") {
        plant.friction = value.boolean()?;
        if plant.friction && robot.joints.iter().all(|joint| joint.friction.is_none()) {
            return Err(value.error("no joint of the robot has friction", "`friction` in the robot file, or false"));
        }
    }
    if let Some(value) = table.get("gravity") {
        plant.gravity = absent_or(&value, GRAVITY, |value| value.vector(GRAVITY))?.unwrap_or(Vector3::zeros());
    }
    if let Some(value) = table.get("start") {
        plant.start = value.numbers(robot.dof(), &per_joint_text(robot, "a position"))?;
        for (index, (item, q)) in value.array("")?.iter().zip(&plant.start).enumerate() {
            let (lo, hi) = robot.joints[index].spec.limits.position;
            if *q < lo || *q > hi {
                let label = Robot::joint_label(index, &robot.joints[index].name);
                return Err(item.error(format!("{q} is outside the limits of {label}"), format!("{lo} to {hi}")));
            }
        }
    }
    Ok(plant)
}

/// The control period must be a whole multiple of the plant's step.
fn step(value: &Value<'_>, period: f64) -> Result<f64, FileError> {
    let step = value.positive_up_to(period * (1.0 + 1e-9), "a step in s, at most the control period")?;
    let ratio = period / step;
    let expected = "a step that the control period is a whole multiple of, 1 to 10,000 times";
    if ratio > 10_000.5 || (ratio - ratio.round()).abs() > 1e-6 * ratio {
        return Err(value.error(format!("the control period {period} s is {ratio} times this"), expected));
    }
    Ok(step)
}

fn absent_or<T>(
    value: &Value<'_>,
    what: &str,
    present: impl FnOnce(&Value<'_>) -> Result<T, FileError>,
) -> Result<Option<T>, FileError> {
    if value.is_string() {
        value.choice_or(&[("absent", ())], what)?;
        return Ok(None);
    }
    present(value).map(Some)
}

pub(super) fn sensors(table: &Table<'_>, robot: &Robot) -> Result<SensorSpec, FileError> {
    table.only(&["encoder", "position_noise", "velocity_noise", "delay"])?;
    let mut sensors = SensorSpec::default();
    if let Some(value) = table.get("encoder") {
        sensors.encoder = value.boolean()?;
        let without = robot.joints.iter().position(|joint| joint.encoder.is_none());
        if let (true, Some(index)) = (sensors.encoder, without) {
            let label = Robot::joint_label(index, &robot.joints[index].name);
            let problem = format!("{label} has no encoder");
            return Err(value.error(problem, "`encoder = { counts_per_turn = ... }` on every joint of the robot"));
        }
    }
    let noise = |key, expected| table.get(key).map_or(Ok(0.0), |value| value.not_negative(expected));
    sensors.position_noise = noise("position_noise", "a noise of zero or more, rms in rad or m")?;
    sensors.velocity_noise = noise("velocity_noise", "a noise of zero or more, rms in rad/s or m/s")?;
    sensors.delay = delay(table)?;
    Ok(sensors)
}

pub(super) fn actuators(table: &Table<'_>) -> Result<ActuatorSpec, FileError> {
    table.only(&["saturation", "lag", "delay"])?;
    Ok(ActuatorSpec {
        saturation: table.get("saturation").map_or(Ok(false), |value| value.boolean())?,
        lag: table.get("lag").map_or(Ok(0.0), |value| value.not_negative("a time constant of zero or more, s"))?,
        delay: delay(table)?,
    })
}

fn delay(table: &Table<'_>) -> Result<u32, FileError> {
    let ticks = table.get("delay").map_or(Ok(0), |value| value.whole(1000, "a whole number of ticks, at most 1000"))?;
    Ok(ticks as u32)
}
