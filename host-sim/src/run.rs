//! `run`: runs the closed loop of a scene, and prints and writes the result.

use crate::force::ForceArgs;
use crate::output::files;
use board::chip::on_chip;
use clap::{Args, ValueEnum};
use dynamics_core::control::{ControlLaw, SpringOwner};
use dynamics_core::trig::Method;
use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use robot_compiler::check::{Severity, scene_findings};
use robot_compiler::names::name;
use robot_compiler::scene::{ScalarChoice, TeachSpec};
use sim::failure::{self, Failure, number};
use sim::run::closed_loop::End;
use sim::run::files::{file_name, write, write_report};
use sim::run::mcap_file;
use sim::run::simulate::Run;
use sim::run::simulation;
use sim::terminal::{self, json, named, print, progress_bar, say_mounting};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const EXAMPLE: &str = "Example:\n  newtau run scenes/yam_split.toml";

const EXAMPLES: &str = "\
Examples:
  newtau run scenes/puma560_pick.toml
  newtau run scenes/puma560_pick.toml --target qemu
  newtau run scenes/puma560_pick.toml --law pd --scalar f64 --out out/pd
  newtau run scenes/puma560_pick.toml --mcap out/pick.mcap
  newtau run scenes/puma560_pick.toml --json | jq .tracking_max

Files, in the folder given by --out:
  log.csv       every tick: time, and per joint reference and actual position and velocity, torque, limits; the fault
  summary.json  what --json prints
  report.html   all of that on one page, for a browser: the arm, the curves, the numbers (docs/report.md); --report chooses the file

Terms that the scene's model calls live are fed from its [plant], to the desk's controller and to the chip's alike.

A fault brakes the arm (drives released, brakes engaged); the run goes on to its end and exits with 3.
The safety state machine is not in a run: `connect` has it. A joint that leaves its reference by more than `reach` of the
scene's [safety] is reported, with the tick in which the firmware would have held.

Columns:
  at rest, settles in
                    error at the end of the last stretch in which every reference stands still, and the settling time: from the
                    start of that stretch until the error is within 2 % of the joint's last move, or within `resolution` of
                    [safety] if that is more, and stays there; `not in 1.00 s` if it was still outside after 1 s
  chatter           root mean square of the torque's change from one tick to the next; with encoders most of it is the
                    counts, which the velocity gain turns into torque";

/// Target that computes the torques.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// This program.
    Desk,
    /// The firmware, in an emulated STM32F405.
    Qemu,
}

/// Options of `run`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct RunArgs {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// Program that computes the torques: this one (desk), or the firmware in an emulated STM32F405 (qemu).
    #[arg(long, value_enum, default_value_t = Target::Desk)]
    pub target: Target,
    /// Floating-point type of the controller. Without it, the scene's. The chip has only f32.
    #[arg(long, value_parser = named::<ScalarChoice>())]
    pub scalar: Option<ScalarChoice>,
    /// The controller's method for sine and cosine. Without it, the scene's.
    #[arg(long, value_parser = named::<Method>())]
    pub trig: Option<Method>,
    /// The control law. Without it, the scene's.
    #[arg(long, value_parser = named::<ControlLaw>())]
    pub law: Option<ControlLaw>,
    /// A file with another table `[motion]`, such as `newtau model motion` writes. Without it, the scene's motion.
    #[arg(long, value_name = "FILE")]
    pub motion: Option<PathBuf>,
    /// Simulated time, s. Without it, the scene's.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub duration: Option<f64>,
    /// Folder for log, summary and report. Without it, out/NAME with the scene's name.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Also write the run as an MCAP file with the arm's URDF, for Foxglove and PlotJuggler.
    #[arg(long, value_name = "FILE")]
    pub mcap: Option<PathBuf>,
    /// File for the report. Without it, report.html in the output folder.
    #[arg(long, value_name = "FILE", conflicts_with = "no_report")]
    pub report: Option<Option<PathBuf>>,
    /// Write no report.
    #[arg(long)]
    pub no_report: bool,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// Print the summary as JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
    /// Print no progress bar and no table.
    #[arg(long)]
    pub quiet: bool,
}

/// Returns a flag that Ctrl-C sets. The loop checks it in every tick, and no tick waits longer than the chip's timeout.
#[must_use]
pub fn stop_on_interrupt() -> Arc<AtomicBool> {
    terminal::stop_on_interrupt("end the run without a summary")
}

