//! Identity of a firmware: robot, joints, rate.

use dynamics_core::Model;
use link::{Hello, Pacing};
use robot_compiler::SceneFile;

/// The hello that the scene's firmware sends.
#[must_use]
pub fn hello<const N: usize>(scene: &SceneFile, model: &Model<f64, N>, pacing: Pacing) -> Hello {
    Hello {
        robot: scene.hash(model),
        joints: u8::try_from(N).unwrap_or(u8::MAX),
        rate_hz: scene.control.rate as f32,
        pacing,
    }
}
