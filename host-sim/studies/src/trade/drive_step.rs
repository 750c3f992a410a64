//! Quantisation steps of the drives' frames at the joints, which limit the accuracy of every choice.

use dynamics_core::Model;
use dynamics_core::drive::{Drives, Range};
use joint_io::mit::POSITION_BITS;
use robot_compiler::SceneFile;
use serde::Serialize;

/// Quantisation steps of one joint's drive, at the joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DriveStep {
    /// Half a step of the commanded torque, which is the largest rounding error: `|ratio| (max - min) / (2^bits - 1) / 2`, N m or N.
    pub torque: f64,
    /// A step of the measured position, which is truncated: `(max - min) / 65,535 / |ratio|`, rad or m.
    pub position: f64,
    /// A step of the measured velocity: `(max - min) / (2^bits - 1) / |ratio|`, rad/s or m/s.
    pub velocity: f64,
    /// Torque that the gains produce from one step of both: `M0 (Kp position + Kd velocity)`, N m or N.
    pub reading: f64,
}

/// Steps of the drives that the robot file describes; empty if they do not use frames.
#[must_use]
pub fn drive_steps<const N: usize>(scene: &SceneFile, model: &Model<f64, N>) -> Vec<DriveStep> {
    let Drives::Mit(drives) = scene.drives::<N>() else { return Vec::new() };
    let gains = scene.controller_config(model).gains;
    let bits = scene.protocol().map_or(POSITION_BITS, |protocol| protocol.facts().torque_bits);
    let of_joint = |i: usize| {
        let (ratio, ranges) = (f64::from(drives[i].gearing.ratio).abs(), &drives[i].ranges);
        let step = |range: &Range, bits| f64::from(range.step(bits));
        let position = step(&ranges.position, POSITION_BITS) / ratio;
        let velocity = step(&ranges.velocity, bits) / ratio;
        DriveStep {
            torque: 0.5 * step(&ranges.torque, bits) * ratio,
            position,
            velocity,
            reading: gains[i].inertia * (gains[i].position * position + gains[i].velocity * velocity),
        }
    };
    (0..N).map(of_joint).collect()
}

#[cfg(test)]
mod tests {
    use super::drive_steps;
    use robot_compiler::SceneFile;
    use std::path::Path;

    fn scene(name: &str) -> SceneFile {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        SceneFile::load(&scenes.join(name)).unwrap()
    }

    #[test]
    fn steps_are_those_of_the_frames_at_the_joints() {
        let mut wave = scene("examples/mit6_wave.toml");
        let joint = wave.robot.joints[0].drive.as_mut().unwrap();
        let robot_compiler::drive::JointDrive::Mit(spec) = joint else { panic!("an actuator") };
        spec.ratio = -2.0;
        let model = wave.robot.model::<6>().unwrap();
        let steps = drive_steps(&wave, &model);
        let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-6, "{found}, {expected}");
        near(steps[0].torque, 2.0 * 120.0 / 4095.0 / 2.0);
        near(steps[0].position, 25.0 / 65_535.0 / 2.0);
        near(steps[1].torque, 120.0 / 4095.0 / 2.0);
        near(steps[5].velocity, 100.0 / 4095.0);
        let gains = wave.controller_config(&model).gains[5];
        near(steps[5].reading, gains.inertia * (900.0 * 25.0 / 65_535.0 + 60.0 * 100.0 / 4095.0));
        let puma = scene("puma560_pick.toml");
        assert_eq!(drive_steps(&puma, &puma.robot.model::<6>().unwrap()), []);
    }
}
