//! Cost of a control tick on the chip, for many scenes: instructions, flash, RAM.
//!
//! Each controller is built into its own program. The program runs it in the emulator, in the scene's scalar, over the
//! same ticks of the scenes' motion ([`robot_compiler::emit::cost::inputs`]). The desk's controller gets the same
//! ticks, and must give the same bits.
//!
//! Each program holds one controller only, because controllers in one program share functions. The compiler then no
//! longer inlines these into each tick with its numbers: a tick of 1,298 instructions took 2,228 in a program with nine
//! others.

use super::task::run_cost;
use dynamics_core::{Command, Fault, Model, Real};
use firmware_image::scratch::ScratchFile;
use indicatif::ProgressBar;
use miette::IntoDiagnostic as _;
use robot_compiler::emit::cost::{Input, RUN_UP, difference, inputs};
use robot_compiler::scene::ScalarChoice;
use robot_compiler::{SceneFile, with_dof};
use serde::{Deserialize, Serialize};
use sim::failure::Failure;
use sim::run::simulate;
use sim::run::target::Torques;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// Number of scenes that are built and run at once. Between batches, `stop` is checked and the progress is shown.
const BATCH: usize = 8;

/// Cost of a control tick on the chip, over the ticks after the run-up that did not brake; instructions and cycles are zero if all braked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Mean number of instructions per tick.
    pub instructions: f64,
    /// Greatest number of instructions per tick.
    pub instructions_max: u64,
    /// Mean number of cycles per tick, which runs from SRAM: an estimate. The core's caches are as the earlier ticks left them.
    pub cycles: f64,
    /// Greatest number of cycles per tick: an estimate.
    pub cycles_max: f64,
    /// Bytes of the tick, its callees and the constants that they read. A part that several scenes share counts in full for each.
    pub flash: u64,
    /// Bytes of the controller. The code of the tick is in RAM too, and counts under `flash`, from which it is copied.
    pub ram: u64,
    /// True if every command equals the desk's, bit by bit.
    pub matches_desk: bool,
}

/// Result of the measurement of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredCost {
    /// Cost of a tick.
    pub cost: Cost,
    /// Fewest instructions in a tick.
    pub instructions_min: u64,
    /// The first tick that braked, if one did.
    pub fault: Option<Braked>,
}

/// A tick that braked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Braked {
    /// The first such tick, counted from 0 with the run-up.
    pub tick: usize,
    /// The stable number of its fault.
    pub code: u8,
    /// The joint at fault, counted from 0, if the fault belongs to one joint.
    pub joint: Option<u8>,
}

impl Braked {
    /// The fault; `None` if this version does not know its number.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        Fault::from_code(self.code, self.joint.unwrap_or_default())
    }
}

/// Measures a tick of each scene. The results are in the order of the files.
///
/// # Errors
/// [`Failure::Input`] for a scene that cannot be read or moved, with its file and line. Also for scenes that differ in
/// robot, rate, motion, duration or sensors, because their costs are not comparable. [`Failure::Target`], with the
/// scene, if a program cannot be built or run. [`Failure::Interrupted`] if `stop` is set meanwhile.
pub fn measure(scenes: &[PathBuf], stop: &AtomicBool, progress: &ProgressBar) -> Result<Vec<MeasuredCost>, Failure> {
    let absolute = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
    let files: Vec<SceneFile> =
        scenes.iter().map(|path| SceneFile::load(&absolute(path)).map_err(Failure::input)).collect::<Result<_, _>>()?;
    comparable(&files)?;
    progress.set_length(files.len() as u64);
    let mut costs = Vec::with_capacity(files.len());
    for batch in files.chunks(BATCH) {
        if stop.load(Ordering::Relaxed) {
            return Err(Failure::Interrupted);
        }
        costs.extend(measure_batch(batch).map_err(|failure| {
            // Ctrl-C interrupts the compiler too.
            if stop.load(Ordering::Relaxed) { Failure::Interrupted } else { failure }
        })?);
        progress.inc(batch.len() as u64);
    }
    Ok(costs)
}

fn comparable(files: &[SceneFile]) -> Result<(), Failure> {
    let Some(first) = files.first() else { return Ok(()) };
    for file in files {
        if let Some(what) = difference(first, file) {
            return Err(Failure::Input(miette::miette!(
                help = "expected scenes of one robot, rate, motion, duration and sensors",
                "{}: {what}: not that of {}",
                file.path.display(),
                first.path.display()
            )));
        }
    }
    Ok(())
}

/// A list of scene files for the build.
fn list(scenes: &[SceneFile]) -> std::io::Result<ScratchFile> {
    let file = ScratchFile::new("scenes")?;
    let lines: String = scenes.iter().map(|scene| format!("{}\n", scene.path.display())).collect();
    std::fs::write(file.path(), lines)?;
    Ok(file)
}

