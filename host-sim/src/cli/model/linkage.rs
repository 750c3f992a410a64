//! `model linkage`: a closed loop whose crank is driven through a turn, or simulated under a moment.

use crate::force::ForceArgs;
use crate::output::files;
use clap::Args;
use dynamics_core::linkage::{Branch, Linkage, LinkageError};
use robot_compiler::LinkageFile;
use robot_compiler::names::name;
use sim::failure::{self, Failure, number};
use sim::output::Output;
use sim::run::files::file_name;
use sim::terminal::{json, named, print};
use std::path::{Path, PathBuf};
use studies::linkage::files::{write_run, write_turn};
use studies::linkage::report::{describe_range, run_table, turn_table};
use studies::linkage::run::{self as free, Start};
use studies::linkage::turn::{self, Range};

const EXAMPLE: &str = "Example:\n  newtau model linkage robots/chapter12/four_bar.toml";

const EXAMPLES: &str = "\
Examples:
  newtau model linkage robots/chapter12/four_bar.toml
  newtau model linkage robots/chapter12/slider_crank.toml --speed 300 --steps 720 --json | jq .shaking_force
  newtau model linkage robots/chapter12/four_bar.toml --simulate 0.5 --duration 3

Driven: the crank turns at a constant speed, and at every step of a turn the nine equations of the three links, [A] x = b (12.44-12.46;
12.41 with m3 a3), give the driving moment M_0 and the joint forces F_0 to F_3. F_i acts through joint i on what comes after it.
The shaking force on the ground is F_3 - F_0 (12.47), weight included; its moment is about the crank's ground pivot, the motor's
reaction included. A crank that cannot turn fully is driven through all steps at which the loop closes.

Simulated: M = I(theta) thetadd + 1/2 I'(theta) thetad^2 + dV/dtheta (12.216 with one coordinate) under a constant moment on the crank, by
a Runge-Kutta method of fourth order. The balance is that of energy and work, E - E_0 = M (theta - theta_0).

Files, in the folder given by --out:
  driven.csv, report.html   over the crank's angle
  free.csv, report.html     over time, with --simulate
  summary.json                                                            what --json prints

Units: SI, radians. Angles count from the ground or the guide; see docs/theory/linkages.md.";

/// Options of `linkage`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct LinkageArgs {
    /// The linkage file (TOML).
    pub linkage: PathBuf,
    /// Speed of the crank, rad/s. Constant, and 10 by default. With --simulate it is the speed at the start, 0 by default.
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    pub speed: Option<f64>,
    /// Steps in a turn.
    #[arg(long, default_value_t = 360, value_parser = clap::value_parser!(u32).range(8..=100_000), conflicts_with = "simulate")]
    pub steps: u32,
    /// Assembly of the loop.
    #[arg(long, value_parser = named::<Branch>(), default_value = name(Branch::Open))]
    pub branch: Branch,
    /// Simulate the linkage under this moment on the crank, N m, instead of driving it.
    #[arg(long, value_name = "MOMENT", allow_negative_numbers = true)]
    pub simulate: Option<f64>,
    /// Simulated time, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, requires = "simulate", allow_negative_numbers = true)]
    pub duration: f64,
    /// Time step of the simulation, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 1e-4, requires = "simulate", allow_negative_numbers = true)]
    pub time_step: f64,
    /// Crank angle at which the simulation starts, rad. Default: the middle of its range, or 0 if the range is a whole turn.
    #[arg(long, value_name = "RAD", allow_negative_numbers = true, requires = "simulate")]
    pub angle: Option<f64>,
    /// Folder for table and report. Without it, out/NAME with the linkage's name.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// Print the summary as JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Most steps of a simulation: each is a line of the log.
const STEPS_MAX: f64 = 1e6;

/// Speed of a driven crank if none is given, rad/s.
const SPEED: f64 = 10.0;

