//! `model energy`: runs a scene and computes its energy balance.

use crate::force::ForceArgs;
use crate::output::files;
use crate::run::{exit_code, set_duration};
use clap::Args;
use robot_compiler::SceneFile;
use sim::failure::{Failure, in_file};
use sim::pages;
use sim::run::files::file_name;
use sim::terminal::{json, print};
use std::fs::{self, File};
use std::io::{BufRead, BufReader, stdin};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::energy::{Account, account};
use studies::path_work::path_work;

const EXAMPLE: &str = "Example:\n  newtau model energy scenes/puma560_pick.toml";

const EXAMPLES: &str = "\
What is computed:
  work      int tau qd dt of every joint, positive and negative apart; tau as it acts, after delay, saturation and lag
  friction  int -tau_f qd dt of every joint
  contact   work of what pushes at the tip
  T         1/2 qd^T D qd, with rotors                                                             12.228
  V         -sum m g . r                                                                           12.230
  residual  work + friction + contact - (gain of T + V): what the quadrature misses
The trapezoid rule over the simulation's own steps: the residual falls with the square of `step` in the scene's [plant].

Examples:
  newtau model energy scenes/puma560_pick.toml
  newtau model energy scenes/planar2r_swing.toml --path states.jsonl
  newtau model energy scenes/planar2r_swing.toml --duration 1.8 --json | jq '.joints[0].positive'

Files, in the folder given by --out:
  energy.json  what --json prints
  report.html  the account, and the power of every joint over time: commanded torque times velocity

--path: states as JSON lines of t (s), q, qd and qdd instead of a run. Work is int tau qd dt by the trapezoid rule, with the
torques that the scene's simulated arm, payload, gravity and wrench take along them, without friction; two lines of one time
are a jump of the acceleration. No file is written.

A fault ends the account: what the brakes take is not in it. Exit codes as those of `run`.";

/// Options of `energy`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct EnergyArgs {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// Work along states given as JSON lines, instead of a run. - is standard input.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["duration", "out"])]
    pub path: Option<PathBuf>,
    /// Simulated time, s. Without it, the scene's.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub duration: Option<f64>,
    /// Folder for the files. Without it, out/NAME with the scene's name.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Runs a scene and prints its energy balance. Returns the exit code.
///
/// # Errors
/// A wrong scene, or a file that cannot be written.
pub fn run(args: &EnergyArgs, stop: &AtomicBool) -> Result<u8, Failure> {
    let mut scene = SceneFile::load(&args.scene).map_err(Failure::input)?;
    if let Some(path) = &args.path {
        return along(&scene, path, args.json).map(|()| 0);
    }
    set_duration(&mut scene, args.duration)?;
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(file_name(&scene.name)));
    // An error here is better before the run than after it.
    let mut output = args.force.output().reads(&args.scene);
    output.folder(&folder, &["energy.json", "report.html"])?;
    let (run, account) = account(&scene, stop)?;
    let json = json(&account)?;
    let file = folder.join("energy.json");
    fs::write(&file, format!("{json}\n")).map_err(|error| in_file(&file, &error))?;
    let report = folder.join("report.html");
    pages::write(&report, &account.page(&run.record))?;
    output.written(&[file.clone(), report.clone()])?;
    show(args.json, &json, &account, &[file, report])?;
    Ok(exit_code(&run))
}

fn show(as_json: bool, json: &str, account: &Account, written: &[PathBuf]) -> Result<(), Failure> {
    if as_json { print(&format!("{json}\n")) } else { print(&format!("{}\n{}", account.table(), files(written))) }
}

/// Prints the work along a path.
fn along(scene: &SceneFile, path: &Path, as_json: bool) -> Result<(), Failure> {
    let (source, mut input): (String, Box<dyn BufRead>) = if path == Path::new("-") {
        ("standard input".to_owned(), Box::new(stdin().lock()))
    } else {
        let source = path.display().to_string();
        let opened = File::open(path);
        let file = opened.map_err(|error| Failure::Input(miette::miette!("{source} cannot be read: {error}")))?;
        (source, Box::new(BufReader::new(file)))
    };
    let work = path_work(scene, &source, &mut *input)?;
    print(&if as_json { json(&work)? + "\n" } else { work.table() })
}
