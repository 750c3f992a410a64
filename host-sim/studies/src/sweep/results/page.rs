//! Results as an HTML page.

use super::markdown::short;
use super::{Distribution, Results};
use crate::sweep::Prepared;
use crate::sweep::repeat::repeat_command;
use report::{Block, Cell, Figure, Page, Point, Scale, Series, Table};
use std::path::Path;

impl Results {
    /// Creates the page of a prepared study, with the commands that repeat its runs.
    #[must_use]
    pub fn page(&self, prepared: &Prepared, study: &Path) -> Page {
        let mut blocks = vec![Block::Facts(self.about(prepared))];
        for titled in self.titled() {
            let mut table = Table::new(titled.title, &titled.head);
            titled.rows.into_iter().for_each(|row| table.row(row.into_iter().map(Cell::from).collect()));
            blocks.push(Block::Table(table));
        }
        blocks.extend(
            self.metrics.iter().filter(|metric| metric.finite > 0).map(|metric| Block::Figure(metric.figure())),
        );
        blocks.extend(self.influence().map(Block::Figure));
        blocks.extend(self.worst_runs(study).map(Block::Table));
        blocks.extend(self.failing_runs(study).map(Block::Table));
        Page { title: format!("study {}", self.study), lead: vec![self.sentence()], blocks }
    }

    /// Rank correlations as a bar chart; `None` if there are none.
    fn influence(&self) -> Option<Figure> {
        let names: Vec<String> = self.keys().into_iter().map(str::to_owned).collect();
        let of = |metric: &Distribution| {
            let bars = names.iter().enumerate().filter_map(|(place, key)| {
                let correlation = self.correlation(metric, key)?;
                let told = format!(
                    "{} with {key}: {:+.2} ({:+.2} to {:+.2})",
                    metric.metric, correlation.value, correlation.low, correlation.high
                );
                Some(Point::at(place as f64, correlation.value).named(told))
            });
            Series::bars(metric.metric.clone(), bars.collect())
        };
        let figure = Figure::new("Rank correlation of figures with keys", "key", "rank correlation");
        let figure = figure.scaled(Scale::Names(names.clone()), Scale::Linear);
        (!names.is_empty()).then(|| self.metrics.iter().map(of).fold(figure, Figure::with))
    }

    /// Table of the worst runs of every figure, each with its command.
    fn worst_runs(&self, study: &Path) -> Option<Table> {
        let mut table = Table::new(
            "The worst runs, and the command that repeats each in full",
            &["figure", "run", "value", "command"],
        );
        let mut any = false;
        for metric in &self.metrics {
            for worst in &metric.worst {
                let value = worst.figure.map_or_else(|| "unsettled".into(), |x| Cell::number(short(x), x));
                let command = repeat_command(study, worst.index);
                let command = Cell::from(command.clone()).told(command);
                table.row(vec![metric.label().into(), worst.index.to_string().into(), value, command]);
                any = true;
            }
        }
        any.then_some(table)
    }

    /// Table of the first runs that failed, each with its command; `None` if none did.
    fn failing_runs(&self, study: &Path) -> Option<Table> {
        let mut table =
            Table::new("The first runs that failed, and the command that repeats each in full", &["run", "command"]);
        for index in &self.failing {
            let command = repeat_command(study, *index);
            table.row(vec![index.to_string().into(), Cell::from(command.clone()).told(command)]);
        }
        (!self.failing.is_empty()).then_some(table)
    }
}

impl Distribution {
    /// Histogram of all runs.
    fn figure(&self) -> Figure {
        let histogram = &self.histogram;
        let width = (histogram.high - histogram.low) / histogram.counts.len().max(1) as f64;
        let step = |(place, count): (usize, &u64)| {
            let from = histogram.low + place as f64 * width;
            Point::at(from, *count as f64).named(format!("{} to {}: {count} runs", short(from), short(from + width)))
        };
        let mut points: Vec<Point> = histogram.counts.iter().enumerate().map(step).collect();
        points.push(Point::at(histogram.high, 0.0));
        let figure = Figure::new(format!("Runs by {}", self.metric), self.label(), "runs")
            .with(Series::steps("all runs", points));
        let most = histogram.counts.iter().max().map_or(0.0, |count| *count as f64);
        // A bound far from all runs is left out, because it would compress the histogram.
        let room = histogram.high - histogram.low;
        let near = |bound: f64| (histogram.low - room..=histogram.high + room).contains(&bound);
        let quantiles = self.quantiles.map(|all| {
            [
                all.p05.map(|at| Series::quantile(format!("5 % {}", short(at)), at, most)),
                all.p50.map(|at| Series::median(format!("median {}", short(at)), at, most)),
                all.p95.map(|at| Series::quantile(format!("95 % {}", short(at)), at, most)),
            ]
        });
        let figure = quantiles.into_iter().flatten().flatten().fold(figure, Figure::with);
        let bounds = [("fails above", self.limit), ("fails below", self.least)].into_iter();
        bounds.filter_map(|(name, bound)| Some((name, bound.filter(|bound| near(*bound))?))).fold(
            figure,
            |figure, (name, bound)| {
                figure.with(Series::limit(format!("{name} {}", short(bound)), (bound, 0.0), (bound, most)))
            },
        )
    }
}
