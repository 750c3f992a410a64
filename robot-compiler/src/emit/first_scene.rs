//! A first scene for an arm: a slow motion near its zero pose, to simulate and to change.

use crate::Robot;
use crate::describe::robot::RobotJoint;
use dynamics_core::JointKind;

/// Distance that each joint moves, rad or m, and the largest share of its range.
const SWING: (f64, f64) = (0.3, 0.1);
const SHARE: f64 = 0.1;

/// Shortest time of each direction, s, and the largest share of a joint's velocity limit.
const SECONDS: f64 = 2.0;
const SPEED_SHARE: f64 = 0.5;

/// Peak velocity of a quintic from rest to rest, over its mean velocity.
const PEAK: f64 = 1.875;

/// Text of a scene in which every joint moves a little and comes back, inside the limits.
///
/// `path` is the robot file, relative to the scene's folder. A limit that the arm's description lacks counts as infinite.
#[must_use]
pub fn first_scene(robot: &Robot, path: &str) -> String {
    let [from, to]: [Vec<f64>; 2] = {
        let both = robot.joints.iter().map(swing);
        let (from, to): (Vec<f64>, Vec<f64>) = both.unzip();
        [from, to]
    };
    let time = |((joint, from), to): ((&RobotJoint, &f64), &f64)| {
        let velocity = joint.spec.limits.velocity;
        if velocity > 0.0 { PEAK * (to - from).abs() / (SPEED_SHARE * velocity) } else { 0.0 }
    };
    let slowest = robot.joints.iter().zip(&from).zip(&to).map(time).fold(SECONDS, f64::max);
    let seconds = (slowest * 10.0).ceil() / 10.0;
    let point = |q: &[f64]| format!("{:?}", q.iter().map(|q| (q * 1e4).round() / 1e4).collect::<Vec<_>>());
    format!(
        "# A first scene: every joint moves a little and comes back. Change the points, then `newtau run` it again.\n\
         name = {:?}\nrobot = {path:?}\nduration = {:?}\n\n[motion]\nkind = \"quintic\"\npoints = [\n    {{ q = {} }},\n    \
         {{ q = {}, duration = {seconds:?} }},\n    {{ q = {}, duration = {seconds:?} }},\n]\n",
        first_name(&robot.name),
        2.0 * seconds + 0.5,
        point(&from),
        point(&to),
        point(&from),
    )
}

/// A name that is also valid as a file name.
fn first_name(robot: &str) -> String {
    let name: String =
        robot.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
    format!("{name}_first")
}

/// Start and end of a joint's motion: near zero, and away from the limits.
fn swing(joint: &RobotJoint) -> (f64, f64) {
    let (low, high) = joint.spec.limits.position;
    let range = high - low;
    let (swing, margin) = {
        let most = if joint.spec.kind == JointKind::Prismatic { SWING.1 } else { SWING.0 };
        if range.is_finite() { (most.min(SHARE * range), SHARE * range) } else { (most, 0.0) }
    };
    let from = 0.0_f64.max(low + margin).min(high - margin);
    let to = if from + swing <= high - margin { from + swing } else { from - swing };
    (from, to)
}