/// Drives or simulates the linkage. Returns the exit code.
///
/// # Errors
/// A wrong file or option, or a result that cannot be written.
pub fn run(args: &LinkageArgs) -> Result<u8, Failure> {
    let linkage = LinkageFile::load(&args.linkage).map_err(Failure::input)?;
    let given = [("--speed", args.speed), ("--simulate", args.simulate), ("--angle", args.angle)];
    for (option, number) in given.into_iter().filter_map(|(option, number)| Some((option, number?))) {
        // The limit keeps the squares of all numbers finite; it is far beyond any machine.
        if number.is_nan() || number.abs() > 1e9 {
            return Err(Failure::Input(miette::miette!("{option} {number}: expected a number up to 1e9")));
        }
    }
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(file_name(&linkage.name)));
    match args.simulate {
        None => drive(args, &linkage, &folder),
        Some(moment) => simulate(args, &linkage, moment, &folder),
    }
}

/// Claims the output folder.
fn claimed(args: &LinkageArgs, folder: &Path) -> Result<Output, Failure> {
    let mut output = args.force.output().reads(&args.linkage);
    output.folder(folder, &["driven.csv", "free.csv", "summary.json", "report.html"])?;
    Ok(output)
}

fn drive(args: &LinkageArgs, linkage: &LinkageFile, folder: &Path) -> Result<u8, Failure> {
    let (branch, speed) = (args.branch, args.speed.unwrap_or(SPEED));
    let turn = turn::turn(linkage, branch, speed, args.steps);
    let summary = turn.summary(linkage, branch, speed);
    if turn.steps.is_empty() {
        let (steps, range) = (args.steps, describe_range(&summary.crank_range));
        return Err(Failure::Input(miette::miette!(
            help = "more steps, or other lengths",
            "{}: at none of the {steps} steps of a turn can the crank be driven: {range}",
            args.linkage.display()
        )));
    }
    let json = json(&summary)?;
    let output = claimed(args, folder)?;
    let written = write_turn(folder, &turn, &summary, &json)?;
    output.written(&written)?;
    show(args.json, &json, || turn_table(&summary), &written)?;
    Ok(0)
}

fn simulate(args: &LinkageArgs, linkage: &LinkageFile, moment: f64, folder: &Path) -> Result<u8, Failure> {
    let steps = (args.duration / args.time_step).ceil();
    if !(args.duration > 0.0 && args.time_step > 0.0 && steps <= STEPS_MAX) {
        let [duration, step] = [args.duration, args.time_step].map(number);
        return Err(Failure::Input(miette::miette!(
            "--duration {duration} --time-step {step}: expected times in s above zero that make at most {STEPS_MAX} steps"
        )));
    }
    let branch = args.branch;
    let range = turn::range(&linkage.mechanism.crank_range());
    let start = Start {
        branch,
        moment,
        angle: args.angle.unwrap_or_else(|| range.middle(&linkage.mechanism, branch)),
        speed: args.speed.unwrap_or(0.0),
        steps: steps as u32,
        time_step: args.time_step,
    };
    let run = free::run(linkage, &start).map_err(|error| no_start(args, &start, &range, error))?;
    let summary = run.summary(linkage, &start);
    let json = json(&summary)?;
    let output = claimed(args, folder)?;
    let written = write_run(folder, &run, &summary, &json)?;
    output.written(&written)?;
    show(args.json, &json, || run_table(&summary), &written)?;
    Ok(if run.stopped.is_some() { failure::FAULT } else { 0 })
}

/// Failure to start a linkage: the reason, and angles at which it could start.
fn no_start(args: &LinkageArgs, start: &Start, range: &Range, error: LinkageError<f64>) -> Failure {
    let (file, angle, branch) = (args.linkage.display(), start.angle, name(start.branch));
    let help = describe_range(range);
    Failure::Input(miette::miette!(
        help = help,
        "{file}: the linkage cannot start at a crank angle of {angle} rad on the {branch} branch: {error}"
    ))
}

fn show(as_json: bool, json: &str, table: impl Fn() -> String, written: &[PathBuf]) -> Result<(), Failure> {
    if as_json { print(&format!("{json}\n")) } else { print(&format!("{}\n{}", table(), files(written))) }
}
