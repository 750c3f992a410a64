//! The table `[control]`.

use super::values::per_joint;
use crate::describe::diagnostics::FileError;
use crate::describe::robot::{Robot, RobotJoint};
use crate::describe::scene::{ControlSpec, DampingAt, IntegralSpec, TeachSpec};
use crate::names::name;
use crate::read::table::{Table, Value};
use dynamics_core::control::{ControlLaw, FeedbackInertia, SpringOwner};

pub(super) fn read(table: &Table<'_>, robot: &Robot) -> Result<ControlSpec, FileError> {
    // Scenes of earlier versions have this key; a list of the known keys would not say why it is not among them.
    if let Some(value) = table.get("kernel_memory") {
        return Err(value.error("the key is gone: the whole tick runs from RAM now", "no such key: delete this line"));
    }
    table.only(&[
        "rate",
        "law",
        "model_every",
        "model_between",
        "natural_frequency",
        "stiffness",
        "damping",
        "damping_at",
        "trig",
        "scalar",
        "kernel",
        "observer_bandwidth",
        "integral",
        "teach",
        "age_max",
        "guard",
        "tunable",
    ])?;
    let mut control = ControlSpec::default_for(robot);
    let number = |key, max, expected, default| table.get(key).map_or(Ok(default), |v| v.positive_up_to(max, expected));
    control.rate = number("rate", 1e5, "a rate in Hz, above zero and at most 1e5", control.rate)?;
    let bandwidth = "a bandwidth in rad/s, above zero and at most 1e6";
    control.observer_bandwidth = number("observer_bandwidth", 1e6, bandwidth, control.observer_bandwidth)?;
    if let Some(value) = table.get("tunable") {
        control.tunable = value.boolean()?;
    }
    if let Some(value) = table.get("law") {
        control.law = value.named()?;
        if let Some(joint) = without_loop(robot, control.law) {
            let problem = format!("the joint {:?} has no drive with a position loop of its own", joint.name);
            return Err(
                value.error(problem, "a [joint.drive] of kind mit, damiao, robstride or myactuator for every joint")
            );
        }
    }
    if let Some(value) = table.get("model_every") {
        control.model_every = value.count(1000, "a whole number of ticks, 1 to 1,000")?;
    }
    if let Some(value) = table.get("model_between") {
        control.model_between = value.named()?;
        if table.get("model_every").is_none() {
            let problem = "the model is evaluated in every tick, and nothing is between";
            return Err(value.error(problem, "`model_every` beside it, the ticks from one evaluation to the next"));
        }
    }
    if let Some(value) = table.get("trig") {
        control.trig = value.named()?;
    }
    if let Some(value) = table.get("scalar") {
        control.scalar = value.named()?;
    }
    if let Some(value) = table.get("kernel") {
        control.kernel = value.named()?;
    }
    if let Some(value) = table.get("natural_frequency") {
        let one = |value: &Value<'_>| value.positive_up_to(1e4, "a frequency in rad/s, above zero and at most 1e4");
        control.natural_frequency = per_joint(&value, robot, "a frequency in rad/s", one)?;
    }
    if let Some(value) = table.get("stiffness") {
        control.stiffness = Some(stiffness(table, &value, robot, control.law)?);
    }
    if let Some(value) = table.get("damping") {
        let one = |value: &Value<'_>| value.positive_up_to(1e3, "a damping ratio, above zero and at most 1e3");
        control.damping = per_joint(&value, robot, "a damping ratio", one)?;
    }
    if let Some(value) = table.get("damping_at") {
        control.damping_at = value.choice(&[("start", DampingAt::Start), ("posture", DampingAt::Posture)])?;
        if !(control.tunable || control.law.traits().spring != SpringOwner::Nobody) {
            let expected = "`law = \"impedance\"` or \"split\", or no such key";
            return Err(value.error(format!("given beside the law {:?}", name(control.law)), expected));
        }
    }
    if let Some(integral) = table.get("integral").filter(|_| control.stiffness.is_some()) {
        let expected = "one of the two: integral action ends where the error does, however soft the spring";
        return Err(integral.error("given beside `stiffness`", expected));
    }
    if let Some(table) = table.table("integral")? {
        control.integral = Some(integral(&table, robot, &control)?);
    }
    let changes = control.law.is_hand_guided() || control.tunable;
    if let Some(value) = table.get("teach").filter(|_| !changes) {
        let expected = "`law = \"teach\"`, `tunable = true`, or no such table";
        return Err(value.error(format!("given beside the law {:?}", name(control.law)), expected));
    }
    if let Some(value) = table.get("integral").filter(|_| control.law.is_hand_guided()) {
        return Err(value.error("a hand-guided arm has no error to remove", "no `integral` beside this law"));
    }
    if control.law.is_hand_guided() || table.get("teach").is_some() {
        control.teach = Some(teach(table.table("teach")?.as_ref(), robot)?);
    }
    if let Some(value) = table.get("age_max") {
        // Bounded later, by the motion during that time, once `safety.reach` is known.
        control.age_max = value.whole(u64::from(u32::MAX), "a whole number of ticks")? as u32;
    }
    if let Some(guard) = table.table("guard")? {
        guard.only(&["position_margin", "velocity_factor"])?;
        if let Some(value) = guard.get("position_margin") {
            control.position_margin = value.not_negative("a margin in rad or m, zero or more")?;
        }
        if let Some(value) = guard.get("velocity_factor") {
            control.velocity_factor = value.at_least(1.0, "a factor of at least 1 on the velocity limit")?;
        }
    }
    Ok(control)
}

