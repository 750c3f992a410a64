//! Devices for a scene's simulated arm, for any number of joints: dry runs on the desk and in the emulated chip, and a simulated board.

use super::device::{Device, Pace};
use super::dry_run_device::DryRunDevice;
use super::simulated_board::{Places, SimulatedBoard};
use super::wire::Disturbance;
use crate::chip::{Chip, ChipError, build_firmware, hello};
use crate::session::dry_run::{OnChip, OnDesk};
use link::Pacing;
use robot_compiler::{SceneFile, with_dof};
use sim::failure::Failure;
use sim::run::scene_world::world;

/// A dry run with the firmware's session on the desk.
///
/// # Errors
/// [`Failure::Input`] for a robot, an arm or a motion that is not possible.
pub fn on_desk(scene: &SceneFile, pace: Pace) -> Result<Box<dyn Device>, Failure> {
    with_dof!(scene.robot.dof(), N => {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        Ok(Box::new(DryRunDevice::new(OnDesk::start(scene, &model), world::<N>(scene)?, pace)))
    })
}

/// A dry run with the scene's firmware in the emulated chip. Builds the firmware.
///
/// # Errors
/// Those of [`on_desk`]; [`Failure::Target`] if the firmware cannot be built, or the emulator cannot be started.
pub fn on_chip(scene: &SceneFile, pace: Pace) -> Result<Box<dyn Device>, Failure> {
    with_dof!(scene.robot.dof(), N => {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let world = world::<N>(scene)?;
        let bench = hello(scene, &model, Pacing::LockStep);
        let target = started(scene, bench).map_err(|error| Failure::Target(miette::miette!("{error}")))?;
        Ok(Box::new(DryRunDevice::<N, _>::new(target, world, pace)))
    })
}

fn started(scene: &SceneFile, bench: link::Hello) -> Result<OnChip, ChipError> {
    OnChip::start(Chip::start(&build_firmware(&scene.path)?, bench)?, bench)
}

/// A simulated board on a simulated cable. `places` are the links that `disturbance` acts on.
///
/// # Errors
/// As [`on_desk`].
pub fn on_board(
    scene: &SceneFile,
    disturbance: Disturbance,
    places: Places,
    pace: Pace,
) -> Result<Box<dyn Device>, Failure> {
    with_dof!(scene.robot.dof(), N => {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        Ok(Box::new(SimulatedBoard::new((scene, &model), world::<N>(scene)?, disturbance, places, pace)))
    })
}
