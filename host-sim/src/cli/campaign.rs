//! `campaign`: every fault in every state, each tick judged.

use crate::cli::document::Document;
use crate::cli::progress::progress_bar;
use crate::cli::{CampaignArgs, Target};
use crate::failure::{self, Failure};
use crate::study::campaign::{Campaign, Report};
use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use std::sync::atomic::AtomicBool;

/// Most runs: their outcomes are kept until the end.
const RUNS_MAX: u64 = 10_000_000;

/// Run the campaign; print the table, and put it into the documentation where that is asked for. Returns the exit code.
///
/// # Errors
/// Options or scenes that are wrong, a chip that is of no use, a file that cannot be written.
pub fn run(args: &CampaignArgs, stop: &AtomicBool) -> Result<u8, Failure> {
    if !(1..=RUNS_MAX).contains(&args.runs) {
        return Err(Failure::Input(miette::miette!("--runs {}: expected 1 to {RUNS_MAX}", args.runs)));
    }
    let scenes =
        args.scenes.iter().map(|path| SceneFile::load(path).map_err(Failure::input)).collect::<Result<_, _>>()?;
    let place = match args.target {
        Target::Desk => "campaign, desk",
        Target::Qemu => "campaign, qemu",
    };
    // Better now than after the runs.
    let document = args.write.as_deref().map(|path| Document::read(path, &[place])).transpose()?;
    let campaign = Campaign {
        scenes,
        seed: args.seed,
        runs: args.run.map_or_else(|| (0..args.runs).collect(), |run| vec![run]),
        on_chip: args.target == Target::Qemu,
    };
    let progress = if args.json { ProgressBar::hidden() } else { progress_bar(None, "runs") };
    let report = campaign.report(stop, &progress)?;
    if let Some(mut document) = document {
        document.put(place, &report.markdown())?;
        document.write()?;
    }
    let text = if args.json {
        serde_json::to_string_pretty(&report).map_err(|error| Failure::Output(error.into()))?
    } else {
        report.table()
    };
    failure::print(&format!("{text}\n"))?;
    Ok(code(&report))
}

/// An unsafe command is worse than a difference.
fn code(report: &Report) -> u8 {
    match report.counterexamples.iter().map(|found| found.law.is_some()).max() {
        None => 0,
        Some(true) => failure::FAULT,
        Some(false) => failure::PARITY,
    }
}
