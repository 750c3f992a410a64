//! `sweep merge`: merges the shards of a study.

use super::study::{Shown, show};
use crate::force::ForceArgs;
use clap::Args;
use indicatif::ProgressBar;
use sim::failure::Failure;
use sim::terminal::progress_bar;
use std::path::PathBuf;
use studies::sweep::results::Results;
use studies::sweep::store;

const EXAMPLE: &str = "Example:\n  newtau sweep merge out/shards --out out/whole";

const EXAMPLES: &str = "\
Every shard is checked: the same study, program and machine's numbers, every run once, the table as it was written. The merged files are
byte for byte those of one process. One shard is read at a time, so memory does not grow with their number.

Examples:
  newtau sweep merge out/shards --out out/whole
  newtau sweep merge out/shards/1 out/shards/2 --out out/whole --json | jq .failures";

/// Options of `merge`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct MergeArgs {
    /// The folders of the shards in any order, or the folder that contains them.
    #[arg(value_name = "FOLDER", required = true)]
    pub shards: Vec<PathBuf>,
    /// Folder for the merged study. It must be new or empty.
    #[arg(long, value_name = "FOLDER")]
    pub out: PathBuf,
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

/// Merges shards. Returns the exit code.
///
/// # Errors
/// Shards that are damaged or do not belong together, or a file that cannot be written.
pub fn run(args: &MergeArgs) -> Result<u8, Failure> {
    let bar = if args.json || args.quiet { ProgressBar::hidden() } else { progress_bar(None, "shards") };
    let shards = store::shards(&args.shards)?;
    bar.set_length(shards.len() as u64);
    let mut output = shards.iter().fold(args.force.output(), |output, shard| output.reads(&shard.join(store::RUNS)));
    let merged = store::merge(&shards, &args.out, &mut output, &|shards| bar.set_position(shards));
    bar.finish_and_clear();
    let (prepared, _) = merged?;
    let results = Results::of(&prepared, &args.out)?;
    show(&Shown { json: args.json, quiet: args.quiet, pace: "" }, &prepared, &results, &args.out, &output)?;
    Ok(0)
}
