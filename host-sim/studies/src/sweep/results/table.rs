//! The table of runs, read row by row, and a sample of it.

use super::RunShare;
use super::rank::{Sensitivity, correlation};
use crate::sweep::Prepared;
use crate::sweep::experiment::COMPLETE;
use csv::ByteRecord;
use robot_compiler::study::Vary;
use serde::Serialize;
use sim::failure::Failure;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Runs grouped by the values of one key or of two.
#[derive(Clone, Debug, Serialize)]
pub struct Group {
    /// The keys.
    pub keys: Vec<String>,
    /// One cell for each combination of values.
    pub cells: Vec<GroupCell>,
}

/// Runs with certain values.
#[derive(Clone, Debug, Serialize)]
pub struct GroupCell {
    /// The values.
    pub values: Vec<String>,
    /// Share of the runs that failed.
    pub failures: RunShare,
    /// Median of each figure over the complete runs in the sample; `None` if there are none.
    pub medians: Vec<Option<f64>>,
}

/// The columns of a table.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    all: Vec<String>,
    keys: Vec<Column>,
    metrics: Vec<String>,
}

/// The column of a key.
#[derive(Clone, Debug)]
struct Column {
    name: String,
    /// True if all its values are numbers.
    numbers: bool,
    /// True if it has few values, regardless of the number of runs.
    few: bool,
}

impl Columns {
    pub(super) fn new(prepared: &Prepared) -> Self {
        let experiment = &prepared.study.experiment;
        let keys = experiment.vary.iter().map(Column::of).collect();
        let metrics = experiment.metrics.iter().map(|metric| metric.title.clone()).collect();
        Self { all: prepared.columns(), keys, metrics }
    }
}

impl Column {
    fn of(vary: &Vary) -> Self {
        // A range has a number of steps only in a grid.
        let values = vary.values.countable().unwrap_or(vary.steps);
        let few = (1..=VALUES_MAX as u64).contains(&values);
        Self { name: vary.key.name.clone(), numbers: vary.values.are_numbers(), few }
    }
}

/// A table of runs.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) path: PathBuf,
    pub(super) columns: Columns,
}

/// A row of the table.
pub(super) struct SweepRow<'a> {
    pub(super) index: u64,
    pub(super) keys: Vec<&'a str>,
    pub(super) figures: Vec<f64>,
    pub(super) end: &'a str,
    pub(super) pass: bool,
}

impl Table {
    /// Passes every row to `hand_on`.
    ///
    /// # Errors
    /// [`Failure::Input`] if the table cannot be read or has other columns.
    pub(super) fn each_row(&self, mut hand_on: impl FnMut(SweepRow<'_>)) -> Result<(), Failure> {
        let wrong = |problem: String| Failure::Input(miette::miette!("{}: {problem}", self.path.display()));
        let mut reader = csv::ReaderBuilder::new()
            .buffer_capacity(1 << 20)
            .from_path(&self.path)
            .map_err(|error| wrong(error.to_string()))?;
        let head = reader.byte_headers().map_err(|error| wrong(error.to_string()))?;
        if !head.iter().eq(self.columns.all.iter().map(String::as_bytes)) {
            return Err(wrong("has other columns than the study".to_owned()));
        }
        let mut record = ByteRecord::new();
        let mut line = 1_u64;
        while reader.read_byte_record(&mut record).map_err(|error| wrong(error.to_string()))? {
            line += 1;
            let row = self.row(&record).ok_or_else(|| wrong(format!("line {line} is no run of the study")))?;
            hand_on(row);
        }
        Ok(())
    }

    fn row<'a>(&self, record: &'a ByteRecord) -> Option<SweepRow<'a>> {
        let text = |place: usize| core::str::from_utf8(record.get(place)?).ok();
        let (keys, metrics) = (self.columns.keys.len(), self.columns.metrics.len());
        // An empty figure belongs to a refused run.
        let figure = |place: usize| {
            let text = text(place)?;
            if text.is_empty() { Some(f64::NAN) } else { text.parse().ok() }
        };
        Some(SweepRow {
            index: text(0)?.parse().ok()?,
            keys: (1..=keys).map(text).collect::<Option<_>>()?,
            figures: (1 + keys..1 + keys + metrics).map(figure).collect::<Option<_>>()?,
            end: text(record.len().checked_sub(2)?)?,
            pass: text(record.len() - 1)? == "1",
        })
    }
}

/// Largest number of runs in a sample.
const SAMPLE_MAX: u64 = 100_000;
/// Largest number of values of a key by which runs are grouped.
const VALUES_MAX: usize = 32;
/// Largest number of combinations of two keys by which runs are grouped.
const PAIRS_MAX: usize = 400;

/// Figures of the runs with an index that is a multiple of the stride, and counts of all runs by the values of keys.
#[derive(Debug)]
pub(super) struct RowSample {
    pub(super) stride: u64,
    /// One list for each key with numbers, then for each figure.
    numbers: Vec<Vec<f64>>,
    /// Indices, among all keys, of the keys with numbers.
    keys: Vec<usize>,
    groups: Vec<Counts>,
}

