//! Joints that sink when the torque of an arm without brakes ends, and how far.

use super::Operator;
use robot_compiler::check::on_stop_distance;

/// Smallest distance that counts as sinking, rad or m.
const SINK_MIN: f64 = 0.02;

/// Step of the estimate of how far a joint sinks, rad or m, and the most steps.
const STEP: f64 = 0.005;
const STEPS: usize = 4000;

/// A joint that sinks when its torque ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sinking {
    joint: usize,
    /// Distance, rad or m.
    distance: f64,
    /// True if only its position limit, or the mechanical stop after it, ends the motion.
    to_limit: bool,
    /// Torque that gravity demands now, and the joint's friction, N m or N.
    gravity: f64,
    friction: f64,
}

/// Returns the joints that sink without torque. Each joint whose gravity torque exceeds its friction moves down in small steps, until friction or a
/// position limit holds it. Dynamics are neglected: a real arm swings past this position.
///
/// `gravity` returns the torque that holds the arm at a position.
fn sinking(q: &[f64], range: &[(f64, f64)], friction: &[f64], gravity: impl Fn(&[f64]) -> Vec<f64>) -> Vec<Sinking> {
    let mut at = q.to_vec();
    let first = gravity(q);
    // A joint outside its limits sinks no farther, and is not lifted either.
    let end = |joint: usize, down: f64| {
        let (low, high) = range.get(joint).copied().unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        if down < 0.0 { low } else { high }
    };
    for _ in 0..STEPS {
        let torque = gravity(&at);
        let mut moved = false;
        for (joint, at) in at.iter_mut().enumerate() {
            let (torque, friction) =
                (torque.get(joint).copied().unwrap_or(0.0), friction.get(joint).copied().unwrap_or(0.0));
            let down = -torque.signum();
            let room = (end(joint, down) - *at) * down;
            if torque.abs() > friction && room > 0.0 {
                *at += down * STEP.min(room);
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    let of = |(joint, (from, to)): (usize, (&f64, &f64))| {
        let distance = (to - from).abs();
        let limit = end(joint, (to - from).signum());
        (distance > SINK_MIN).then(|| Sinking {
            joint,
            distance,
            to_limit: (to - limit).abs() <= STEP,
            gravity: first.get(joint).map_or(0.0, |torque| torque.abs()),
            friction: friction.get(joint).copied().unwrap_or(0.0),
        })
    };
    q.iter().zip(&at).enumerate().filter_map(of).collect()
}

impl Operator {
    /// Joints that sink when the torque ends; none for an arm with brakes, or where no torque acts.
    pub(super) fn sinking(&self) -> Vec<Sinking> {
        let (Some(q), false, true) = (&self.q, self.arm.has_brakes, self.drives()) else { return Vec::new() };
        let friction: Vec<f64> = self.arm.friction.iter().map(|(_, coulomb)| *coulomb).collect();
        let mut all = sinking(q, &self.arm.range, &friction, |q| self.arm.model.gravity(q, self.arm.payload));
        // A joint that rests on its mechanical stop, as in most rest poses, falls no farther.
        all.retain(|sinking| {
            let joint = self.arm.recorded.robot.joints.get(sinking.joint);
            let near = joint.map_or(0.0, |joint| on_stop_distance(joint.spec.kind));
            !sinking.to_limit || sinking.distance > near
        });
        all
    }

    pub(super) fn sinking_in_words(&self, all: &[Sinking]) -> String {
        let of = |sinking: &Sinking| {
            let (name, place, force) = self.arm.joint(sinking.joint);
            let Sinking { distance, gravity, friction, .. } = *sinking;
            let end = if sinking.to_limit { " to its limit" } else { "" };
            format!(
                "{name} by about {distance:.2} {place}{end} (gravity {gravity:.2} {force}, friction {friction:.2} {force})"
            )
        };
        format!(
            "this arm has no brakes; without torque these joints sink: {}",
            all.iter().map(of).collect::<Vec<_>>().join(", ")
        )
    }
}

#[cfg(test)]
mod tests;
