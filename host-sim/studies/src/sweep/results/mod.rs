//! Results of a study's runs, computed from its table in two passes.
//!
//! Memory does not grow with the number of runs. Counts, means, extremes, histograms and the worst runs cover all runs. Quantiles, medians and rank
//! correlations come from a sample of at most 100,000 runs: those with an index that is a multiple of the stride.

mod about;
mod distribution;
mod groups;
mod interval;
mod markdown;
mod page;
mod rank;
mod table;

pub use distribution::{Distribution, Histogram, Quantiles, Worst};
pub use interval::RunShare;
pub use rank::{Correlation, Sensitivity};
pub use table::{Group, GroupCell};

use super::prepared::VERSION;
use super::store::{RUNS, STUDY};
use super::{Prepared, experiment, store};
use distribution::Collector;
use serde::Serialize;
use sim::failure::{Failure, in_file};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use table::{Columns, RowSample, Table};

/// Files with the results of a study.
pub const FILES: &[&str] = &["results.json", "results.md", "report.html"];

/// Results of a study.
#[derive(Clone, Debug, Serialize)]
pub struct Results {
    /// The study's name.
    pub study: String,
    /// Version of the program.
    pub version: &'static str,
    /// Hash of the study's files and of the program's version.
    pub identity: String,
    /// Number of runs.
    pub runs: u64,
    /// Number of runs with values that make no valid scene; they are not counted below.
    pub refused: u64,
    /// Share of the runs that failed: beyond a limit, ended in a fault, diverged, or with an unsafe command.
    pub failures: RunShare,
    /// The first refused run.
    pub refusal: Option<Refusal>,
    /// Number of runs for each kind of ending.
    pub ends: BTreeMap<String, u64>,
    /// Indices of the first runs that failed.
    pub failing: Vec<u64>,
    /// Runs that ended in a fault or diverged.
    pub broken_off: BrokenOff,
    /// Distribution of each figure.
    pub metrics: Vec<Distribution>,
    /// Rank correlation of each figure with each key that has numbers.
    pub sensitivities: Vec<Sensitivity>,
    /// Runs grouped by the values of one key or of two, if there are few values.
    pub groups: Vec<Group>,
    /// Size of the sample.
    pub sample: SampleSize,
}

/// A run with values that make no valid scene.
#[derive(Clone, Debug, Serialize)]
pub struct Refusal {
    /// Index of the run.
    pub index: u64,
    /// Error of its scene; `None` if the scene can be read but cannot be run.
    pub reason: Option<String>,
}

/// Runs that are not complete.
#[derive(Clone, Debug, Serialize)]
pub struct BrokenOff {
    /// Share of these runs.
    pub share: RunShare,
    /// Indices of the first of these runs.
    pub first: Vec<u64>,
}

/// Selection of the runs in a sample.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SampleSize {
    /// Number of runs.
    pub runs: u64,
    /// Difference between consecutive indices.
    pub stride: u64,
}

/// Number of failing runs that are listed.
const FAILING: usize = 10;
/// Number of incomplete runs that are listed, equal to that of a figure's worst runs.
const BROKEN_OFF: usize = 5;

impl Results {
    /// Computes the results from the table of a complete study.
    ///
    /// # Errors
    /// [`Failure::Input`]: the table cannot be read, or does not belong to the study.
    pub fn of(prepared: &Prepared, folder: &Path) -> Result<Self, Failure> {
        let table = Table { path: folder.join(RUNS), columns: Columns::new(prepared) };
        let mut results = Self {
            study: prepared.study.name.clone(),
            version: VERSION,
            identity: prepared.identity.clone(),
            runs: 0,
            refused: 0,
            refusal: None,
            failures: RunShare::new(0, 0),
            ends: BTreeMap::new(),
            failing: Vec::new(),
            broken_off: BrokenOff { share: RunShare::new(0, 0), first: Vec::new() },
            metrics: Vec::new(),
            sensitivities: Vec::new(),
            groups: Vec::new(),
            sample: SampleSize { runs: 0, stride: 1 },
        };
        let metrics = &prepared.study.experiment.metrics;
        let units = &prepared.runs.units;
        let mut collectors: Vec<Collector> =
            metrics.iter().zip(units).map(|(metric, unit)| Collector::new(metric, unit)).collect();
        let mut sample = RowSample::new(prepared.count, &table.columns);
        let (mut failed, mut broken_off) = (0, 0);
        table.each_row(|row| {
            results.runs += 1;
            *results.ends.entry(row.end.to_owned()).or_insert(0) += 1;
            if row.end == experiment::REFUSED {
                results.refused += 1;
                results.refusal.get_or_insert(Refusal { index: row.index, reason: None });
                return;
            }
            if row.end != experiment::COMPLETE {
                broken_off += 1;
                if results.broken_off.first.len() < BROKEN_OFF {
                    results.broken_off.first.push(row.index);
                }
            }
            if !row.pass {
                failed += 1;
                if results.failing.len() < FAILING {
                    results.failing.push(row.index);
                }
            }
            collectors.iter_mut().zip(&row.figures).for_each(|(collector, x)| collector.add(row.index, *x));
            sample.add(&row);
        })?;
        let counted = results.runs - results.refused;
        results.failures = RunShare::new(failed, counted);
        results.broken_off.share = RunShare::new(broken_off, counted);
        if let Some(refusal) = &mut results.refusal {
            refusal.reason = prepared.runs.refusal(refusal.index);
        }
        let mut histograms: Vec<Histogram> = collectors.iter().map(Collector::histogram).collect();
        table.each_row(|row| {
            histograms.iter_mut().zip(&row.figures).for_each(|(histogram, x)| histogram.add(*x));
        })?;
        results.sample = SampleSize { runs: sample.runs() as u64, stride: sample.stride };
        results.sensitivities = sample.sensitivities(&table.columns);
        results.groups = sample.groups(&table.columns);
        let finished = collectors.into_iter().zip(histograms).enumerate();
        results.metrics =
            finished.map(|(place, (collector, histogram))| collector.finish(histogram, sample.figure(place))).collect();
        Ok(results)
    }

    /// Writes `results.json`, `results.md` and `report.html` into the folder of the table.
    ///
    /// # Errors
    /// [`Failure::Output`] if a file cannot be written.
    pub fn write(&self, folder: &Path, prepared: &Prepared) -> Result<Vec<PathBuf>, Failure> {
        let json = serde_json::to_string_pretty(self).map_err(|error| Failure::Output(error.into()))?;
        let page = self.page(prepared, &folder.join(STUDY)).html();
        let texts = [("results.json", json + "\n"), ("results.md", self.markdown()), ("report.html", page)];
        let mut files = vec![folder.join(RUNS), folder.join(store::MANIFEST)];
        for (name, text) in texts {
            let path = folder.join(name);
            fs::write(&path, text).map_err(|error| in_file(&path, &error))?;
            files.push(path);
        }
        Ok(files)
    }
}
