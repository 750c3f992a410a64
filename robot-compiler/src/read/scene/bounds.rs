//! Bounds of the numbers on which the safety state machine relies, each from what the arm can move or exert in that time.
//!
//! A number without a bound would give no protection: with `age_max = 100000` a joint would follow a measurement that is minutes
//! old. Each bound names its reason, and the error explains how it was computed.

use super::entries::{degrees, each, unit};
use crate::describe::diagnostics::FileError;
use crate::describe::robot::{Robot, RobotJoint};
use crate::describe::scene::SceneFile;
use crate::read::shown::short;
use crate::read::table::Table;
use crate::with_dof;
use dynamics_core::JointKind;

/// Greatest age of a measurement, ticks, if no velocity limit bounds the motion: the default.
const AGE_WITHOUT_LIMIT: u32 = 2;
/// Longest silence of the host, s: in this time a person who walks towards the arm at 1.6 m/s (ISO 13855) gets 1.6 m closer.
const HEARTBEAT_MAX: f64 = 1.0;
/// Greatest multiple of the velocity limit at which the guard acts. A stop from there takes 9 times the distance of one from the limit.
const VELOCITY_FACTOR_MAX: f64 = 3.0;
/// Heaviest payload, as a multiple of the arm's own moving mass: real arms carry less than their own mass, so ten times that is an error in the file.
const PAYLOAD_MAX: f64 = 10.0;
/// Speed that may always count as rest, and its share of the velocity limit, rad/s or m/s.
const REST_SPEED: (f64, f64) = (0.05, 0.1);
/// Highest supply voltage, V: above it begins high voltage (1,500 V DC, IEC 61140).
const SUPPLY_MAX: f64 = 1500.0;
/// Temperatures that a sensor in a motor can read, degrees Celsius: the hottest insulation class (C) begins at 180.
const TEMPERATURES: (f64, f64) = (-100.0, 200.0);

/// Farthest that a reference may be from its joint, and that a joint may be beyond its limit before the guard acts, rad or m.
const fn far(kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => 1.0,
        JointKind::Prismatic => 0.3,
    }
}

/// Checks the numbers in the file, and lowers the default of `control.age_max` if the joints are too fast for it.
pub(super) fn check(root: &Table<'_>, scene: &mut SceneFile) -> Result<(), FileError> {
    let (empty_control, empty_safety) = (root.empty("control"), root.empty("safety"));
    let control = root.table("control")?.unwrap_or(empty_control);
    let safety = root.table("safety")?.unwrap_or(empty_safety);
    age(&control, scene)?;
    guard(&control, scene)?;
    times(&safety, scene)?;
    payload(&safety, scene)?;
    electric(&safety, scene)?;
    distances(&safety, scene)?;
    stopping(&safety, scene)
}

impl SceneFile {
    /// Greatest `control.age_max`, in ticks, and the joint that sets it, counted from 0.
    ///
    /// A joint may move at [`velocity_factor`](crate::scene::ControlSpec::velocity_factor) times its velocity limit without being
    /// measured. In `age_max` ticks it then moves by `age_max period factor velocity`. This must not exceed `safety.reach`: a joint
    /// that is farther from its reference counts as not following it, and old measurements must not hide that. Without a velocity limit the bound is 2 ticks.
    #[must_use]
    pub fn age_bound(&self) -> (u32, usize) {
        let bound = |(index, joint): (usize, &RobotJoint)| {
            let velocity = joint.spec.limits.velocity;
            let reach = self.safety.reach.get(index).copied().unwrap_or(0.0);
            let ticks = if velocity.is_finite() {
                // The cast saturates. The small addition keeps a product whole that is whole except for rounding.
                (reach / (self.control.velocity_factor * velocity * self.period()) + 1e-9) as u32
            } else {
                AGE_WITHOUT_LIMIT
            };
            (ticks, index)
        };
        self.robot.joints.iter().enumerate().map(bound).min().unwrap_or((AGE_WITHOUT_LIMIT, 0))
    }
}