/// Counts of runs by the values of one key or of two.
#[derive(Debug)]
struct Counts {
    keys: Vec<usize>,
    /// Largest number of combinations; with more, none are kept.
    most: usize,
    /// Number of runs, number of failures, and indices of complete runs in the sample.
    cells: BTreeMap<Vec<String>, (u64, u64, Vec<usize>)>,
    too_many: bool,
}

impl RowSample {
    pub(super) fn new(runs: u64, columns: &Columns) -> Self {
        let keys: Vec<usize> = (0..columns.keys.len()).filter(|place| columns.keys[*place].numbers).collect();
        let few: Vec<usize> = (0..columns.keys.len()).filter(|place| columns.keys[*place].few).collect();
        let one = few.iter().map(|key| Counts::new(vec![*key], VALUES_MAX));
        let pairs = few.iter().enumerate().flat_map(|(at, a)| few[at + 1..].iter().map(move |b| vec![*a, *b]));
        let two = pairs.map(|pair| Counts::new(pair, PAIRS_MAX));
        Self {
            stride: runs.div_ceil(SAMPLE_MAX).max(1),
            numbers: vec![Vec::new(); keys.len() + columns.metrics.len()],
            keys,
            groups: one.chain(two.take(16)).collect(),
        }
    }

    pub(super) fn runs(&self) -> usize {
        self.numbers.first().map_or(0, Vec::len)
    }

    pub(super) fn add(&mut self, row: &SweepRow<'_>) {
        let chosen = row.index.is_multiple_of(self.stride);
        let place = chosen.then_some(self.runs());
        // A run that stopped at a fault had less time to accumulate error, so it is left out.
        let whole = place.filter(|_| row.end == COMPLETE);
        self.groups.iter_mut().for_each(|group| group.add(row, whole));
        if chosen {
            let keys = self.keys.iter().map(|key| row.keys[*key].parse().unwrap_or(f64::NAN));
            let all = keys.chain(row.figures.iter().copied());
            self.numbers.iter_mut().zip(all).for_each(|(list, x)| list.push(x));
        }
    }

    /// Values of a figure in the sample.
    pub(super) fn figure(&self, place: usize) -> &[f64] {
        self.numbers.get(self.keys.len() + place).map_or(&[], Vec::as_slice)
    }

    /// Rank correlation of each figure with each key with numbers. NaN values are ignored.
    pub(super) fn sensitivities(&self, columns: &Columns) -> Vec<Sensitivity> {
        let metrics = columns.metrics.iter().enumerate();
        metrics
            .flat_map(|(place, metric)| {
                self.keys.iter().zip(&self.numbers).map(move |(key, xs)| {
                    let pairs = xs.iter().copied().zip(self.figure(place).iter().copied());
                    let pairs: Vec<_> = pairs.filter(|(x, y)| !x.is_nan() && !y.is_nan()).collect();
                    let key = columns.keys[*key].name.clone();
                    Sensitivity { metric: metric.clone(), key, correlation: correlation(&pairs) }
                })
            })
            .collect()
    }

    /// Runs grouped by the values of keys that have few.
    pub(super) fn groups(&self, columns: &Columns) -> Vec<Group> {
        let few = self.groups.iter().filter(|group| !group.too_many && group.cells.len() > 1);
        few.map(|group| Group {
            keys: group.keys.iter().map(|key| columns.keys[*key].name.clone()).collect(),
            cells: group.cells(self),
        })
        .collect()
    }
}

impl Counts {
    fn new(keys: Vec<usize>, most: usize) -> Self {
        Self { keys, most, cells: BTreeMap::new(), too_many: false }
    }

    fn add(&mut self, row: &SweepRow<'_>, place: Option<usize>) {
        if self.too_many {
            return;
        }
        let values: Vec<String> = self.keys.iter().map(|key| row.keys[*key].to_owned()).collect();
        let cell = self.cells.entry(values).or_default();
        cell.0 += 1;
        cell.1 += u64::from(!row.pass);
        cell.2.extend(place);
        if self.cells.len() > self.most {
            self.too_many = true;
            self.cells.clear();
        }
    }

    /// The cells; numbers are sorted by value.
    fn cells(&self, sample: &RowSample) -> Vec<GroupCell> {
        let mut cells: Vec<_> = self.cells.iter().collect();
        let number = |text: &String| text.parse::<f64>().unwrap_or(f64::INFINITY);
        cells.sort_by(|a, b| {
            let pairs = a.0.iter().zip(b.0);
            pairs.map(|(a, b)| number(a).total_cmp(&number(b))).find(|order| order.is_ne()).unwrap_or(a.0.cmp(b.0))
        });
        let metrics = sample.numbers.len() - sample.keys.len();
        cells
            .into_iter()
            .map(|(values, (runs, failures, places))| GroupCell {
                values: values.clone(),
                failures: RunShare::new(*failures, *runs),
                medians: (0..metrics)
                    .map(|metric| median(places.iter().map(|at| sample.figure(metric)[*at])))
                    .collect(),
            })
            .collect()
    }
}

/// Median of the numbers that are not NaN.
fn median(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = numbers.filter(|x| !x.is_nan()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().filter(|x| x.is_finite())
}
