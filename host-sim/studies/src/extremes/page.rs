//! The extremes as a page.

use super::inputs::regions;
use super::stability::{StableRegion, planar_region, puma_region};
use super::{Cell, Report, title};
use report::{Block, Figure, Page, Point, Scale, Series, Table};
use sim::failure::Failure;

impl Report {
    /// The page: what fails first, then the regions, then every cell.
    ///
    /// # Errors
    /// A shipped robot cannot be read.
    pub fn page(&self) -> Result<Page, Failure> {
        let failing = self.cells.iter().filter(|cell| !cell.passed);
        let failing: Vec<String> = failing
            .map(|cell| format!("{}, {}: {}", cell.group, cell.name, cell.reason.as_deref().unwrap_or_default()))
            .collect();
        let mut blocks = Vec::new();
        if !failing.is_empty() {
            blocks.extend([Block::Heading("What fails, and why".to_owned()), Block::List(failing)]);
        }
        blocks.push(Block::Figure(region()?));
        for (caption, found) in [("Planar 2R", planar_region()?), ("Puma 560", puma_region()?)] {
            blocks.push(Block::Figure(stable(caption, found)));
        }
        let mut groups: Vec<&str> = self.cells.iter().map(|cell| cell.group).collect();
        groups.dedup();
        blocks.extend(groups.into_iter().map(|group| Block::Table(self.of_group(group))));
        blocks.push(Block::Words("host-sim extremes repeats all cells; --json gives them with all digits.".to_owned()));
        Ok(Page { title: "extremes".to_owned(), lead: vec![format!("{}.", self.count())], blocks })
    }

    fn of_group(&self, group: &str) -> Table {
        let mut table = Table::new(title(group), &["cell", "what is done", "kind", "expected", "found", "verdict"]);
        for cell in self.cells.iter().filter(|cell| cell.group == group) {
            let Cell { name, done, kind, expected, found, value, passed, .. } = cell;
            let found = value.map_or_else(|| found.clone().into(), |value| report::Cell::number(found.clone(), value));
            let verdict = report::Cell::from(if *passed { cell.passes() } else { "FAIL" }).warning(!passed);
            table.row(vec![
                name.clone().into(),
                done.clone().into(),
                kind.name().into(),
                expected.clone().into(),
                found,
                verdict,
            ]);
        }
        table
    }
}

/// Largest rates at which the error stays small.
fn region() -> Result<Figure, Failure> {
    let figure = Figure::new(
        "Error under 1e-4 of every torque limit below the line",
        "largest joint angle / rad",
        "largest joint rate / rad/s",
    );
    let lines = regions()?.into_iter().map(|(name, points)| Series::line(name, points));
    Ok(lines.fold(figure.scaled(Scale::Log, Scale::Log), Figure::with))
}

fn stable(arm: &str, regions: Vec<StableRegion>) -> Figure {
    let caption = format!("{arm}: stable below the line (predicted), dots simulated");
    let mut figure =
        Figure::new(caption, "natural frequency / rad/s", "longest stable period / s").scaled(Scale::Log, Scale::Log);
    for (name, points) in regions {
        let dot = |&(frequency, _, simulated): &(f64, f64, f64)| {
            Point::at(frequency, simulated).named(format!("{name}: {frequency:.3} rad/s, stable to {simulated:.3e} s"))
        };
        let dots = points.iter().map(dot).collect();
        figure = figure
            .with(Series::line(name.clone(), points.iter().map(|&(frequency, predicted, _)| (frequency, predicted))));
        figure = figure.with_of_last(Series::points(format!("{name}, simulated"), dots));
    }
    figure
}
