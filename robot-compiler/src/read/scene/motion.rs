//! The `[motion]` table.

use super::values::{per_joint, per_joint_text};
use crate::describe::diagnostics::FileError;
use crate::describe::robot::Robot;
use crate::describe::scene::{MotionSpec, SceneFile, ViaPoint};
use crate::read::shown::counted;
use crate::read::table::{Table, Value};
use crate::with_dof;
use dynamics_core::control::trajectory::{HARMONICS_MAX, MotionError, POINTS_MAX};

/// Longest motion, s: longer ones (hours or a day) are probably typing errors.
const DURATION_MAX: f64 = 1e4;
const TIME: &str = "a time in s, above zero and at most 1e4";

#[derive(Clone, Copy)]
enum MotionKind {
    Hold,
    Quintic,
    Trapezoid,
    Sine,
    Fourier,
}

pub(super) fn read(table: &Table<'_>, robot: &Robot) -> Result<MotionSpec, FileError> {
    let kind = table.require("kind", "one of quintic, trapezoid, sine, fourier, hold")?.choice(&[
        ("quintic", MotionKind::Quintic),
        ("trapezoid", MotionKind::Trapezoid),
        ("sine", MotionKind::Sine),
        ("fourier", MotionKind::Fourier),
        ("hold", MotionKind::Hold),
    ])?;
    match kind {
        MotionKind::Hold => hold(table, robot),
        MotionKind::Quintic => quintic(table, robot),
        MotionKind::Trapezoid => trapezoid(table, robot),
        MotionKind::Sine => sine(table, robot),
        MotionKind::Fourier => fourier(table, robot),
    }
}

fn hold(table: &Table<'_>, robot: &Robot) -> Result<MotionSpec, FileError> {
    table.only(&["kind", "q", "duration"])?;
    Ok(MotionSpec::Hold { q: position(table, "q", robot)?, duration: time(&table.require("duration", TIME)?)? })
}

fn quintic(table: &Table<'_>, robot: &Robot) -> Result<MotionSpec, FileError> {
    table.only(&["kind", "points", "acceleration", "repeat"])?;
    let expected = format!("2 to {POINTS_MAX} points {{ q, duration, dwell }}, start first");
    let list = table.require("points", &expected)?;
    let items = list.array(&expected)?;
    if !(2..=POINTS_MAX).contains(&items.len()) {
        return Err(list.error(format!("found {}", counted(items.len(), "point", "points")), expected));
    }
    let points = items.iter().map(|item| via_point(item, robot)).collect::<Result<Vec<_>, _>>()?;
    let timed = points.iter().skip(1).filter(|point| point.duration.is_some()).count();
    if points.first().is_some_and(|point| point.duration.is_some()) {
        let problem = "the first point has a duration, but no segment ends there";
        return Err(items[0].error(problem, "a duration only from the second point on"));
    }
    if timed != 0 && timed + 1 != points.len() {
        let bare = points.iter().skip(1).position(|point| point.duration.is_none()).map_or(0, |index| index + 1);
        let problem = "this point has no duration, but others have";
        return Err(items[bare].error(problem, "a duration at every point after the first, or at none"));
    }
    let acceleration = acceleration(table, robot)?;
    if let (true, Some(value)) = (timed != 0, table.get("acceleration")) {
        return Err(value.error("given beside durations", "either durations or an acceleration bound"));
    }
    let repeat = table.get("repeat").map_or(Ok(false), |value| value.boolean())?;
    let closed = points.first().map(|p| &p.q) == points.last().map(|p| &p.q);
    if repeat && !closed {
        return Err(table.error(
            "repeat",
            "the motion does not end where it starts",
            "a last point equal to the first",
        ));
    }
    Ok(MotionSpec::Quintic { points, acceleration, repeat })
}

fn via_point(item: &Value<'_>, robot: &Robot) -> Result<ViaPoint, FileError> {
    let point = item.table()?;
    point.only(&["q", "duration", "dwell"])?;
    Ok(ViaPoint {
        q: position(&point, "q", robot)?,
        duration: point.get("duration").map(|value| time(&value)).transpose()?,
        dwell: point
            .get("dwell")
            .map_or(Ok(0.0), |value| value.within(0.0, DURATION_MAX, "a time in s, zero or more"))?,
    })
}

fn trapezoid(table: &Table<'_>, robot: &Robot) -> Result<MotionSpec, FileError> {
    table.only(&["kind", "start", "goal", "acceleration", "duration", "ramp_share"])?;
    let acceleration = acceleration(table, robot)?;
    let duration = table.get("duration").map(|value| time(&value)).transpose()?;
    const EITHER: &str = "exactly one of `acceleration` (as fast as limits allow) and `duration`";
    match (&acceleration, duration) {
        (None, None) => return Err(table.error("acceleration", "missing, and no duration either", EITHER)),
        (Some(_), Some(_)) => return Err(table.error("duration", "given beside `acceleration`", EITHER)),
        (Some(_), None) if table.get("ramp_share").is_some() => {
            return Err(table.error("ramp_share", "given without `duration`", "a ramp share only beside a duration"));
        }
        _ => {}
    }
    const SHARE: &str = "a share of the duration, above 0 and at most 0.5";
    Ok(MotionSpec::Trapezoid {
        start: position(table, "start", robot)?,
        goal: position(table, "goal", robot)?,
        acceleration,
        duration,
        ramp_share: table.get("ramp_share").map_or(Ok(1.0 / 3.0), |value| value.positive_up_to(0.5, SHARE))?,
    })
}

