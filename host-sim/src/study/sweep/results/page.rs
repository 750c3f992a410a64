//! Results as a page.

use super::markdown::short;
use super::{Distribution, Results};
use crate::run::files::shell_word;
use report::{Block, Cell, Figure, Page, Point, Scale, Series, Table};
use std::path::Path;

impl Results {
    /// The page; `study` is the file that a command for one run names, if one can be run alone.
    #[must_use]
    pub fn page(&self, study: Option<&Path>) -> Page {
        let study = study.map(shell_word);
        let command = |index: u64| {
            study.as_ref().map(|study| format!("host-sim sweep {study} --replay {index} --out out/run_{index}"))
        };
        let mut blocks = Vec::new();
        for titled in self.titled() {
            let head: Vec<&str> = titled.head.iter().map(String::as_str).collect();
            let mut table = Table::new(titled.title, &head);
            titled.rows.into_iter().for_each(|row| table.row(row.into_iter().map(Cell::from).collect()));
            blocks.push(Block::Table(table));
        }
        blocks.extend(
            self.metrics.iter().filter(|metric| metric.finite > 0).map(|metric| Block::Figure(metric.figure())),
        );
        blocks.extend(self.influence().map(Block::Figure));
        if let Some(table) = self.worst_runs(&command) {
            blocks.push(Block::Table(table));
        }
        if let Some(first) = self.failing.first().and_then(|index| command(*index)) {
            blocks.push(Block::Words("The first run that failed, in full:".to_owned()));
            blocks.push(Block::Terminal(first));
        }
        Page { title: format!("study {}", self.study), lead: vec![self.sentence()], blocks }
    }

    /// Rank correlations as bars; `None` where there are none.
    fn influence(&self) -> Option<Figure> {
        let mut names: Vec<String> = Vec::new();
        for found in &self.sensitivities {
            if !names.contains(&found.key) {
                names.push(found.key.clone());
            }
        }
        let of = |metric: &Distribution| {
            let bars = names.iter().enumerate().filter_map(|(place, key)| {
                let found = self.sensitivities.iter().find(|it| it.metric == metric.metric && it.key == *key)?;
                let correlation = found.correlation?;
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

    /// The worst runs of every figure, each with its command.
    fn worst_runs(&self, command: &impl Fn(u64) -> Option<String>) -> Option<Table> {
        let mut table = Table::new(
            "The worst runs, and the command that repeats each in full",
            &["figure", "run", "value", "command"],
        );
        let mut any = false;
        for metric in &self.metrics {
            for worst in &metric.worst {
                let value = worst.figure.map_or_else(|| "never".into(), |x| Cell::number(short(x), x));
                let command = command(worst.index).unwrap_or_default();
                table.row(vec![metric.metric.clone().into(), worst.index.to_string().into(), value, command.into()]);
                any = true;
            }
        }
        any.then_some(table)
    }
}

impl Distribution {
    /// The histogram of all runs.
    fn figure(&self) -> Figure {
        let histogram = &self.histogram;
        let width = (histogram.high - histogram.low) / histogram.counts.len().max(1) as f64;
        let step = |(place, count): (usize, &u64)| {
            let from = histogram.low + place as f64 * width;
            Point::at(from, *count as f64).named(format!("{} to {}: {count} runs", short(from), short(from + width)))
        };
        let mut points: Vec<Point> = histogram.counts.iter().enumerate().map(step).collect();
        points.push(Point::at(histogram.high, 0.0));
        Figure::new(format!("Runs by {}", self.metric), self.metric.clone(), "runs")
            .with(Series::steps("all runs", points))
    }
}
