//! The `[sensors]` and `[actuators]` tables of a scene.

use super::values::per_joint;
use crate::describe::diagnostics::FileError;
use crate::describe::robot::Robot;
use crate::describe::scene::{
    ActuatorSpec, ControlSpec, DriveFailure, FailureKind, PlantSpec, Ripple, SensorSpec, Side,
};
use crate::read::table::{Table, Value};

pub(super) fn sensors(
    table: &Table<'_>,
    robot: &Robot,
    plant: &PlantSpec,
    control: &ControlSpec,
) -> Result<SensorSpec, FileError> {
    table.only(&["encoder", "position_noise", "velocity_noise", "delay", "side", "jitter"])?;
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
    sensors.jitter = jitter(table, control)?;
    if let Some(value) = table.get("side") {
        sensors.side = value.choice(&[("motor", Side::Motor), ("link", Side::Link)])?;
        if plant.elasticity.is_none() {
            return Err(value.error("the joints are rigid: both sides are one", "`elasticity` in [plant]"));
        }
    }
    Ok(sensors)
}

pub(super) fn actuators(table: &Table<'_>, robot: &Robot, control: &ControlSpec) -> Result<ActuatorSpec, FileError> {
    table.only(&[
        "ideal",
        "loop_rate",
        "failure",
        "torque_factor",
        "saturation",
        "lag",
        "delay",
        "ripple",
        "jitter",
    ])?;
    let ideal = table.get("ideal").map_or(Ok(false), |value| value.boolean())?;
    simulated(table, robot, ideal)?;
    let default = ActuatorSpec::default();
    Ok(ActuatorSpec {
        ideal,
        loop_rate: table.get("loop_rate").map_or(Ok(default.loop_rate), |value| loop_rate(&value, control))?,
        failure: table.table("failure")?.map(|table| failure(&table, robot)).transpose()?,
        torque_factor: table.get("torque_factor").map_or(Ok(Vec::new()), |value| {
            const FACTOR: &str = "the true torque as a multiple of what the frames say, above zero and at most 100";
            per_joint(&value, robot, FACTOR, |value| value.positive_up_to(100.0, FACTOR))
        })?,
        saturation: table.get("saturation").map_or(Ok(false), |value| value.boolean())?,
        lag: table.get("lag").map_or(Ok(0.0), |value| value.not_negative("a time constant of zero or more, s"))?,
        delay: delay(table)?,
        ripple: table.table("ripple")?.map(|table| ripple(&table)).transpose()?,
        jitter: jitter(table, control)?,
    })
}

/// Keys of simulated drives; errors if drives are ideal.
pub(super) const SIMULATED: [&str; 3] = ["loop_rate", "failure", "torque_factor"];

/// Keys of ideal drives; errors if drives are simulated, because those have their own delay, torque limit and timing.
pub(super) const IDEAL: [&str; 3] = ["delay", "saturation", "jitter"];

/// Keys of ideal sensors; errors if drives are simulated, because the drives measure, and their replies have a fixed delay.
pub(super) const MEASURED: [&str; 3] = ["encoder", "delay", "jitter"];

/// True if the robot's drives are of a kind that can be simulated.
pub(super) fn has_simulated_drives(robot: &Robot) -> bool {
    robot.joints.iter().all(|joint| joint.drive.is_some_and(|drive| drive.mit().is_some()))
}

/// Rejects keys of `[actuators]` that do not match the drives.
pub(super) fn simulated(table: &Table<'_>, robot: &Robot, ideal: bool) -> Result<(), FileError> {
    let can_be = has_simulated_drives(robot);
    let simulated = can_be && !ideal;
    if let Some(value) = table.get("ideal").filter(|_| !can_be && !ideal) {
        let problem = "no drive of this robot can be simulated";
        return Err(value.error(problem, "`[joint.drive]` of kind \"mit\" on every joint of the robot"));
    }
    let keys = if simulated { &IDEAL[..] } else { &SIMULATED[..] };
    let Some(value) = keys.iter().find_map(|key| table.get(key)) else { return Ok(()) };
    Err(if simulated {
        value.error(
            "the robot's drives are simulated, with their own delay and ceiling",
            "`ideal = true` beside it, or not this key",
        )
    } else {
        value.error("the drives are ideal", "drives of kind \"mit\" in the robot file, and not `ideal = true`")
    })
}

/// Rejects keys of `[sensors]` that do not match simulated drives.
pub(super) fn sensed_by_drives(table: &Table<'_>, robot: &Robot, actuators: &ActuatorSpec) -> Result<(), FileError> {
    if actuators.ideal || !has_simulated_drives(robot) {
        return Ok(());
    }
    let Some(value) = MEASURED.iter().find_map(|key| table.get(key)) else { return Ok(()) };
    Err(value
        .error("the robot's drives are simulated, and they measure", "`ideal = true` in [actuators], or not this key"))
}

pub(super) fn loop_rate(value: &Value<'_>, control: &ControlSpec) -> Result<f64, FileError> {
    let expected = "a rate of the drives' own loop in Hz, at least the control rate and at most 1e6";
    value.within(control.rate, 1e6, expected)
}

pub(super) fn failure(table: &Table<'_>, robot: &Robot) -> Result<DriveFailure, FileError> {
    const KINDS: [(&str, FailureKind); 4] = [
        ("error", FailureKind::Error),
        ("unplugged", FailureKind::Unplugged),
        ("hot", FailureKind::Hot),
        ("under-voltage", FailureKind::UnderVoltage),
    ];
    table.only(&["joint", "at", "kind"])?;
    let dof = robot.joints.len();
    let joint = table.require("joint", "the number of a joint, from 1")?;
    let expected = format!("the number of a joint, 1 to {dof}");
    let number = joint.whole(dof as u64, &expected)?;
    if number == 0 {
        return Err(joint.error("found 0", expected));
    }
    const AT: &str = "a time of zero or more, s";
    Ok(DriveFailure {
        joint: number as usize - 1,
        at: table.require("at", AT)?.not_negative(AT)?,
        kind: table.require("kind", "what fails")?.choice(&KINDS)?,
    })
}

pub(super) fn delay(table: &Table<'_>) -> Result<u32, FileError> {
    let ticks = table.get("delay").map_or(Ok(0), |value| value.whole(1000, "a whole number of ticks, at most 1000"))?;
    Ok(ticks as u32)
}

/// A jitter, shorter than the control period.
pub(super) fn jitter(table: &Table<'_>, control: &ControlSpec) -> Result<f64, FileError> {
    const EXPECTED: &str = "a time of zero or more and below the control period, s";
    let Some(value) = table.get("jitter") else {
        return Ok(0.0);
    };
    let (jitter, period) = (value.not_negative(EXPECTED)?, 1.0 / control.rate);
    if jitter < period {
        Ok(jitter)
    } else {
        Err(value.error(format!("found {jitter}, and the control period is {period} s"), EXPECTED))
    }
}

pub(super) fn ripple(table: &Table<'_>) -> Result<Ripple, FileError> {
    table.only(&["share", "cycles"])?;
    const SHARE: &str = "an amplitude as a share of the torque, 0 to 1";
    const CYCLES: &str = "cycles per turn of the joint or per metre, above zero and at most 1e4";
    Ok(Ripple {
        share: table.require("share", SHARE)?.within(0.0, 1.0, SHARE)?,
        cycles: table.require("cycles", CYCLES)?.positive_up_to(1e4, CYCLES)?,
    })
}
