//! What a control tick of each of many scenes costs on the chip: instructions, flash, RAM.
//!
//! Each controller is built into a program of its own, which runs it over the same ticks of the scenes' motion
//! ([`robot_compiler::emit::cost::inputs`]) in the emulator, in the scene's own scalar. The desk's controller gets the same ticks, and
//! must give the same bits.
//!
//! A program of its own, because controllers that share one share functions too, which are then no longer compiled into each tick with
//! its numbers: a tick of 1,298 instructions took 2,228 in a program with nine others.

use crate::chip::run_cost;
use crate::failure::Failure;
use crate::run::simulate;
use crate::run::target::Torques;
use chip_image::cycles::{Code, Estimate, Estimator, Memory, Placement, trace};
use chip_image::{Program, Reached};
use dynamics_core::{Command, Fault, Model, Real};
use indicatif::ProgressBar;
use miette::IntoDiagnostic as _;
use robot_compiler::emit::cost::{Input, RUN_UP, difference, inputs};
use robot_compiler::scene::ScalarChoice;
use robot_compiler::{SceneFile, with_dof};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Scenes that are handed over to be built and run at once; `stop` and the progress are looked at in between.
const BATCH: usize = 8;

/// The tick's symbol in the program that measures it.
pub const TICK: &str = "tick_0";

/// Instructions of the ticks that drive; all zero where none does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Instructions {
    /// Fewest in a tick.
    pub min: u64,
    /// Most in a tick.
    pub max: u64,
    /// Mean over the ticks.
    pub mean: f64,
}

/// Cycles of the ticks that drive, as `chip_image::cycles` finds them likely, with the core's caches as the ticks before left them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cycles {
    /// Most in a tick.
    pub max: f64,
    /// Mean over the ticks.
    pub mean: f64,
}

/// A tick that braked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Braked {
    /// The first, counted from 0 with the run-up.
    pub tick: usize,
    /// The stable number of its fault.
    pub code: u8,
    /// The joint at fault, counted from 0, if it is one joint's.
    pub joint: Option<u8>,
}

impl Braked {
    /// The fault; none where this version does not know its number.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        Fault::from_code(self.code, self.joint.unwrap_or_default())
    }
}

/// Where the tick lies in the measuring program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Tick {
    /// The function's symbol. A tick begins at its first instruction and ends where it returns to: behind the instruction that called it.
    pub symbol: String,
    /// Its first instruction.
    pub address: u64,
    /// Length of the function alone, bytes.
    pub bytes: u64,
    /// The program.
    pub program: PathBuf,
}

/// What a control tick of a scene costs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// Instructions, over the counted ticks.
    pub instructions: Instructions,
    /// Cycles from flash, over the same ticks: an estimate.
    pub cycles: Cycles,
    /// Bytes of the tick, of all that it calls and of the constants that they read. What several scenes share counts in full for each.
    pub flash_bytes: u64,
    /// Bytes of the controller and, where it runs from RAM, of its kernel.
    pub ram_bytes: u64,
    /// Whether every command is the desk's, bit by bit.
    pub matches_desk: bool,
    /// The first tick that braked, if one did. Those that did are not among the counted.
    pub fault: Option<Braked>,
    /// Where the tick lies.
    pub tick: Tick,
}

/// Measure a tick of each scene, in the order of the files.
///
/// # Errors
/// [`Failure::Input`] for a scene that cannot be read or moved, with its file and line, and for scenes that differ in robot, rate, motion,
/// duration or sensors: what they cost could not be compared. [`Failure::Target`] where a program cannot be built or run, with the scene;
/// [`Failure::Interrupted`] when `stop` is set on the way.
pub fn measure(scenes: &[PathBuf], stop: &AtomicBool, progress: &ProgressBar) -> Result<Vec<Cost>, Failure> {
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
            // Ctrl-C reaches the compiler too.
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

/// A list of scene files for the build; it goes with this.
struct List(PathBuf);

impl List {
    fn new(scenes: &[SceneFile]) -> std::io::Result<Self> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("newtau-{}-{count}.scenes", std::process::id()));
        let lines: String = scenes.iter().map(|scene| format!("{}\n", scene.path.display())).collect();
        std::fs::write(&path, lines)?;
        Ok(Self(path))
    }
}

impl Drop for List {
    fn drop(&mut self) {
        std::fs::remove_file(&self.0).ok();
    }
}

fn measure_batch(scenes: &[SceneFile]) -> Result<Vec<Cost>, Failure> {
    let desk: Vec<Vec<String>> =
        scenes.iter().map(|scene| with_dof!(scene.robot.dof(), N => commands::<N>(scene))).collect::<Result<_, _>>()?;
    let list = List::new(scenes).map_err(Failure::Output)?;
    let said = run_cost(&list.0).map_err(|error| Failure::Target(miette::Report::from_err(error)))?;
    let programs: Vec<&str> = said.split("program,").skip(1).collect();
    if programs.len() != desk.len() {
        let count = programs.len();
        return Err(Failure::Target(miette::miette!("{count} programs were measured; expected {}", desk.len())));
    }
    programs.iter().zip(&desk).map(|(said, desk)| cost(said, desk).map_err(Failure::Target)).collect()
}