fn age(control: &Table<'_>, scene: &mut SceneFile) -> Result<(), FileError> {
    let (bound, index) = scene.age_bound();
    let Some(value) = control.get("age_max") else {
        scene.control.age_max = scene.control.age_max.min(bound);
        return Ok(());
    };
    let age = scene.control.age_max;
    let Some(joint) = scene.robot.joints.get(index).filter(|_| age > bound && !scene.safety.bench_only) else {
        return Ok(());
    };
    let (velocity, unit, label) = (joint.spec.limits.velocity, unit(joint), Robot::joint_label(index, &joint.name));
    let time = f64::from(age) * scene.period();
    let bench = "; `safety.bench_only = true` lifts the bound for a firmware without drives";
    if velocity.is_finite() {
        let speed = scene.control.velocity_factor * velocity;
        let problem = format!(
            "found {age} ticks, {time:.3} s: {label} may move {:.3} {unit} in that time, unmeasured, at {} times its velocity limit of \
             {velocity} {unit}/s",
            speed * time,
            scene.control.velocity_factor
        );
        let reach = scene.safety.reach.get(index).copied().unwrap_or(0.0);
        let expected = format!(
            "at most {bound} ticks at {} Hz: {} {unit} (`safety.reach`) / ({} {unit}/s x {} s){bench}",
            short(scene.control.rate),
            short(reach),
            short(speed),
            short(scene.period())
        );
        return Err(value.error(problem, expected));
    }
    let problem = format!(
        "found {age} ticks, {time:.3} s: {label} has no velocity limit that would bound its motion in that time"
    );
    Err(value.error(problem, format!("at most {bound} ticks, or `limits.velocity` in the robot file{bench}")))
}

fn guard(control: &Table<'_>, scene: &SceneFile) -> Result<(), FileError> {
    let Some(guard) = control.table("guard")? else { return Ok(()) };
    if let Some(value) = guard.get("velocity_factor").filter(|_| scene.control.velocity_factor > VELOCITY_FACTOR_MAX) {
        let problem = format!("found {}", scene.control.velocity_factor);
        let expected = format!(
            "a factor of 1 to {VELOCITY_FACTOR_MAX} on the velocity limit: stopping from {VELOCITY_FACTOR_MAX} times the limit takes 9 \
             times the distance that the machine keeps free"
        );
        return Err(value.error(problem, expected));
    }
    let Some(value) = guard.get("position_margin") else { return Ok(()) };
    let margin = scene.control.position_margin;
    // One number for all joints: the smallest bound over their kinds.
    let most = scene.robot.joints.iter().map(|joint| far(joint.spec.kind)).fold(f64::INFINITY, f64::min);
    if margin > most {
        let expected = format!(
            "at most {most}: farther beyond its limit a joint is not guarded (1 rad; 0.3 m where any joint slides)"
        );
        return Err(value.error(format!("found {margin}{}", degrees(margin)), expected));
    }
    Ok(())
}

fn times(safety: &Table<'_>, scene: &SceneFile) -> Result<(), FileError> {
    let spec = &scene.safety;
    if let Some(value) = safety.get("heartbeat_ms").filter(|_| spec.heartbeat > HEARTBEAT_MAX && !spec.bench_only) {
        let expected = "at most 1,000 ms: a person who walks at 1.6 m/s (ISO 13855) gets 1.6 m closer in that time, while no host controls \
                        the arm";
        return Err(value.error(format!("found {} ms", 1e3 * spec.heartbeat), expected));
    }
    if let Some(value) = safety.get("latency_ms") {
        // A drive on CAN measures when a command arrives, and its reply is read one tick later.
        let ticks = if scene.simulates_drives() { 2.0 } else { 1.0 };
        let least = ticks * scene.period();
        if spec.latency < least * (1.0 - 1e-9) {
            let why = if ticks > 1.0 {
                "the drives' measurements are a period old, and a torque acts for a period"
            } else {
                "a torque acts for a period"
            };
            let expected = format!("at least {} ms at {} Hz: {why}", 1e3 * least, scene.control.rate);
            return Err(value.error(format!("found {} ms", 1e3 * spec.latency), expected));
        }
    }
    Ok(())
}

fn payload(safety: &Table<'_>, scene: &SceneFile) -> Result<(), FileError> {
    let Some(value) = safety.get("payload_mass") else { return Ok(()) };
    let own: f64 =
        scene.robot.joints.iter().map(|joint| joint.spec.body.mass).sum::<f64>() + scene.robot.tool.body.mass;
    let (found, most) = (scene.safety.payload.mass, PAYLOAD_MAX * own);
    if own > 0.0 && found > most {
        let expected = format!(
            "at most {most:.3} kg, {PAYLOAD_MAX} times the {own:.3} kg that move: arms carry less than themselves"
        );
        return Err(value.error(format!("found {found} kg; grams?"), expected));
    }
    Ok(())
}