/// The first joint whose drive lacks the loop that the law needs.
fn without_loop(robot: &Robot, law: ControlLaw) -> Option<&RobotJoint> {
    robot.joints.iter().find(|joint| law.traits().spring == SpringOwner::Drive && !joint.has_own_loop())
}

/// Stiffness of the joints, for the laws with a spring at each joint.
fn stiffness(table: &Table<'_>, value: &Value<'_>, robot: &Robot, law: ControlLaw) -> Result<Vec<f64>, FileError> {
    if law.traits().feedback == FeedbackInertia::Model {
        let expected = "`law = \"impedance\"`, or `natural_frequency` in its place";
        return Err(value.error(format!("given beside the law {:?}", name(law)), expected));
    }
    if let Some(frequency) = table.get("natural_frequency") {
        return Err(frequency.error("given beside `stiffness`", "one of the two: each follows from the other"));
    }
    const EXPECTED: &str = "a stiffness in N m/rad or N/m, above zero and at most 1e6";
    per_joint(value, robot, EXPECTED, |value| value.positive_up_to(1e6, EXPECTED))
}

/// Least integral time, as a multiple of the shortest stable one, `1 / Kd`: the inertia of a posture may be this much
/// larger than that of the motion's start.
const TIME_MARGIN: f64 = 4.0;

fn integral(table: &Table<'_>, robot: &Robot, control: &ControlSpec) -> Result<IntegralSpec, FileError> {
    table.only(&["time", "torque", "dead_band"])?;
    const TIME: &str = "the integral time, s, above zero and at most 1e4";
    let value = table.require("time", TIME)?;
    let time = value.positive_up_to(1e4, TIME)?;
    let velocity_gain = |(frequency, damping): (&f64, &f64)| 2.0 * damping * frequency;
    let least = control.natural_frequency.iter().zip(&control.damping).map(velocity_gain).fold(f64::INFINITY, f64::min);
    let shortest = TIME_MARGIN / least;
    if time < shortest {
        let expected = format!("at least {shortest:.3} s, {TIME_MARGIN} times the shortest stable one at these gains");
        return Err(value.error(format!("found {time}"), &expected));
    }
    const TORQUE: &str = "the greatest torque of the integral action, N m or N, above zero";
    let value = table.require("torque", TORQUE)?;
    let torque = per_joint(&value, robot, TORQUE, |value| value.positive_up_to(1e9, TORQUE))?;
    for (joint, torque) in robot.joints.iter().zip(&torque) {
        let limit = joint.spec.limits.torque;
        if *torque > limit {
            let problem = format!("found {torque}, the torque limit of {:?} is {limit}", joint.name);
            return Err(value.error(problem, "no more than each joint's torque limit"));
        }
    }
    const BAND: &str = "a dead band, rad or m, zero or more";
    let dead_band = match table.get("dead_band") {
        Some(value) => per_joint(&value, robot, BAND, |value| value.not_negative(BAND))?,
        // Within a count the sign of an error is unknown.
        None => robot.joints.iter().map(|joint| joint.per_count().unwrap_or(0.0)).collect(),
    };
    Ok(IntegralSpec { time, torque, dead_band })
}

fn teach(table: Option<&Table<'_>>, robot: &Robot) -> Result<TeachSpec, FileError> {
    let mut spec = TeachSpec::default_for(robot);
    let Some(table) = table else { return Ok(spec) };
    table.only(&["friction", "still_speed", "breakaway", "drag", "speed", "wall"])?;
    if let Some(value) = table.get("friction") {
        let expected = "a share of the friction, 0 to 1";
        spec.friction = value.not_negative(expected)?;
        if spec.friction > 1.0 {
            return Err(value.error(format!("found {}", spec.friction), expected));
        }
    }
    let list = |key, expected: &str, zero: bool, default: &mut Vec<f64>| -> Result<(), FileError> {
        let Some(value) = table.get(key) else { return Ok(()) };
        let one =
            |value: &Value<'_>| if zero { value.not_negative(expected) } else { value.positive_up_to(1e6, expected) };
        *default = per_joint(&value, robot, expected, one)?;
        Ok(())
    };
    list("still_speed", "a speed in rad/s or m/s, above zero", false, &mut spec.still_speed)?;
    list("breakaway", "a torque in N m or N, zero or more", true, &mut spec.breakaway)?;
    list("drag", "a drag in N m s/rad or N s/m, above zero", false, &mut spec.drag)?;
    list("speed", "a speed in rad/s or m/s, above zero", false, &mut spec.speed)?;
    list("wall", "a distance in rad or m, zero or more", true, &mut spec.wall)?;
    for (index, joint) in robot.joints.iter().enumerate() {
        let limits = joint.spec.limits;
        let of_limit = [
            ("speed", spec.speed[index], limits.velocity, "velocity limit"),
            ("breakaway", spec.breakaway[index], limits.torque, "torque limit"),
            ("wall", spec.wall[index], 0.5 * limits.range(), "half of the range"),
        ];
        for (key, found, most, what) in of_limit {
            if let (true, Some(value)) = (found > most, table.get(key)) {
                let problem = format!("found {found}, the {what} of {:?} is {most}", joint.name);
                return Err(value.error(problem, format!("no more than each joint's {what}")));
            }
        }
    }
    Ok(spec)
}
