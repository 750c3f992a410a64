//! Identity of a firmware: robot, joints, rate.

use dynamics_core::Model;
use link::{Hello, Pacing};
use robot_compiler::{SceneFile, with_dof};
use sim::failure::Failure;

/// The hello of the scene's firmware for a robot whose model has not been made yet.
///
/// # Errors
/// [`Failure::Input`] for a robot that is not possible.
pub fn hello_of(scene: &SceneFile, pacing: Pacing) -> Result<Hello, Failure> {
    with_dof!(scene.robot.dof(), N => Ok(hello(scene, &scene.robot.model::<N>().map_err(Failure::input)?, pacing)))
}

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
