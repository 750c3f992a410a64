//! Default scene for an arm without one.

use super::SceneFile;
use super::control::ControlSpec;
use super::model::ModelSpec;
use super::motion::{MotionSpec, ViaPoint};
use super::plant::{ActuatorSpec, PlantSpec, SensorSpec};
use super::safety::SafetySpec;
use crate::describe::robot::{Robot, RobotJoint};
use dynamics_core::JointKind;
use std::path::PathBuf;

impl SceneFile {
    /// A default scene for an arm: floor, computed torque at 1 kHz, a swing to one side and back.
    #[must_use]
    pub fn default_for(robot: Robot) -> Self {
        let start: Vec<f64> = robot.joints.iter().map(rest).collect();
        let aside: Vec<f64> = robot.joints.iter().zip(&start).map(|(joint, q)| q + swing(joint, *q)).collect();
        // A quintic from rest to rest peaks at 15/8 of its mean speed; half the velocity limit leaves a margin.
        let slowest = robot.joints.iter().zip(start.iter().zip(&aside));
        let duration = slowest.map(|(joint, (a, b))| 1.875 * (b - a).abs() / (0.5 * joint.spec.limits.velocity));
        let duration = Some(duration.fold(1.0, f64::max));
        let point = |q: &[f64], duration| ViaPoint { q: q.to_vec(), duration, dwell: 0.0 };
        let model = ModelSpec::default_for(&robot);
        let control = ControlSpec::default_for(&robot);
        Self {
            name: robot.name.clone(),
            path: PathBuf::new(),
            duration: None,
            seed: 0,
            plant: PlantSpec::default_for(&robot, &model, &control, &start),
            safety: SafetySpec::default_for(&robot, &control),
            motion: MotionSpec::Quintic {
                points: vec![point(&start, None), point(&aside, duration), point(&start, duration)],
                acceleration: None,
                repeat: false,
            },
            model,
            control,
            collision: None,
            sensors: SensorSpec::default(),
            actuators: ActuatorSpec::default(),
            robot,
        }
    }
}

/// Rest position of a joint: zero if the limits allow it, otherwise the middle between them, otherwise the only limit.
fn rest(joint: &RobotJoint) -> f64 {
    let (lo, hi) = joint.spec.limits.position;
    if lo <= 0.0 && 0.0 <= hi {
        0.0
    } else if lo.is_finite() && hi.is_finite() {
        0.5 * (lo + hi)
    } else if lo.is_finite() {
        lo
    } else {
        hi
    }
}

/// Goal of a joint: on the side with the greater distance to its limit, half a radian or 10 cm away, but at most half of that distance.
fn swing(joint: &RobotJoint, q: f64) -> f64 {
    let (lo, hi) = joint.spec.limits.position;
    let far: f64 = match joint.spec.kind {
        JointKind::Revolute => 0.5,
        JointKind::Prismatic => 0.1,
    };
    if hi - q >= q - lo { far.min(0.5 * (hi - q)) } else { -far.min(0.5 * (q - lo)) }
}
