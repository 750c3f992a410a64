//! `extremes`: what happens at the edges, cell by cell.

use crate::cli::ExtremesArgs;
use crate::cli::document::Document;
use crate::failure::{self, Failure};
use crate::study::extremes::{Report, time, write_plots};

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
    let document = args.write.as_deref().map(|path| Document::read(path, places)).transpose()?;
    let mut report = Report::new()?;
    let long = args.long.map(|hours| time::long_cells(hours).map(Report::of)).transpose()?;
    if let Some(mut document) = document {
        document.put("extremes", &report.markdown())?;
        if let Some(long) = &long {
            document.put("extremes, long", &long.markdown())?;
        }
        document.write()?;
        write_plots(document.folder())?;
    }
    if let Some(long) = long {
        report.cells.extend(long.cells);
        report = Report::of(report.cells);
    }
    let text = if args.json {
        serde_json::to_string_pretty(&report).map_err(|error| Failure::Output(error.into()))?
    } else {
        report.table()
    };
    failure::print(&format!("{text}\n"))
}
