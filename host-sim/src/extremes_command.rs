//! `extremes`: what happens at the edges, cell by cell.

use crate::cli::ExtremesArgs;
use crate::exit::Failure;
use crate::extremes::{Report, time, write_plots};
use crate::run_command::in_file;
use std::fs;
use std::io::{self, Write};
use std::path::Path;

/// Run the cells; print them, and put them into the documentation where that is asked for.
///
/// # Errors
/// A file without the lines between which the tables go, or one that cannot be read or written.
pub fn run(args: &ExtremesArgs) -> Result<(), Failure> {
    if let Some(hours) = args.long.filter(|hours| !(*hours >= 0.01 && *hours <= 1000.0)) {
        return Err(Failure::Input(miette::miette!("--long {hours}: expected hours from 0.01 to 1000")));
    }
    // Better now than after the run.
    let document = args.write.as_deref().map(|path| Document::read(path, args.long.is_some())).transpose()?;
    let mut report = Report::new()?;
    let long = args.long.map(|hours| time::long_cells(hours).map(Report::of)).transpose()?;
    if let Some(mut document) = document {
        document.put("extremes", &report.markdown())?;
        if let Some(long) = &long {
            document.put("extremes, long", &long.markdown())?;
        }
        document.write()?;
        write_plots(document.path.parent().unwrap_or(Path::new(".")))?;
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
    match writeln!(io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::Output(error)),
        Ok(()) | Err(_) => Ok(()),
    }
}

/// A page with places for what is measured.
struct Document<'a> {
    path: &'a Path,
    text: String,
}

impl<'a> Document<'a> {
    /// The page, if it has the lines between which tables go.
    fn read(path: &'a Path, long: bool) -> Result<Self, Failure> {
        let text =
            fs::read_to_string(path).map_err(|error| Failure::Input(miette::miette!("{}: {error}", path.display())))?;
        let mut document = Self { path, text };
        document.put("extremes", "")?;
        if long {
            document.put("extremes, long", "")?;
        }
        Ok(document)
    }

    /// Replace what stands between the lines of this name.
    fn put(&mut self, name: &str, measured: &str) -> Result<(), Failure> {
        let (begin, end) = (format!("<!-- measured: {name} -->\n"), format!("<!-- end measured: {name} -->"));
        let place = self.text.find(&begin).map(|at| at + begin.len()).zip(self.text.find(&end));
        let Some((from, to)) = place.filter(|(from, to)| from <= to) else {
            return Err(Failure::Input(miette::miette!(
                "{}: expected the lines `{}` and `{end}`, between which the table goes",
                self.path.display(),
                begin.trim_end()
            )));
        };
        self.text.replace_range(from..to, &format!("\n{measured}\n"));
        Ok(())
    }

    fn write(&self) -> Result<(), Failure> {
        fs::write(self.path, &self.text).map_err(|error| in_file(self.path, &error))
    }
}