fn measure_batch(scenes: &[SceneFile]) -> Result<Vec<MeasuredCost>, Failure> {
    let desk: Vec<Vec<String>> =
        scenes.iter().map(|scene| with_dof!(scene.robot.dof(), N => commands::<N>(scene))).collect::<Result<_, _>>()?;
    let list = list(scenes).map_err(Failure::Output)?;
    let said = run_cost(list.path()).map_err(|error| Failure::Target(miette::Report::from_err(error)))?;
    let measured: Vec<Measured> =
        said.lines().map(serde_json::from_str).collect::<Result<_, _>>().into_diagnostic().map_err(Failure::Target)?;
    if measured.len() != desk.len() {
        let count = measured.len();
        return Err(Failure::Target(miette::miette!("{count} programs were measured; expected {}", desk.len())));
    }
    measured.into_iter().zip(&desk).map(|(measured, desk)| cost(measured, desk).map_err(Failure::Target)).collect()
}

/// The desk's commands in the chip's text format, tick by tick.
fn commands<const N: usize>(scene: &SceneFile) -> Result<Vec<String>, Failure> {
    match scene.control.scalar {
        ScalarChoice::F32 => commands_in::<f32, N>(scene, &mut simulate::desk(scene, &model(scene)?)),
        ScalarChoice::F64 => commands_in::<f64, N>(scene, &mut simulate::desk(scene, &model(scene)?)),
    }
}

fn model<const N: usize>(scene: &SceneFile) -> Result<Model<f64, N>, Failure> {
    scene.robot.model::<N>().map_err(Failure::input)
}

fn commands_in<S: Real, const N: usize>(
    scene: &SceneFile,
    controller: &mut impl Torques<S, N>,
) -> Result<Vec<String>, Failure> {
    let model = model(scene)?;
    let inputs = inputs(scene, &model)
        .map_err(|error| Failure::Input(miette::miette!("{}: the motion cannot be: {error}", scene.path.display())))?;
    controller.set_live(&simulate::live_inputs(scene, &model)).map_err(Failure::Target)?;
    let command = |input: &Input<N>| {
        let ticked = controller.tick(&input.reference.cast(), &input.measurement()).map_err(Failure::Target)?;
        Ok(words(&ticked.command))
    };
    inputs.iter().map(command).collect()
}

/// A command in the chip's text format.
fn words<S: Real, const N: usize>(command: &Command<S, N>) -> String {
    match command {
        Command::Drive { torque, limits } => {
            let torques: String = torque.iter().map(|torque| format!(",{:016x}", torque.to_f64().to_bits())).collect();
            let limits: String = limits.iter().map(|limits| format!(",{}", limits.bits())).collect();
            format!("drive{torques}{limits}")
        }
        Command::Brake(fault) => {
            let joint = fault.joint().map(|joint| joint.to_string()).unwrap_or_default();
            format!("brake,{},{joint}", fault.code())
        }
    }
}

/// The answer of `cargo xtask firmware cost` for a scene.
#[derive(Debug, Deserialize)]
struct Measured {
    controller_bytes: u64,
    flash_bytes: u64,
    ticks: Vec<Ticked>,
}

/// One call of the tick.
#[derive(Debug, Deserialize)]
struct Ticked {
    instructions: u64,
    cycles: u64,
    command: String,
}

/// Cost from the measured ticks; `desk` holds the desk's commands.
fn cost(measured: Measured, desk: &[String]) -> miette::Result<MeasuredCost> {
    let Measured { controller_bytes, flash_bytes, ticks } = measured;
    if ticks.len() != desk.len() {
        return Err(miette::miette!("{} ticks were measured; expected {}", ticks.len(), desk.len()));
    }
    let (mut counts, mut cycles) = (Vec::new(), Vec::new());
    let mut fault = None;
    for (at, ticked) in ticks.iter().enumerate() {
        if let Some(reason) = ticked.command.strip_prefix("brake,") {
            fault = fault.or(Some(braked(at, reason)?));
        } else if at >= RUN_UP {
            counts.push(ticked.instructions);
            cycles.push(ticked.cycles);
        }
    }
    let mean = |all: &[u64]| all.iter().sum::<u64>() as f64 / all.len().max(1) as f64;
    Ok(MeasuredCost {
        cost: Cost {
            instructions: mean(&counts),
            instructions_max: counts.iter().copied().max().unwrap_or_default(),
            cycles: mean(&cycles),
            cycles_max: cycles.iter().copied().max().unwrap_or_default() as f64,
            flash: flash_bytes,
            ram: controller_bytes,
            matches_desk: ticks.iter().zip(desk).all(|(ticked, desk)| ticked.command == *desk),
        },
        instructions_min: counts.iter().copied().min().unwrap_or_default(),
        fault,
    })
}

/// Parses `CODE,JOINT`.
fn braked(tick: usize, reason: &str) -> miette::Result<Braked> {
    let fields = reason.split_once(',').and_then(|(code, joint)| Some((code.parse().ok()?, joint)));
    let (code, joint) = fields.ok_or_else(|| miette::miette!("tick {tick} braked for {reason:?}"))?;
    Ok(Braked { tick, code, joint: joint.parse().ok() })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::float_cmp, reason = "a test that fails should stop there; halves are exact")]
mod tests;
