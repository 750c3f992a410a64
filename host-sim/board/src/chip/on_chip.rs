//! A run with the chip in the loop. The desk's controller computes the same ticks from the same inputs, for comparison.

use crate::chip::{Chip, build_firmware_with, hello};
use dynamics_core::{Live, Measurement, Reference};
use indicatif::ProgressBar;
use link::Pacing;
use miette::IntoDiagnostic;
use robot_compiler::emit::Choices;
use robot_compiler::scene::ScalarChoice;
use robot_compiler::{SceneFile, with_dof};
use sim::failure::Failure;
use sim::run::scene_world;
use sim::run::simulate::{self, Run, RunOptions};
use sim::run::summary_parts::Instructions;
use sim::run::target::{CommandComparison, Ticked, Torques};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

impl<const N: usize> Torques<f32, N> for Chip {
    fn set_live(&mut self, live: &Live<f32, N>) -> miette::Result<()> {
        Chip::set_live(self, live).into_diagnostic()
    }

    fn tick(
        &mut self,
        reference: &Reference<f32, N>,
        measurement: &Measurement<f32, N>,
    ) -> miette::Result<Ticked<f32, N>> {
        let reply = Chip::tick(self, reference, measurement).into_diagnostic()?;
        Ok(Ticked { command: reply.command, instructions: reply.instructions.map(u64::from) })
    }
}

/// Builds the firmware of a scene, starts it in the emulator, and runs the closed loop with it.
///
/// The firmware is built from the scene's file, with the control law and the sine and cosine method of `scene`. No other setting of a tick may have
/// changed since the file was read. The hellos contain a hash that would reveal such a change.
///
/// # Errors
/// A scene that cannot be run; a firmware that cannot be built; an emulator that cannot be started or does not agree.
pub fn run(scene: &SceneFile, stop: &AtomicBool, progress: &ProgressBar) -> Result<Run, Failure> {
    with_dof!(scene.robot.dof(), N => run_for::<N>(scene, stop, progress))
}

fn run_for<const N: usize>(scene: &SceneFile, stop: &AtomicBool, progress: &ProgressBar) -> Result<Run, Failure> {
    let mut scene = scene.clone();
    scene.control.scalar = ScalarChoice::F32;
    let model = scene.robot.model::<N>().map_err(Failure::input)?;
    // Report an impossible motion before the compiler starts.
    scene_world::world::<N>(&scene)?;
    let target = |error| Failure::Target(miette::Report::from_err(error));
    progress.set_message("building the firmware");
    let program = build(&scene).map_err(|failure| {
        // Ctrl-C interrupts the compiler too.
        if stop.load(Ordering::Relaxed) { Failure::Interrupted } else { failure }
    })?;
    progress.set_message("");
    let chip = Chip::start(&program, hello(&scene, &model, Pacing::LockStep)).map_err(target)?;
    let mut both = CommandComparison::new(chip, simulate::desk::<f32, N>(&scene, &model));
    let mut run = simulate::with(&RunOptions { scene: &scene, target: "qemu", stop, progress }, &mut both)?;
    run.summary.parity = Some(both.parity());
    run.summary.instructions_per_tick = both.instructions().map(|(min, max)| Instructions { min, max });
    Ok(run)
}

/// Builds the firmware of the scene's file, with the law and the sine and cosine method of `scene` if they were changed.
fn build(scene: &SceneFile) -> Result<PathBuf, Failure> {
    let file = SceneFile::load(&scene.path).map_err(Failure::input)?;
    let ((law, trig), (law_there, trig_there)) = (scene.control.names(), file.control.names());
    let choices = Choices { law: (law != law_there).then_some(law), trig: (trig != trig_there).then_some(trig) };
    build_firmware_with(&scene.path, choices).map_err(|error| Failure::Target(miette::Report::from_err(error)))
}