/// The desk's commands in the words of the chip, tick by tick.
fn commands<const N: usize>(scene: &SceneFile) -> Result<Vec<String>, Failure> {
    match scene.control.scalar {
        ScalarChoice::F32 => commands_in::<f32, N>(scene, &mut simulate::desk(scene, &model(scene)?)),
        ScalarChoice::F64 => commands_in::<f64, N>(scene, &mut simulate::desk(scene, &model(scene)?)),
        ScalarChoice::Mixed => commands_in::<f64, N>(scene, &mut simulate::mixed_desk(scene, &model(scene)?)),
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

/// A command as the chip writes it.
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

/// The cost from the program's path and what it said.
fn cost(said: &str, desk: &[String]) -> miette::Result<Cost> {
    let path = PathBuf::from(said.lines().next().unwrap_or_default());
    let bytes = std::fs::read(&path).into_diagnostic()?;
    let program = Program::parse(&bytes).into_diagnostic()?;
    let ran = ran(said, 0, desk)?;
    let reached = program.reached_from(ran.address).into_diagnostic()?;
    Ok(Cost {
        instructions: ran.instructions,
        cycles: cycles(&path, &bytes, &ran, &reached)?,
        flash_bytes: reached.flash_bytes(),
        ram_bytes: ran.controller_bytes + reached.sram_bytes(),
        matches_desk: ran.matches_desk,
        fault: ran.fault,
        tick: Tick {
            symbol: TICK.to_owned(),
            address: ran.address & !1,
            bytes: program.function(ran.address).into_diagnostic()?.bytes,
            program: path,
        },
    })
}

/// Trace the program once more, instruction by instruction; every instruction that was counted must be in the trace.
fn cycles(path: &Path, bytes: &[u8], ran: &Ran, reached: &Reached) -> miette::Result<Cycles> {
    let code = Code::parse(bytes).into_diagnostic()?;
    let whole = |x: u64| u32::try_from(x).into_diagnostic();
    let start = whole(ran.address & !1)?;
    let Some(back) = code.behind_call_in("Counter4call") else {
        return Err(miette::miette!("{}: nothing in it counts calls", path.display()));
    };
    let all = reached.functions.iter().map(|function| {
        let first = function.address & !1;
        Ok(whole(first)?..whole(first + function.bytes)?)
    });
    // Where the call goes on ends each stretch.
    let ranges: Vec<_> = all.chain(core::iter::once(Ok(back..back + 2))).collect::<miette::Result<_>>()?;
    let mut estimator = Estimator::new(&code, Memory::new(Placement::ByAddress));
    let mut ticks: Vec<Estimate> = Vec::new();
    let mut begun = false;
    trace::run_within(path, &[(start, back)], &ranges, |_, address| {
        // No instruction inside jumps back to the function's start.
        if address == start && core::mem::replace(&mut begun, true) {
            ticks.push(estimator.finish());
        }
        estimator.execute(address);
    })
    .into_diagnostic()?;
    ticks.push(estimator.finish());
    let counted = ticks.get(RUN_UP..).unwrap_or_default();
    let traced = counted.iter().map(|tick| tick.instructions).sum::<u64>() as f64 / counted.len().max(1) as f64;
    // The program leaves out what a call that does nothing takes.
    let empty = traced - ran.instructions.mean;
    if ran.fault.is_none() && !(0.0..=EMPTY_MAX).contains(&empty) {
        return Err(miette::miette!(
            "{}: {traced} instructions of a tick were traced, {} counted",
            path.display(),
            ran.instructions.mean
        ));
    }
    let likely = counted.iter().map(|tick| tick.cycles.likely as f64);
    Ok(Cycles { max: likely.clone().fold(0.0, f64::max), mean: likely.sum::<f64>() / counted.len().max(1) as f64 })
}

/// Most instructions of a function that gives a fault back and does nothing else.
const EMPTY_MAX: f64 = 16.0;

/// What the program said of a scene.
#[derive(Debug, PartialEq)]
struct Ran {
    address: u64,
    controller_bytes: u64,
    instructions: Instructions,
    matches_desk: bool,
    fault: Option<Braked>,
}

/// What the program said of the scene with this number; `desk` has the desk's commands.
fn ran(said: &str, scene: usize, desk: &[String]) -> miette::Result<Ran> {
    let (head, tick) = (format!("scene,{scene},"), format!("tick,{scene},"));
    let broken = |line: &str| {
        miette::miette!(
            "the measuring program says {line:?} of scene {scene}; expected its address and {} ticks",
            desk.len()
        )
    };
    let head = said.lines().find_map(|line| line.strip_prefix(head.as_str())).ok_or_else(|| broken(""))?;
    let (address, controller_bytes) = head.split_once(',').ok_or_else(|| broken(head))?;
    let number = |text: &str| text.parse::<u64>().map_err(|_| broken(text));
    let ticks: Vec<&str> = said.lines().filter_map(|line| line.strip_prefix(tick.as_str())).collect();
    if ticks.len() != desk.len() {
        return Err(broken(&format!("{} ticks", ticks.len())));
    }
    let mut counts = Vec::new();
    let (mut fault, mut matches_desk) = (None, true);
    for (at, (line, desk)) in ticks.iter().zip(desk).enumerate() {
        let fields: Vec<&str> = line.splitn(3, ',').collect();
        let &[_, count, command] = fields.as_slice() else { return Err(broken(line)) };
        let count = number(count)?;
        matches_desk &= command == desk;
        if let Some(reason) = command.strip_prefix("brake,") {
            let (code, joint) = reason.split_once(',').ok_or_else(|| broken(line))?;
            let code = code.parse().map_err(|_| broken(line))?;
            fault = fault.or(Some(Braked { tick: at, code, joint: joint.parse().ok() }));
        } else if at >= RUN_UP {
            counts.push(count);
        }
    }
    let instructions = Instructions {
        min: counts.iter().copied().min().unwrap_or_default(),
        max: counts.iter().copied().max().unwrap_or_default(),
        mean: counts.iter().sum::<u64>() as f64 / counts.len().max(1) as f64,
    };
    Ok(Ran {
        address: number(address)?,
        controller_bytes: number(controller_bytes)?,
        instructions,
        matches_desk,
        fault,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::float_cmp, reason = "a test that fails should stop there; halves are exact")]
mod tests {
    use super::*;

    /// What a program says whose first tick braked, whose run-up took 9 and whose two counted ticks took 10 and 13.
    fn said(first: &str, count: usize) -> String {
        let tick = |at: usize| match at {
            0 => format!("tick,0,0,7,{first}\n"),
            at if at < RUN_UP => format!("tick,0,{at},9,drive,1,0\n"),
            at => format!("tick,0,{at},{},drive,1,0\n", 10 + 3 * (at - RUN_UP)),
        };
        let ticks: String = (0..count).map(tick).collect();
        format!("scene,1,5,6\nscene,0,134217729,200\n{ticks}tick,1,0,1,drive,1,0\n")
    }

    fn desk() -> Vec<String> {
        vec!["drive,1,0".to_owned(); RUN_UP + 2]
    }

    #[test]
    fn ticks_after_the_run_up_are_counted_and_compared() {
        let ran = ran(&said("drive,1,0", RUN_UP + 2), 0, &desk()).unwrap();
        let instructions = Instructions { min: 10, max: 13, mean: 11.5 };
        let address = 0x0800_0001;
        assert_eq!(ran, Ran { address, controller_bytes: 200, instructions, matches_desk: true, fault: None });
    }

    #[test]
    fn a_tick_that_differs_or_brakes_is_told() {
        let count = RUN_UP + 2;
        assert!(!ran(&said("drive,2,0", count), 0, &desk()).unwrap().matches_desk);
        let braked = ran(&said("brake,5,2", count), 0, &desk()).unwrap();
        assert_eq!(braked.fault, Some(Braked { tick: 0, code: 5, joint: Some(2) }));
        assert_eq!(braked.fault.unwrap().fault(), Some(Fault::VelocityOutOfBounds { joint: 2 }));
        assert!(!braked.matches_desk);
        assert_eq!(ran(&said("brake,3,", count), 0, &desk()).unwrap().fault.unwrap().joint, None);
    }

    #[test]
    fn a_program_that_stops_early_or_says_nonsense_is_an_error() {
        assert!(ran(&said("drive,1,0", RUN_UP), 0, &desk()).is_err());
        assert!(ran(&said("drive,1,0", RUN_UP + 2), 2, &desk()).is_err());
        assert!(ran(&said("drive,1,0", RUN_UP + 2).replace("7,drive", "x,drive"), 0, &desk()).is_err());
    }

    #[test]
    fn scenes_whose_ticks_are_not_the_same_are_refused_by_name() {
        let load = |name: &str| {
            SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/{name}.toml"))).unwrap()
        };
        let (puma, planar) = (load("puma560_pick"), load("planar2r_swing"));
        let mut lesser = puma.clone();
        lesser.model.friction = false;
        assert!(comparable(&[puma.clone(), lesser]).is_ok());
        let said = comparable(&[puma, planar]).unwrap_err().report().to_string();
        assert!(said.contains("planar2r_swing.toml: robot: not that of "), "{said}");
    }
}