/// Runs a scene. Returns the exit code.
///
/// # Errors
/// A wrong scene; a file that cannot be written; a target that died (the record up to then is written first).
pub fn run(args: &RunArgs, stop: &AtomicBool) -> Result<u8, Failure> {
    let scene = scene(args)?;
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(file_name(&scene.name)));
    // An error here is better before the run than after it.
    let mut output = args.force.output().reads(&args.scene);
    if let Some(motion) = &args.motion {
        output = output.reads(motion);
    }
    output.folder(&folder, &["log.csv", "summary.json"])?;
    let report = (!args.no_report).then(|| args.report.clone().flatten().unwrap_or_else(|| folder.join("report.html")));
    [report.as_deref(), args.mcap.as_deref()].into_iter().flatten().try_for_each(|path| output.file(path))?;
    let progress = if args.json || args.quiet { ProgressBar::hidden() } else { progress_bar(None, "ticks") };
    let run = match args.target {
        Target::Desk => simulation::run(&scene, stop, &progress)?,
        Target::Qemu => on_chip::run(&scene, stop, &progress)?,
    };
    let mut written = write(&run, &folder)?;
    if let Some(path) = &args.mcap {
        mcap_file::run::write(&run.record, &scene, path)?;
        written.push(path.clone());
    }
    if let Some(path) = &report {
        written.push(write_report(&run, &scene, path)?);
    }
    output.written(&written)?;
    show(args, &run, &written)?;
    let code = exit_code(&run);
    match run.failure {
        Some(report) => Err(Failure::Target(report)),
        None => Ok(code),
    }
}

/// The scene with the changes of the command line.
fn scene(args: &RunArgs) -> Result<SceneFile, Failure> {
    if args.target == Target::Qemu
        && let Some(scalar) = args.scalar.filter(|scalar| *scalar != ScalarChoice::F32)
    {
        return Err(Failure::Input(miette::miette!(
            "--scalar {} with --target qemu: expected f32, which the chip has",
            name(scalar)
        )));
    }
    let mut scene = SceneFile::load(&args.scene).map_err(Failure::input)?;
    say_mounting(&scene.robot);
    for doubt in scene_findings(&scene).iter().filter(|finding| finding.severity == Severity::Doubt) {
        eprintln!("doubt: {}; {}", doubt.place, doubt.place.expected());
    }
    if let Some(motion) = &args.motion {
        scene.take_motion(motion).map_err(Failure::input)?;
    }
    set_duration(&mut scene, args.duration)?;
    if let Some(law) = args.law {
        scene.control.law = law;
        // The settings of a scene that specifies only this law.
        scene.control.teach = (law.is_hand_guided())
            .then(|| scene.control.teach.take().unwrap_or_else(|| TeachSpec::default_for(&scene.robot)));
        if let Some(joint) =
            scene.robot.joints.iter().find(|joint| law.traits().spring == SpringOwner::Drive && !joint.has_own_loop())
        {
            let named = &joint.name;
            return Err(Failure::Input(miette::miette!(
                help = "expected a [joint.drive] of kind mit, damiao, robstride or myactuator for every joint",
                "--law split: the joint {named:?} has no drive with a position loop of its own"
            )));
        }
    }
    if let Some(trig) = args.trig {
        scene.control.trig = trig;
    }
    if let Some(scalar) = args.scalar {
        scene.control.scalar = scalar;
    }
    Ok(scene)
}

/// Changes the scene's duration, if another one is given.
pub(crate) fn set_duration(scene: &mut SceneFile, duration: Option<f64>) -> Result<(), Failure> {
    if let Some(duration) = duration {
        if !(duration.is_finite() && duration > 0.0) {
            let duration = number(duration);
            return Err(Failure::Input(miette::miette!("--duration {duration}: expected a time in s above zero")));
        }
        scene.duration = Some(duration);
    }
    Ok(())
}

fn show(args: &RunArgs, run: &Run, written: &[PathBuf]) -> Result<(), Failure> {
    if args.json {
        return print(&format!("{}\n", json(&run.summary)?));
    }
    if args.quiet { Ok(()) } else { print(&format!("{}\n{}", run.summary.table(), files(written))) }
}

/// The exit code for a run.
pub(crate) fn exit_code(run: &Run) -> u8 {
    let differs = run.summary.parity.is_some_and(|parity| parity.mismatches > 0);
    match run.end {
        _ if differs => failure::PARITY,
        End::Interrupted => failure::INTERRUPTED,
        End::Diverged(_) => failure::FAULT,
        End::TargetFailed => failure::OUTSIDE,
        End::Complete if run.summary.faults.is_empty() => 0,
        End::Complete => failure::FAULT,
    }
}
