//! Speeds of the joints while the arm is lowered to its rest pose.

use super::SceneFile;
use dynamics_core::{JointKind, Model};

/// Greatest speed of a joint while the arm is lowered, rad/s or m/s. Without it, an arm whose axes all go through the tip would have no bound.
const LOWERING_MAX: f64 = 0.5;

impl SceneFile {
    /// Speeds of the joints while the arm is lowered to its rest pose, rad/s or m/s: the tip then stays below
    /// [`SafetySpec::lowering_tip_speed`](super::SafetySpec::lowering_tip_speed) in every posture.
    ///
    /// The tip's speed is at most the sum of `r_i |qd_i|`, with `r_i` the greatest distance between the axis of joint `i` and the tip
    /// ([`axis_to_tip`]), 1 for a slide. All joints get the same speed, `v / sum r_i`, but at most 0.5 and at most their velocity limit, or the
    /// share of it allowed in the first motion: the host may be lost before a person has lifted that limit.
    #[must_use]
    pub fn lowering_speed<const N: usize>(&self, model: &Model<f64, N>) -> [f64; N] {
        let speed = self.safety.lowering_tip_speed / axis_to_tip(model).iter().sum::<f64>();
        let share = self.safety.first_motion.unwrap_or(1.0);
        model.links().map(|link| speed.min(share * link.limits.velocity).min(LOWERING_MAX))
    }
}

/// Upper bound on the distance between the axis of each joint and the tip, m, over all postures inside the limits; 1 for a slide,
/// which moves the tip at its own speed.
///
/// It adds the part of the first step (from the joint's origin to the next one's) across the axis, and the whole length of every further step
/// and of the travel of slides (triangle inequality).
#[must_use]
pub fn axis_to_tip<const N: usize>(model: &Model<f64, N>) -> [f64; N] {
    let links = model.links();
    let step = |i: usize| links.get(i + 1).map_or(model.tip().translation, |next| next.translation);
    let travel = |i: usize| {
        let slides = links.get(i).filter(|link| link.kind == JointKind::Prismatic);
        slides.map_or(0.0, |link| link.limits.position.0.abs().max(link.limits.position.1.abs()))
    };
    core::array::from_fn(|i| match links[i].kind {
        JointKind::Prismatic => 1.0,
        JointKind::Revolute => {
            let beyond: f64 = (i + 1..N).map(|j| step(j).norm() + travel(j)).sum();
            step(i).xy().norm() + beyond
        }
    })
}
