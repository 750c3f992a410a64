//! The table `[plant]`: the simulated arm.

use super::values::{BODY, GRAVITY, WRENCH, payload, per_joint, per_joint_text};
use crate::describe::diagnostics::FileError;
use crate::describe::robot::Robot;
use crate::describe::scene::{ControlSpec, ElasticitySpec, Integrator, ModelSpec, PlantSpec, Push};
use crate::read::fields::wrench;
use crate::read::friction;
use crate::read::table::{Table, Value};
use nalgebra::Vector3;

/// Default tolerance of a step of the adaptive integrator.
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

/// Springs in the joints, and their backlash.
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
