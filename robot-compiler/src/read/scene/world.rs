//! The tables `[plant]`, `[sensors]` and `[actuators]`: the simulated world.

use super::values::{BODY, GRAVITY, WRENCH, payload, per_joint, per_joint_text};
use crate::describe::diagnostics::FileError;
use crate::describe::robot::Robot;
use crate::describe::scene::{
    ActuatorSpec, ControlSpec, DriveFailure, ElasticitySpec, FailureKind, Integrator, ModelSpec, PlantSpec, Push,
    Ripple, SensorSpec, Side,
};
use crate::read::fields::wrench;
use crate::read::friction;
use crate::read::table::{Table, Value};
use nalgebra::Vector3;

/// Default error of a step of the adaptive integrator.
const TOLERANCE: f64 = 1e-9;

pub(super) fn plant(
    table: &Table<'_>,
    robot: &Robot,
    model: &ModelSpec,
    control: &ControlSpec,
    start: &[f64],
) -> Result<PlantSpec, FileError> {
    table.only(&[
        "integrator",
        "step",
        "tolerance",
        "masses",
        "payload",
        "tip_wrench",
        "push",
        "friction",
        "elasticity",
        "backlash",
        "rotor_coupling",
        "gravity",
        "start",
    ])?;
    let mut plant = PlantSpec::default_for(robot, model, control, start);
    plant.integrator = integrator(table)?;
    if let Some(value) = table.get("step") {
        plant.step = step(&value, 1.0 / control.rate)?;
    }
    if let Some(value) = table.get("masses") {
        const FACTOR: &str = "a factor on mass and inertia, above zero and at most 100";
        plant.masses = per_joint(&value, robot, FACTOR, |value| value.positive_up_to(100.0, FACTOR))?;
    }
    if let Some(value) = table.get("payload") {
        plant.payload = absent_or(&value, BODY, payload)?;
    }
    if let Some(value) = table.get("tip_wrench") {
        plant.tip_wrench = absent_or(&value, WRENCH, |value| wrench(&value.table()?))?;
    }
    plant.push = table.table("push")?.map(|table| push(&table)).transpose()?;
    if let Some(value) = table.get("friction").filter(Value::is_table) {
        plant.friction = true;
        plant.friction_law = Some(friction::of_joints(&value.table()?, robot)?);
    } else if let Some(value) = table.get("friction") {
        plant.friction = value.boolean()?;
        if plant.friction && robot.joints.iter().all(|joint| joint.friction.is_none()) {
            return Err(value.error("no joint of the robot has friction", "`friction` in the robot file, or false"));
        }
    }
    plant.elasticity = elasticity(table, robot)?;
    if let Some(value) = table.get("rotor_coupling") {
        plant.rotor_coupling = value.boolean()?;
        if plant.rotor_coupling && robot.joints.iter().all(|joint| joint.spec.rotor.inertia == 0.0) {
            return Err(value.error("no joint of the robot has a rotor", "`rotor` in the robot file, or false"));
        }
        if plant.rotor_coupling && plant.elasticity.is_some() {
            return Err(value.error("given beside `elasticity`", "rigid joints, or `rotor_coupling = false`"));
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

/// A wrench for a limited time.
fn push(table: &Table<'_>) -> Result<Push, FileError> {
    table.only(&["at", "duration", "wrench"])?;
    Ok(Push {
        at: table.require("at", "a time in s, zero or more")?.not_negative("a time in s, zero or more")?,
        duration: table.require("duration", "a time in s, above zero")?.positive("a time in s, above zero")?,
        wrench: wrench(&table.require("wrench", WRENCH)?.table()?)?,
    })
}

/// The integrator, and the settings that only one method has.
fn integrator(table: &Table<'_>) -> Result<Integrator, FileError> {
    let adaptive = Integrator::Adaptive { tolerance: TOLERANCE };
    let choices = [
        ("runge-kutta", Integrator::RungeKutta),
        ("semi-implicit-euler", Integrator::SemiImplicitEuler),
        ("adaptive", adaptive),
    ];
    let chosen = table.get("integrator").map_or(Ok(Integrator::default()), |value| value.choice(&choices))?;
    let (step, tolerance) = (table.get("step"), table.get("tolerance"));
    if chosen != adaptive {
        return match tolerance {
            Some(value) => Err(value.error("given without the adaptive integrator", "`integrator = \"adaptive\"`")),
            None => Ok(chosen),
        };
    }
    if let Some(value) = step {
        let problem = "given with the adaptive integrator, which chooses its own";
        return Err(value.error(problem, "`tolerance` instead, or another `integrator`"));
    }
    const EXPECTED: &str = "an error of a step, absolute and relative, 1e-12 to 1e-2";
    let tolerance = tolerance.map_or(Ok(TOLERANCE), |value| value.within(1e-12, 1e-2, EXPECTED))?;
    Ok(Integrator::Adaptive { tolerance })
}

/// Springs in the joints, and the play beside them.
fn elasticity(table: &Table<'_>, robot: &Robot) -> Result<Option<ElasticitySpec>, FileError> {
    const STIFFNESS: &str = "a stiffness above zero, N m/rad or N/m";
    const DAMPING: &str = "a damping of zero or more, N m s/rad or N s/m";
    const BACKLASH: &str = "a play of zero or more, rad or m";
    let backlash = table.get("backlash");
    let Some(value) = table.get("elasticity") else {
        return match backlash {
            // Rigid flanks would meet in a shock that no step size resolves.
            Some(value) => {
                Err(value.error("given without `elasticity`", "`elasticity`, the springs that the flanks meet"))
            }
            None => Ok(None),
        };
    };
    let springs = value.table()?;
    springs.only(&["stiffness", "damping"])?;
    if let Some(index) = robot.joints.iter().position(|joint| joint.spec.rotor.reflected() <= 0.0) {
        let label = Robot::joint_label(index, &robot.joints[index].name);
        let problem = format!("{label} has no rotor, so its motor side has no inertia");
        return Err(value.error(problem, "`rotor = { inertia = ..., gear = ... }` on every joint of the robot"));
    }
    let stiffness = springs.require("stiffness", STIFFNESS)?;
    let stiffness = per_joint(&stiffness, robot, STIFFNESS, |value| value.positive(STIFFNESS))?;
    let list = |value: Option<Value<'_>>, what: &str| {
        value.map(|value| per_joint(&value, robot, what, |value| value.not_negative(what))).transpose()
    };
    let damping = list(springs.get("damping"), DAMPING)?.unwrap_or_else(|| vec![0.0; robot.dof()]);
    Ok(Some(ElasticitySpec { stiffness, damping, backlash: list(backlash, BACKLASH)? }))
}

/// A jitter, shorter than the control period.
fn jitter(table: &Table<'_>, control: &ControlSpec) -> Result<f64, FileError> {
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

fn ripple(table: &Table<'_>) -> Result<Ripple, FileError> {
    table.only(&["share", "cycles"])?;
    const SHARE: &str = "an amplitude as a share of the torque, 0 to 1";
    const CYCLES: &str = "cycles per turn of the joint or per metre, above zero and at most 1e4";
    Ok(Ripple {
        share: table.require("share", SHARE)?.within(0.0, 1.0, SHARE)?,
        cycles: table.require("cycles", CYCLES)?.positive_up_to(1e4, CYCLES)?,
    })
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

/// Keys of simulated drives, refused where drives are ideal.
const SIMULATED: [&str; 3] = ["loop_rate", "failure", "torque_factor"];

/// Keys of ideal drives, refused where drives are simulated: those have their own delay, ceiling and instants.
const IDEAL: [&str; 3] = ["delay", "saturation", "jitter"];

/// Keys of ideal sensors, refused where drives are simulated: those measure, and their replies have one delay.
const MEASURED: [&str; 3] = ["encoder", "delay", "jitter"];

/// True if the robot's drives are of a kind that can be simulated.
fn has_simulated_drives(robot: &Robot) -> bool {
    robot.joints.iter().all(|joint| joint.drive.is_some_and(|drive| drive.mit().is_some()))
}

/// Refuse keys of `[actuators]` that do not go with the drives.
fn simulated(table: &Table<'_>, robot: &Robot, ideal: bool) -> Result<(), FileError> {
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

/// Refuse keys of `[sensors]` that do not go with simulated drives.
pub(super) fn sensed_by_drives(table: &Table<'_>, robot: &Robot, actuators: &ActuatorSpec) -> Result<(), FileError> {
    if actuators.ideal || !has_simulated_drives(robot) {
        return Ok(());
    }
    let Some(value) = MEASURED.iter().find_map(|key| table.get(key)) else { return Ok(()) };
    Err(value
        .error("the robot's drives are simulated, and they measure", "`ideal = true` in [actuators], or not this key"))
}

fn loop_rate(value: &Value<'_>, control: &ControlSpec) -> Result<f64, FileError> {
    let expected = "a rate of the drives' own loop in Hz, at least the control rate and at most 1e6";
    value.within(control.rate, 1e6, expected)
}

fn failure(table: &Table<'_>, robot: &Robot) -> Result<DriveFailure, FileError> {
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

fn delay(table: &Table<'_>) -> Result<u32, FileError> {
    let ticks = table.get("delay").map_or(Ok(0), |value| value.whole(1000, "a whole number of ticks, at most 1000"))?;
    Ok(ticks as u32)
}