fn sine(table: &Table<'_>, robot: &Robot) -> Result<MotionSpec, FileError> {
    table.only(&["kind", "centre", "amplitude", "frequency_start", "frequency_end", "duration", "ramp"])?;
    const FREQUENCY: &str = "a frequency in Hz, above zero and at most 1000";
    let start = table.require("frequency_start", FREQUENCY)?.positive_up_to(1000.0, FREQUENCY)?;
    let end = table.get("frequency_end").map_or(Ok(start), |value| value.positive_up_to(1000.0, FREQUENCY))?;
    let duration = time(&table.require("duration", TIME)?)?;
    const RAMP: &str = "a time in s, above zero and at most half the duration";
    let ramp = table.get("ramp").map_or(Ok(0.1 * duration), |value| value.positive_up_to(0.5 * duration, RAMP))?;
    const AMPLITUDE: &str = "an amplitude in rad or m";
    let amplitude = per_joint(&table.require("amplitude", AMPLITUDE)?, robot, AMPLITUDE, |v| v.finite(AMPLITUDE))?;
    Ok(MotionSpec::Sine {
        centre: position(table, "centre", robot)?,
        amplitude,
        frequency_start: start,
        frequency_end: end,
        duration,
        ramp,
    })
}

fn fourier(table: &Table<'_>, robot: &Robot) -> Result<MotionSpec, FileError> {
    table.only(&["kind", "centre", "sine", "cosine", "period", "duration", "ramp"])?;
    let duration = time(&table.require("duration", TIME)?)?;
    const RAMP: &str = "a time in s, above zero and at most half the duration";
    Ok(MotionSpec::Fourier {
        centre: position(table, "centre", robot)?,
        sine: harmonics(table, "sine", robot)?,
        cosine: harmonics(table, "cosine", robot)?,
        period: time(&table.require("period", TIME)?)?,
        duration,
        ramp: table.get("ramp").map_or(Ok(0.1 * duration), |value| value.positive_up_to(0.5 * duration, RAMP))?,
    })
}

/// A list of harmonics, each a list of amplitudes, one for each joint.
fn harmonics(table: &Table<'_>, key: &str, robot: &Robot) -> Result<Vec<Vec<f64>>, FileError> {
    let expected = format!("1 to {HARMONICS_MAX} harmonics, each {} amplitudes in rad or m", robot.dof());
    let list = table.require(key, &expected)?;
    let items = list.array(&expected)?;
    if !(1..=HARMONICS_MAX).contains(&items.len()) {
        return Err(list.error(format!("found {}", counted(items.len(), "harmonic", "harmonics")), expected));
    }
    items.iter().map(|item| item.numbers(robot.dof(), &expected)).collect()
}

fn position(table: &Table<'_>, key: &str, robot: &Robot) -> Result<Vec<f64>, FileError> {
    let expected = per_joint_text(robot, "a position (rad or m)");
    table.require(key, &expected)?.numbers(robot.dof(), &expected)
}

fn time(value: &Value<'_>) -> Result<f64, FileError> {
    value.within(1e-4, DURATION_MAX, TIME)
}

fn acceleration(table: &Table<'_>, robot: &Robot) -> Result<Option<Vec<f64>>, FileError> {
    const EXPECTED: &str = "an acceleration in rad/s^2 or m/s^2, above zero";
    let one = |value: &Value<'_>| value.positive(EXPECTED);
    table.get("acceleration").map(|value| per_joint(&value, robot, EXPECTED, one)).transpose()
}

/// Makes the motion once, so that an impossible one is reported at its location in the file.
pub(super) fn check(scene: &SceneFile, table: &Table<'_>) -> Result<(), FileError> {
    let made = with_dof!(scene.robot.dof(), N => {
        let model = scene.robot.model::<N>()?;
        scene.trajectory(&model).map(|motion| motion.duration())
    });
    let error = match made {
        Ok(_) => return Ok(()),
        Err(error) => error,
    };
    let expected = "a motion inside the robot's position, velocity and torque limits";
    let key = match (&scene.motion, &error) {
        (MotionSpec::Quintic { .. }, MotionError::PositionOutOfLimits { point, .. }) => {
            let items = table.require("points", expected)?.array(expected)?;
            if let Some(point) = items.get(*point) {
                return Err(point.table()?.error("q", error.to_string(), expected));
            }
            "points"
        }
        (MotionSpec::Quintic { .. }, _) => "points",
        (MotionSpec::Trapezoid { .. }, MotionError::PositionOutOfLimits { point: 0, .. }) => "start",
        (MotionSpec::Trapezoid { .. }, MotionError::PositionOutOfLimits { .. }) => "goal",
        (MotionSpec::Trapezoid { duration: Some(_), .. }, _) => "duration",
        (MotionSpec::Trapezoid { .. }, _) => "acceleration",
        (MotionSpec::Sine { .. }, MotionError::PositionOutOfLimits { .. }) => "centre",
        (MotionSpec::Sine { .. }, MotionError::AmplitudeBeyondLimits { .. }) => "amplitude",
        (MotionSpec::Sine { .. }, _) => "frequency_end",
        (MotionSpec::Fourier { .. }, MotionError::PositionOutOfLimits { .. }) => "centre",
        (MotionSpec::Fourier { .. }, MotionError::AmplitudeBeyondLimits { .. }) => "sine",
        (MotionSpec::Fourier { .. }, _) => "period",
        (MotionSpec::Hold { .. }, _) => "q",
    };
    Err(table.error(key, error.to_string(), expected))
}
