//! `sweep`: the runs of a study, or a part of them.

use crate::force::ForceArgs;
use crate::output::files;
use clap::Args;
use indicatif::ProgressBar;
use sim::failure::{self, Failure};
use sim::output::Output;
use sim::pages;
use sim::parallel::Jobs;
use sim::run::files::file_name;
use sim::terminal::{json, named, print, progress_bar};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::sweep::Prepared;
use studies::sweep::replay::{Replayed, replay};
use studies::sweep::results::{FILES, Results};
use studies::sweep::store::STUDY;
use studies::sweep::store::{self, Done, Progress, Shard};
use studies::sweep::submit::{self, Engine, Submission};

const EXAMPLE: &str = "Example:\n  newtau sweep scenes/studies/pick_payload_friction.toml --runs 64";

const EXAMPLES: &str = "\
A study names a scene and what varies in it (docs/studies.md). Run K depends on the study and K alone: the same bits on any machine, with
any number of threads, in any shard.

Examples:
  newtau sweep scenes/studies/pick_payload_friction.toml
  newtau sweep scenes/studies/pick_payload_friction.toml --runs 100000 --jobs 8 --out out/pick
  newtau sweep scenes/studies/pick_payload_friction.toml --replay 4711 --out out/run4711
  newtau sweep STUDY.toml --shard 3/50 --out out/shards/3
  newtau sweep merge out/shards --out out/whole
  newtau sweep STUDY.toml --runs 1000000000 --submit slurm --shards 1000 --out out/big

Files, in the folder given by --out:
  runs.csv                   a row for each run: index, values, figures, end, pass
  manifest.json              what is sure of it: rows, bytes, SHA-256; after a kill the same command continues from there
  study.toml, scene.toml, robot.toml
                             copies that name each other: the folder is a study of its own
  results.json, results.md, report.html   distributions, rank correlations, failures with intervals, the worst runs; not for a shard

--replay writes scene.toml and robot.toml with the run's values, and what `newtau run` writes of them; it replaces no other such files.";

/// Options of `sweep`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct SweepArgs {
    /// The study file (TOML).
    pub study: PathBuf,
    /// Folder for the runs. Without it, out/NAME with the study's name; with --replay, the index follows the name.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Number of runs. Without it, the study's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000_000))]
    pub runs: Option<u64>,
    /// Run only part K of N.
    #[arg(long, value_name = "K/N", default_value_t = Shard::WHOLE, hide_default_value = true)]
    pub shard: Shard,
    /// Number of threads. Without it, one for each core.
    #[arg(long, value_name = "THREADS")]
    pub jobs: Option<NonZeroUsize>,
    /// Run only the run with this index, with its log and report.
    #[arg(long, value_name = "INDEX", conflicts_with_all = ["shard", "json", "write"])]
    pub replay: Option<u64>,
    /// Run nothing. Write the files that submit the study to this engine, in --shards parts.
    #[arg(long, value_name = "ENGINE", value_parser = named::<Engine>(), requires = "shards")]
    #[arg(conflicts_with_all = ["shard", "json", "write", "replay"])]
    pub submit: Option<Engine>,
    /// Number of shards, with --submit.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000), requires = "submit")]
    pub shards: Option<u64>,
    /// Write the results into this page, after its line `<!-- measured: NAME -->` with the study's name.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "docs/measured/studies.md")]
    pub write: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// Print results.json, and nothing else.
    #[arg(long)]
    pub json: bool,
    /// Print no progress bar and no table.
    #[arg(long)]
    pub quiet: bool,
}

/// Runs a study, or a part of it. Returns the exit code.
///
/// # Errors
/// A wrong study or folder, or a file that cannot be written.
pub fn run(args: &SweepArgs, stop: &AtomicBool) -> Result<u8, Failure> {
    let prepared = Prepared::load(&args.study, args.runs)?;
    let name = args.replay.map_or_else(String::new, |index| format!("_{index}"));
    let name = file_name(&prepared.study.name) + &name;
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(name));
    if let Some(index) = args.replay {
        return replayed(args, &prepared, index, &folder, stop);
    }
    if let (Some(engine), Some(shards)) = (args.submit, args.shards) {
        return submitted(args, &prepared, &folder, engine, shards);
    }
    if args.write.is_some() && !args.shard.is_whole() {
        return Err(Failure::Input(miette::miette!("--write beside --shard: expected the whole study")));
    }
    // An error here is better before the runs than after them.
    let page = pages::document(args.write.as_deref(), &[&prepared.study.name])?;
    let mut output = outputs(args, &prepared);
    if folder.join(store::MANIFEST).exists() {
        // Runs that exist are continued. The store checks that they belong to this study.
        output.known_folder(&folder, FILES)?;
    } else {
        prepared.may_lie_in(&folder)?;
        // An empty table is what a kill leaves in the first milliseconds.
        let is_empty =
            std::fs::metadata(folder.join(store::RUNS)).is_ok_and(|table| table.is_file() && table.len() == 0);
        let table: &[&str] = if is_empty { &[] } else { &[store::RUNS] };
        output.folder(&folder, &[FILES, table].concat())?;
    }
    let Some(done) = write(args, &prepared, &folder, stop)? else { return Ok(failure::INTERRUPTED) };
    if !args.shard.is_whole() {
        let written = format!("shard {}: {} runs in {}\n", args.shard, done.manifest.rows, folder.display());
        print(if args.quiet || args.json { "" } else { &written })?;
        return Ok(0);
    }
    let results = Results::of(&prepared, &folder)?;
    if let Some(page) = page {
        pages::fill(page, &[(&prepared.study.name, results.measured())])?;
    }
    let pace = format!("{:<21}{}\n", "pace", pace(&done));
    show(&Shown { json: args.json, quiet: args.quiet, pace: &pace }, &prepared, &results, &folder, &output)?;
    Ok(0)
}

