//! `extremes`: what happens at the edges, cell by cell.

use crate::cli::force::ForceArgs;
use clap::Args;
use sim::failure::Failure;
use sim::pages;
use sim::terminal::{json, print};
use std::path::PathBuf;
use studies::extremes::{Report, time};

const EXAMPLES: &str = "\
Groups:
  masses       masses and inertias from 1e-6 to 1e6, massless links, nearly singular inertia matrices
  inputs       angles to 1e6 turns, rates to 1e4 rad/s, NaN and infinity: a right torque or the documented fault
  integrators  order and energy of the plant's integrators, over a second and over a hundred; a chaotic arm
  time         periods from 1 us to 50 ms, a million ticks, an encoder that hardly moves; with --long, a day
  control      saturation, wrong models, joints that stick
  stability    the longest stable period, predicted and simulated: a planar arm, the Puma, wrong models

A cell is a requirement (a bound from theory or use, or a documented outcome) or a record (a number that nothing requires). A requirement
passes when it holds and its number is the one measured before, to 2 %; a record when its number is; long cells have requirements only. A cell that fails says why; the suite of
tests fails when a cell's outcome changes in either direction.

Examples:
  host-sim extremes
  host-sim extremes --json | jq '.cells[] | select(.passed | not)'
  host-sim extremes --report out/extremes.html
  host-sim extremes --long
  host-sim extremes --long 1 --write
  host-sim extremes --write

--json is an object {count, passed, failed, records, cells: [{group, name, done, kind, expected, found, value, pinned, moved, passed, reason}]}.
--write puts the tables between the lines `<!-- measured: extremes -->` and `<!-- end measured: extremes -->` of the file.
Long cells have a table of their own, between the lines `<!-- measured: extremes, long -->` and `<!-- end measured: extremes, long -->`, which only --long --write changes.";

/// Options of `extremes`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct ExtremesArgs {
    /// Also run what takes minutes: a million ticks of a microsecond, and so many simulated hours at 1 kHz.
    #[arg(long, value_name = "HOURS", num_args = 0..=1, default_missing_value = "24", allow_negative_numbers = true)]
    pub long: Option<f64>,
    /// Put the tables into this file.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "docs/measured/extremes.md")]
    pub write: Option<PathBuf>,
    /// File for the report, a page for a browser.
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Run the cells; print them, and put them into the documentation where that is asked for.
///
/// # Errors
/// A file without the lines between which the tables go, or one that cannot be read or written.
pub fn run(args: &ExtremesArgs) -> Result<(), Failure> {
    if let Some(hours) = args.long.filter(|hours| !(*hours >= 0.01 && *hours <= 1000.0)) {
        return Err(Failure::Input(miette::miette!("--long {hours}: expected hours from 0.01 to 1000")));
    }
    // Better now than after the run.
    let places: &[&str] = if args.long.is_some() { &["extremes", "extremes, long"] } else { &["extremes"] };
    let page = pages::document(args.write.as_deref(), places)?;
    let mut output = args.force.output();
    args.report.as_deref().map_or(Ok(()), |path| output.file(path))?;
    let mut report = Report::new()?;
    let long = args.long.map(|hours| time::long_cells(hours).map(Report::of)).transpose()?;
    if let Some(page) = page {
        let long = long.iter().map(|long| ("extremes, long", long.markdown()));
        let tables: Vec<_> = core::iter::once(("extremes", report.markdown())).chain(long).collect();
        pages::fill(page, &tables)?;
    }
    if let Some(long) = long {
        report.cells.extend(long.cells);
        report = Report::of(report.cells);
    }
    pages::write_claimed(&output, args.report.as_deref(), || report.page())?;
    let text = if args.json { json(&report)? } else { report.table() };
    print(&format!("{text}\n"))
}
