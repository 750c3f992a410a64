//! What came of a study's runs, computed from its table in two passes.
//!
//! Memory does not grow with the number of runs. Counts, means, extremes, histograms and the worst runs are of all runs. Quantiles,
//! medians and rank correlations are of a sample: every run whose index is a multiple of the stride, at most 100,000.

mod distribution;
mod interval;
mod markdown;
mod page;
mod rank;
mod table;

pub use distribution::{Distribution, Histogram, Quantiles, Worst};
pub use interval::Share;
pub use rank::Correlation;

use super::prepared::VERSION;
use super::store::RUNS;
use super::{Prepared, experiment, store};
use crate::failure::{Failure, in_file};
use distribution::Collector;
use robot_compiler::study::{Experiment, Subject};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use table::{Columns, Sample, Table};

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
    /// Number of runs whose values make no possible scene; they count nowhere below.
    pub refused: u64,
    /// Share of the runs that failed: beyond a limit, in a fault, diverged, or with an unsafe command.
    pub failures: Share,
    /// Number of runs for each way to end.
    pub ends: BTreeMap<String, u64>,
    /// The first runs that failed.
    pub failing: Vec<u64>,
    /// Distribution of each figure.
    pub metrics: Vec<Distribution>,
    /// Rank correlation of each figure with each key that has numbers.
    pub sensitivities: Vec<Sensitivity>,
    /// Runs by the values of one key or of two, where they are few.
    pub groups: Vec<Group>,
    /// Runs of the sample.
    pub sample: SampleSize,
}

/// Rank correlation of a figure with a key.
#[derive(Clone, Debug, Serialize)]
pub struct Sensitivity {
    /// The figure.
    pub metric: String,
    /// The key.
    pub key: String,
    /// The correlation; `None` where figure or key has one value only.
    pub correlation: Option<Correlation>,
}

/// Runs by the values of one key or two.
#[derive(Clone, Debug, Serialize)]
pub struct Group {
    /// The keys.
    pub keys: Vec<String>,
    /// Each combination of values.
    pub cells: Vec<GroupCell>,
}

/// Runs with certain values.
#[derive(Clone, Debug, Serialize)]
pub struct GroupCell {
    /// The values.
    pub values: Vec<String>,
    /// Share of the runs that failed.
    pub failures: Share,
    /// Median of each figure in the sample; `None` where it holds none.
    pub medians: Vec<Option<f64>>,
}

/// Which runs a sample holds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SampleSize {
    /// Number of runs.
    pub runs: u64,
    /// From one index to the next.
    pub stride: u64,
}

/// Failing runs that are named.
const FAILING: usize = 10;

impl Results {
    /// Reads the table of a complete study.
    ///
    /// # Errors
    /// [`Failure::Input`]: the table cannot be read or is not that of the study.
    pub fn of(prepared: &Prepared, folder: &Path) -> Result<Self, Failure> {
        let table = Table { path: folder.join(RUNS), columns: Columns::new(prepared) };
        let mut results = Self {
            study: prepared.study.name.clone(),
            version: VERSION,
            identity: prepared.identity.clone(),
            runs: 0,
            refused: 0,
            failures: Share::new(0, 0),
            ends: BTreeMap::new(),
            failing: Vec::new(),
            metrics: Vec::new(),
            sensitivities: Vec::new(),
            groups: Vec::new(),
            sample: SampleSize { runs: 0, stride: 1 },
        };
        let metrics = match &prepared.study.subject {
            Subject::Scene(Experiment { metrics, .. }) => metrics.as_slice(),
            Subject::Campaign(_) => &[],
        };
        let mut collectors: Vec<Collector> = metrics.iter().map(Collector::new).collect();
        let mut sample = Sample::new(prepared.count, &table.columns);
        let mut failed = 0;
        table.each_row(|row| {
            results.runs += 1;
            *results.ends.entry(row.end.to_owned()).or_insert(0) += 1;
            if row.end == experiment::REFUSED {
                results.refused += 1;
                return;
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
        results.failures = Share::new(failed, results.runs - results.refused);
        let mut histograms: Vec<Histogram> = collectors.iter().map(Collector::histogram).collect();
        table.each_row(|row| {
            histograms.iter_mut().zip(&row.figures).for_each(|(histogram, x)| histogram.add(*x));
        })?;
        results.sample = SampleSize { runs: sample.runs() as u64, stride: sample.stride() };
        results.sensitivities = sample.sensitivities(&table.columns);
        results.groups = sample.groups(&table.columns);
        let finished = collectors.into_iter().zip(histograms).enumerate();
        results.metrics =
            finished.map(|(place, (collector, histogram))| collector.finish(histogram, sample.figure(place))).collect();
        Ok(results)
    }

    /// Writes `results.json`, `results.md` and `report.html` beside the table; `study` as for [`Results::page`].
    ///
    /// # Errors
    /// [`Failure::Output`].
    pub fn write(&self, folder: &Path, study: Option<&Path>) -> Result<Vec<PathBuf>, Failure> {
        let json = serde_json::to_string_pretty(self).map_err(|error| Failure::Output(error.into()))?;
        let page = self.page(study).html();
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
