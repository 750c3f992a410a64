//! `cargo xtask campaign`: injects every fault in every state of the safety state machine, and judges every tick.

use clap::Parser;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use sim::failure::{self, Failure};
use sim::output::Output;
use sim::pages;
use sim::terminal::{exit_code, json, keep_lines_of_messages, print, progress_bar, stop_on_interrupt};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use trials::campaign::{Campaign, Report, Target};

const EXAMPLES: &str = "\
Each run takes the machine to one of its states (idle, homing, idle and homed, armed, running, holding, fault; with drives also arming
and lowering), waits a random number of ticks, and lets one fault last for a random number of ticks, with the scene's own simulated arm in
the loop. After every tick a judge, written from docs/safety.md, looks whether the command was safe; with drives, whether the motion of the
arm was. Faults and states take turns: all of them come equally often.

Run K depends on the seed, K and the scenes alone. An unsafe command is printed with all that the machine was told and with what repeats
it: --seed S --run K and the same scenes and target.

Examples:
  cargo xtask campaign
  cargo xtask campaign --runs 10000 --write
  cargo xtask campaign --target drives --runs 10000 --write
  cargo xtask campaign --page out/campaign.html
  cargo xtask campaign scenes/yam_move.toml --target drives
  cargo xtask campaign --target qemu --runs 700 --write
  cargo xtask campaign scenes/puma560_pick.toml --seed 7 --run 4711
  cargo xtask campaign --json | jq '.rows[] | select(.unsafe_commands > 0)'

--json is an object {scenes, target, seed, runs, ticks, seconds, rows: [{fault, cells, runs, ticks, unsafe_commands}], counterexamples};
with drives also {exempt}, and in each row {motion: [exempt runs, farthest distance]}.
--write puts the table between the lines `<!-- measured: campaign, desk -->` and `<!-- end measured: campaign, desk -->` of the file,
with another target between those of `campaign, drives` or `campaign, qemu`.";

/// Inject every fault in every state of the safety state machine, and judge every tick.
#[derive(Clone, Debug, Parser)]
#[command(name = "cargo xtask campaign", after_long_help = EXAMPLES)]
struct Arguments {
    /// The scene files (TOML), used in turn [default: those of the target in scenes/campaign].
    #[arg(value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Number of runs.
    #[arg(long, default_value_t = 10_000)]
    runs: u64,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only the run with this number.
    #[arg(long, value_name = "K", conflicts_with = "runs")]
    run: Option<u64>,
    /// The target under test.
    #[arg(long, value_parser = targets(), default_value = "desk")]
    target: Target,
    /// Write the table into this file.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "docs/measured/campaign.md")]
    write: Option<PathBuf>,
    /// Write a page with the table in colours, for a browser.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "out/campaign.html")]
    page: Option<PathBuf>,
    /// Overwrite a file that another program wrote.
    #[arg(long)]
    force: bool,
    /// Print JSON only.
    #[arg(long)]
    json: bool,
}

/// The targets by their names.
fn targets() -> impl TypedValueParser<Value = Target> {
    let about = |target| match target {
        Target::Desk => "the firmware's session on the desk, with injected readings, lines and frames of the host",
        Target::Drives => {
            "the session and the drivers of the joints, with simulated drives on CAN buses and the arm that they move"
        }
        Target::Qemu => "the firmware in an emulated STM32F405, with the desk beside it",
    };
    let all = [Target::Desk, Target::Drives, Target::Qemu];
    let values = all.map(|target| PossibleValue::new(target.name()).help(about(target)));
    PossibleValuesParser::new(values)
        .map(move |name| all.into_iter().find(|target| target.name() == name).unwrap_or(Target::Desk))
}

/// Default scenes of a target.
fn scenes(target: Target) -> Vec<PathBuf> {
    let names: &[&str] = match target {
        Target::Desk | Target::Qemu => &["encoders", "states", "yam"],
        Target::Drives => {
            &["mini_cheetah_brakes", "mini_cheetah", "damiao_brakes", "damiao", "robstride_brakes", "robstride"]
        }
    };
    names.iter().map(|name| PathBuf::from(format!("scenes/campaign/{name}.toml"))).collect()
}

/// Largest number of runs; their outcomes are kept in memory until the end.
const RUNS_MAX: u64 = 10_000_000;

/// Runs the campaign, prints the table, and writes it into the documentation if requested. Returns the exit code.
///
/// # Errors
/// Wrong options or scenes, a chip that does not respond, or a file that cannot be written.
fn run(args: &Arguments, stop: &AtomicBool) -> Result<u8, Failure> {
    if !(1..=RUNS_MAX).contains(&args.runs) {
        return Err(Failure::Input(miette::miette!("--runs {}: expected 1 to {RUNS_MAX}", args.runs)));
    }
    let paths = if args.scenes.is_empty() { scenes(args.target) } else { args.scenes.clone() };
    let scenes = paths.iter().map(|path| SceneFile::load(path).map_err(Failure::input)).collect::<Result<_, _>>()?;
    let place = match args.target {
        Target::Desk => "campaign, desk",
        Target::Drives => "campaign, drives",
        Target::Qemu => "campaign, qemu",
    };
    // Check the files before the runs start.
    let mut output = Output::new(args.force);
    args.page.as_deref().map_or(Ok(()), |page| output.file(page))?;
    let document = pages::document(args.write.as_deref(), &[place])?;
    let campaign = Campaign {
        scenes,
        seed: args.seed,
        runs: args.run.map_or_else(|| (0..args.runs).collect(), |run| vec![run]),
        target: args.target,
    };
    let progress = if args.json { ProgressBar::hidden() } else { progress_bar(None, "runs") };
    let report = campaign.report(stop, &progress)?;
    document.map_or(Ok(()), |document| pages::fill(document, &[(place, report.markdown())]))?;
    if let Some(page) = &args.page {
        std::fs::write(page, report.page().html()).map_err(|error| failure::in_file(page, &error))?;
        output.finish()?;
    }
    let text = if args.json { json(&report)? } else { report.table() };
    print(&format!("{text}\n"))?;
    Ok(code(&report))
}

/// Exit code. An unsafe command counts more than a difference between chip and desk.
fn code(report: &Report) -> u8 {
    match report.counterexamples.iter().map(|found| found.law.is_some()).max() {
        None => 0,
        Some(true) => failure::FAULT,
        Some(false) => failure::PARITY,
    }
}

fn main() -> ExitCode {
    keep_lines_of_messages();
    exit_code(run(&Arguments::parse(), &stop_on_interrupt("end the campaign without a table")))
}
