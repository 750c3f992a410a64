//! `report`: compares two runs on one page.

use crate::force::ForceArgs;
use crate::output::files;
use clap::Args;
use sim::failure::Failure;
use sim::pages;
use sim::terminal::print;
use std::path::PathBuf;
use studies::compare::{Side, page};

const EXAMPLE: &str = "Example:\n  newtau report out/puma560_pick out/pd";

const EXAMPLES: &str = "\
Both arms stand on one stage, the second as a ghost; curves lie over each other on one time axis; tables hold both summaries and
how they differ. All of it comes from the reports of the two runs.

Examples:
  newtau run scenes/puma560_pick.toml
  newtau run scenes/puma560_pick.toml --law pd --out out/pd
  newtau report out/puma560_pick out/pd
  newtau report out/puma560_pick out/pd --report pd.html";

/// Options of `report`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct ReportArgs {
    /// Folder of the first run, or its report.html.
    pub a: PathBuf,
    /// Folder of the second run, or its report.html.
    pub b: PathBuf,
    /// File for the page.
    #[arg(long, value_name = "FILE", default_value = "out/compare.html")]
    pub report: PathBuf,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
}

/// Writes the page of two runs.
///
/// # Errors
/// [`Failure::Input`] for an input that is not the report of a run, or for arms with different joints; [`Failure::Output`] for a file that cannot be
/// written.
pub fn run(args: &ReportArgs) -> Result<(), Failure> {
    let page = page(&Side::load(&args.a)?, &Side::load(&args.b)?)?;
    let sides = [&args.a, &args.b].map(|side| if side.is_dir() { side.join("report.html") } else { side.clone() });
    let mut output = sides.iter().fold(args.force.output(), |output, side| output.reads(side));
    output.file(&args.report)?;
    pages::write_claimed(&output, Some(&args.report), || Ok(page.clone()))?;
    let said: String = page.lead.iter().map(|line| format!("{line}\n")).collect();
    print(&format!("{said}{}", files(std::slice::from_ref(&args.report))))
}
