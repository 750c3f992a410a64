//! `doctor`: finds missing or wrong tools, and gives advice.

mod bundle;
mod report;

use crate::cli::firmware::key;
use crate::force::ForceArgs;
use board::chip;
use board::session::doctor::{self, Check, State, Use};
use clap::Args;
use link::Pacing;
use report::Report;
use robot_compiler::SceneFile;
use sim::failure::{self, Failure};
use std::io::{self, Write};
use std::path::PathBuf;

const EXAMPLE: &str = "Example:\n  newtau doctor";

const EXAMPLES: &str = "\
Examples:
  newtau doctor
  newtau doctor --for emulator,flash
  newtau doctor --port /dev/ttyACM0 --scene scenes/examples/mit6_wave.toml
  newtau doctor --scene scenes/yam_move.toml --bundle out/bug.md

What is missing is a problem for a use that needs it and a warning otherwise:
  desk       a Rust compiler
  emulator   and the chip's target, qemu-system-arm
  flash      and the chip's target, probe-rs, a probe
  --port     firmware on that port that speaks this protocol; with --scene, built from that scene

Asking the firmware who it is disturbs no session. Exit code 2 when there is a problem.

--json is an object {for, problems, warnings, checks}, each check {name, state, found, advice}.";

/// Options of `doctor`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct DoctorArgs {
    /// Intended uses.
    #[arg(long = "for", value_enum, value_delimiter = ',', value_name = "USE,..", default_value = "desk")]
    pub uses: Vec<Use>,
    /// The serial port of the board's link. The firmware's protocol is checked, and with --scene its scene.
    #[arg(long)]
    pub port: Option<String>,
    /// The scene that the firmware should have been built from.
    #[arg(long)]
    pub scene: Option<PathBuf>,
    /// The key file of the board (`newtau firmware key new`); the board must prove that it has it.
    #[arg(long, value_name = "FILE", requires = "port")]
    pub key: Option<PathBuf>,
    /// Write a file for a bug report: versions, these checks, the scene and its robot. It contains no keys and not the name of the home folder.
    #[arg(long, value_name = "FILE")]
    pub bundle: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Performs all checks and prints them. Returns the exit code.
///
/// # Errors
/// A wrong scene; output that cannot be written.
pub fn run(args: &DoctorArgs) -> Result<u8, Failure> {
    let scene = args.scene.as_deref().map(SceneFile::load).transpose().map_err(Failure::input)?;
    let hello = scene.as_ref().map(|scene| chip::hello_of(scene, Pacing::LockStep)).transpose()?;
    let mut checks = doctor::tool_checks(&args.uses);
    if let (Some(scene), Some(hello)) = (&scene, &hello) {
        checks.push(doctor::scene_check(scene, hello));
    }
    if let Some(port) = &args.port {
        let key = key::given(args.key.as_deref())?;
        checks.extend(doctor::board_checks(port, hello.as_ref(), key));
    }
    let count = |state| checks.iter().filter(|check| check.state == state).count();
    let report = Report { uses: &args.uses, problems: count(State::Problem), warnings: count(State::Warning), checks };
    if let Some(path) = &args.bundle {
        let mut output =
            args.scene.iter().chain(&args.key).fold(args.force.output(), |output, path| output.reads(path));
        output.write(path, &bundle::text(&report, scene.as_ref())?)?;
    }
    match show(args, &report) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::Output(error)),
        Ok(()) | Err(_) => Ok(if report.problems > 0 { failure::INPUT } else { 0 }),
    }
}

fn show(args: &DoctorArgs, report: &Report<'_>) -> io::Result<()> {
    let mut out = io::stdout().lock();
    if args.json {
        return writeln!(out, "{}", serde_json::to_string_pretty(report)?);
    }
    for Check { name, state, found, advice } in &report.checks {
        writeln!(out, "{:<9}{name:<14}{found}", state.name())?;
        if let Some(advice) = advice {
            writeln!(out, "{:<23}{advice}", "")?;
        }
    }
    let count = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    writeln!(out, "{}, {}", count(report.problems, "problem"), count(report.warnings, "warning"))
}
