//! The chip in lock step: instructions of each tick as counted by the chip itself, and the depth of its stack.

use crate::budget::random_motion::Tick;
use crate::budget::stack_paint::StackPaint;
use crate::budget::{Failure, program, report, supervised};
use ::board::chip::{self, Chip, Emulator, Timeouts};
use ::board::session::dry_run::OnChip;
use chip_image::ImageError;
use dynamics_core::Command;
use link::{Hello, Pacing};
use robot_compiler::SceneFile;
use sim::run::simulate;
use std::path::Path;
use std::time::Duration;

/// The emulator of the emulated boards.
pub(crate) const QEMU: &str = "qemu-system-arm";

/// Timeout of an answer. An emulator that logs every instruction is about a hundred times slower than without a log, and shares the machine with the
/// reader of its log.
pub(crate) const PATIENCE: Timeouts = Timeouts { connect: Duration::from_secs(30), answer: Duration::from_secs(120) };

/// Expected hello of a firmware for this scene.
pub(crate) fn hello<const N: usize>(scene: &SceneFile) -> Result<Hello, Failure> {
    let model = scene.robot.model::<N>().map_err(|error| Failure::Scene(error.to_string()))?;
    Ok(chip::hello(scene, &model, Pacing::LockStep))
}

/// Sends the chip the live inputs of the scene.
pub(crate) fn tell_live<const N: usize>(chip: &mut Chip, scene: &SceneFile) -> Result<(), Failure> {
    let model = scene.robot.model::<N>().map_err(|error| Failure::Scene(error.to_string()))?;
    Ok(chip.set_live(&simulate::live_inputs::<f32, N>(scene, &model))?)
}

/// Runs one tick that must drive, and returns its instructions.
pub(crate) fn drive<const N: usize>(chip: &mut Chip, number: usize, tick: &Tick<N>) -> Result<u64, Failure> {
    let reply = chip.tick(&tick.0, &tick.1)?;
    if let Command::Brake(fault) = reply.command {
        return Err(Failure::NotSeen(format!("a torque in tick {number}: the chip brakes, {fault}")));
    }
    let counted = reply.instructions.map(u64::from);
    counted.ok_or_else(|| Failure::NotSeen("a count of instructions: the chip's counter is not exact".into()))
}

/// Drives a chip through a motion in bench mode and through another under its safety state machine, with painted RAM.
///
/// # Errors
/// The program cannot be read, or the chip is unusable, brakes, or returns no count.
pub fn count<const N: usize>(
    scene: &SceneFile,
    elf: &Path,
    motion: &[Tick<N>],
    supervised: &[Tick<N>],
) -> Result<report::Ticks, Failure> {
    let broken = |error: ImageError| Failure::Program { path: elf.to_owned(), why: error.to_string() };
    let room = program::read(elf)?.stack_room().map_err(broken)?;
    let paint = StackPaint::new(room)?;
    let emulator = Emulator::start_with(QEMU.as_ref(), elf, PATIENCE, &paint.arguments())?;
    let mut chip = Chip::over(emulator, hello::<N>(scene)?)?;
    tell_live::<N>(&mut chip, scene)?;
    let mut range = (u64::MAX, 0);
    for (number, tick) in motion.iter().enumerate() {
        let count = drive(&mut chip, number, tick)?;
        range = (range.0.min(count), range.1.max(count));
    }
    if motion.is_empty() {
        return Err(Failure::NotSeen("a tick: the motion has none".into()));
    }
    let mut chip = OnChip::start(chip, hello::<N>(scene)?)?;
    let supervised = supervised::count(&mut chip, scene, supervised)?;
    Ok(report::Ticks { ticks: motion.len() as u64, min: range.0, max: range.1, stack: paint.deepest()?, supervised })
}