/// Outputs of the command: the study and its scenes are never overwritten.
fn outputs(args: &SweepArgs, prepared: &Prepared) -> Output {
    args.force.output().reads(&args.study).reads(&prepared.study.experiment.scene)
}

/// Does the runs; `None` if they were interrupted.
fn write(args: &SweepArgs, prepared: &Prepared, folder: &Path, stop: &AtomicBool) -> Result<Option<Done>, Failure> {
    let jobs = Jobs::new(args.jobs.map(NonZeroUsize::get)).map_err(Failure::Output)?;
    let indices = args.shard.indices(prepared.count);
    let bar = if args.json || args.quiet { ProgressBar::hidden() } else { progress_bar(None, "runs") };
    bar.set_length(indices.end - indices.start);
    let progress = Progress { shard: args.shard, jobs: &jobs, stop, after_block: &|rows| bar.set_position(rows) };
    let done = store::write(prepared, folder, &progress);
    bar.finish_and_clear();
    match done {
        Ok(done) => Ok(Some(done)),
        Err(Failure::Interrupted) => {
            eprintln!("interrupted; the same command continues in {}", folder.display());
            Ok(None)
        }
        Err(other) => Err(other),
    }
}

/// Speed of the runs, as text.
fn pace(done: &Done) -> String {
    let runs = done.manifest.rows - done.found;
    let seconds = done.time.as_secs_f64();
    let found = if done.found > 0 { format!(", {} were there", done.found) } else { String::new() };
    format!("{runs} runs in {seconds:.1} s: {:.0} a second{found}", runs as f64 / seconds.max(1e-9))
}

/// Settings for printing the results.
pub(super) struct Shown<'a> {
    pub(super) json: bool,
    pub(super) quiet: bool,
    /// A line with the duration and speed of the runs.
    pub(super) pace: &'a str,
}

/// Writes the results, and prints them.
pub(super) fn show(
    shown: &Shown<'_>,
    prepared: &Prepared,
    results: &Results,
    folder: &Path,
    output: &Output,
) -> Result<(), Failure> {
    let written = results.write(folder, prepared)?;
    output.written(&FILES.iter().map(|name| folder.join(name)).collect::<Vec<_>>())?;
    if shown.json {
        return print(&format!("{}\n", json(results)?));
    }
    if shown.quiet {
        return Ok(());
    }
    print(&format!("{}{}{}", results.text(&folder.join(STUDY)), shown.pace, files(&written)))
}

/// Writes files for an engine. They are all in this folder, which may be moved.
fn submitted(args: &SweepArgs, prepared: &Prepared, folder: &Path, engine: Engine, shards: u64) -> Result<u8, Failure> {
    let submission = Submission {
        engine,
        shards,
        threads: args.jobs.map_or(1, NonZeroUsize::get),
        program: std::env::current_exe().map_err(Failure::Output)?,
    };
    let written = submit::write(prepared, &submission, folder, &mut outputs(args, prepared))?;
    if !args.quiet {
        print(&files(&written))?;
    }
    Ok(0)
}

/// Does one run in full. The exit code is that of `run`.
fn replayed(
    args: &SweepArgs,
    prepared: &Prepared,
    index: u64,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<u8, Failure> {
    let bar = if args.quiet { ProgressBar::hidden() } else { progress_bar(None, "ticks") };
    let Replayed { run, files: written } = replay(prepared, index, folder, &mut outputs(args, prepared), stop, &bar)?;
    if !args.quiet {
        print(&format!("{}\n{}", run.summary.table(), files(&written)))?;
    }
    Ok(crate::run::exit_code(&run))
}