fn electric(safety: &Table<'_>, scene: &SceneFile) -> Result<(), FileError> {
    let all = [
        ("supply", scene.safety.supply, (0.0, SUPPLY_MAX), "V", "no drive here works beyond; millivolts?"),
        (
            "temperature",
            scene.safety.temperature,
            TEMPERATURES,
            "degrees Celsius",
            "motors and their sensors end there; kelvins?",
        ),
    ];
    for (key, (lo, hi), (least, most), unit, why) in all {
        if let Some(value) = safety.get(key).filter(|_| lo < least || hi > most) {
            return Err(value.error(format!("found {lo} to {hi}"), format!("inside {least} to {most} {unit}: {why}")));
        }
    }
    Ok(())
}

fn distances(safety: &Table<'_>, scene: &SceneFile) -> Result<(), FileError> {
    let spec = &scene.safety;
    let joints = &scene.robot.joints;
    each(safety, "reach", joints, &spec.reach, |index, joint| {
        // A reference within the error of a measurement cannot be distinguished from one at the joint.
        let least = spec.resolution.get(index).copied().unwrap_or(0.0);
        let most = far(joint.spec.kind);
        let why = format!("`resolution` to {most}: farther away a joint does not follow its reference");
        (least, most, why)
    })?;
    each(safety, "resolution", joints, &spec.resolution, |index, _| {
        let most = spec.reach.get(index).copied().unwrap_or(0.0);
        (
            0.0,
            most,
            format!(
                "at most `reach`, {}: with a larger measurement error, a joint that does not follow would not be detected",
                short(most)
            ),
        )
    })?;
    each(safety, "reach_speed", joints, &spec.reach_speed, |_, joint| {
        let most = joint.spec.limits.velocity;
        (0.0, most, format!("at most the velocity limit, {}", short(most)))
    })?;
    each(safety, "rest_speed", joints, &spec.rest_speed, |_, joint| {
        let share = REST_SPEED.1 * joint.spec.limits.velocity;
        let most = if share.is_finite() { REST_SPEED.0.max(share) } else { REST_SPEED.0 };
        (
            0.0,
            most,
            format!(
                "at most {}, the greater of {} and a tenth of the velocity limit: homing, arming and the end of a stop need an arm at rest",
                short(most),
                REST_SPEED.0
            ),
        )
    })?;
    let Some(value) = safety.get("jump_factor") else { return Ok(()) };
    for (index, joint) in joints.iter().enumerate() {
        let velocity = joint.spec.limits.velocity;
        let step = spec.jump_factor * velocity * scene.period();
        let reach = spec.reach.get(index).copied().unwrap_or(0.0);
        if velocity.is_finite() && step > reach {
            let (label, unit) = (Robot::joint_label(index, &joint.name), unit(joint));
            let problem =
                format!("found {}: a reading of {label} could jump by {step:.4} {unit} in a tick", spec.jump_factor);
            let most = reach / (velocity * scene.period());
            let expected = format!(
                "at most {most:.3}: {} {unit} (`safety.reach`) / ({} {unit}/s x {} s), because a larger jump means that the joint does \
                 not follow",
                short(reach),
                short(velocity),
                short(scene.period())
            );
            return Err(value.error(problem, expected));
        }
    }
    Ok(())
}

/// Checks braking and damping against the torque of a joint.
fn stopping(safety: &Table<'_>, scene: &SceneFile) -> Result<(), FileError> {
    let joints = &scene.robot.joints;
    if safety.get("deceleration").is_some() {
        let inertia: Vec<f64> = with_dof!(scene.robot.dof(), N => {
            let model = scene.robot.model::<N>()?;
            scene.fixed_inertia(&model, &scene.model).iter().copied().collect()
        });
        each(safety, "deceleration", joints, &scene.safety.deceleration, |index, joint| {
            let (torque, inertia) = (joint.spec.limits.torque, inertia.get(index).copied().unwrap_or(f64::INFINITY));
            let most = torque / inertia;
            let why = format!(
                "at most {most:.3}, the torque limit of {torque} over the inertia of {inertia:.4} where the motion starts"
            );
            (0.0, if most > 0.0 { most } else { f64::INFINITY }, why)
        })?;
    }
    each(safety, "damping", joints, &scene.safety.damping, |index, joint| {
        let rest = scene.safety.rest_speed.get(index).copied().unwrap_or(0.0);
        let most = joint.spec.limits.torque / rest;
        (
            0.0,
            most,
            format!(
                "at most {most:.3}, the torque limit at `rest_speed`: with more the drive switches between its limits"
            ),
        )
    })
}
