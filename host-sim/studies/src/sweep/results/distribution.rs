//! Distribution of a figure over the runs.

use super::RunShare;
use robot_compiler::study::Metric;
use serde::Serialize;

/// Distribution of a figure. Infinite and missing values have counts of their own. They count as failures, and are left out of mean and quantiles.
#[derive(Clone, Debug, Serialize)]
pub struct Distribution {
    /// Title of the figure.
    pub metric: String,
    /// Unit of the figure; empty if it has none.
    pub unit: String,
    /// A run with a larger figure fails.
    pub limit: Option<f64>,
    /// A run with a smaller figure fails.
    pub least: Option<f64>,
    /// Share of the runs that fail because of this figure.
    pub failures: RunShare,
    /// Number of runs with a finite figure.
    pub finite: u64,
    /// Number of runs with an infinite figure.
    pub infinite: u64,
    /// Number of runs without the figure.
    pub missing: u64,
    /// Mean; like all values below, `None` without a finite figure.
    pub mean: Option<f64>,
    /// Standard deviation.
    pub deviation: Option<f64>,
    /// Smallest value.
    pub min: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
    /// Quantiles of the sample, including infinite figures.
    pub quantiles: Option<Quantiles>,
    /// Numbers of runs in equal steps between the smallest and the largest value.
    pub histogram: Histogram,
    /// The worst runs, the worst first: the largest figures, or the smallest if only `least` is given.
    pub worst: Vec<Worst>,
}

/// Quantiles; infinite ones are `None`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Quantiles {
    /// The 1 % quantile.
    pub p01: Option<f64>,
    /// The 5 % quantile.
    pub p05: Option<f64>,
    /// The 25 % quantile.
    pub p25: Option<f64>,
    /// The median.
    pub p50: Option<f64>,
    /// The 75 % quantile.
    pub p75: Option<f64>,
    /// The 95 % quantile.
    pub p95: Option<f64>,
    /// The 99 % quantile.
    pub p99: Option<f64>,
}

/// Numbers of runs in equal steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// Lower end of the first step.
    pub low: f64,
    /// Upper end of the last step.
    pub high: f64,
    /// Number of runs in each step.
    pub counts: Vec<u64>,
}

/// One of the worst runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// Index of the run.
    pub index: u64,
    /// Figure of the run; `None` if infinite.
    pub figure: Option<f64>,
}

/// Number of steps of a histogram.
const STEPS: usize = 40;
/// Number of worst runs that are listed.
const WORST: usize = 5;

/// First pass over a figure.
#[derive(Debug)]
pub(super) struct Collector {
    metric: Metric,
    unit: String,
    failed: u64,
    finite: u64,
    infinite: u64,
    missing: u64,
    mean: f64,
    squares: f64,
    min: f64,
    max: f64,
    worst: Vec<(u64, f64)>,
}

impl Collector {
    pub(super) fn new(metric: &Metric, unit: &str) -> Self {
        Self {
            metric: metric.clone(),
            unit: unit.to_owned(),
            failed: 0,
            finite: 0,
            infinite: 0,
            missing: 0,
            mean: 0.0,
            squares: 0.0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
            worst: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, index: u64, x: f64) {
        self.failed += u64::from(!self.metric.passes(x));
        if x.is_nan() {
            self.missing += 1;
            return;
        }
        self.rank(index, x);
        if x.is_infinite() {
            self.infinite += 1;
            return;
        }
        // Welford's sums, which avoid cancellation.
        self.finite += 1;
        let from_mean = x - self.mean;
        self.mean += from_mean / self.finite as f64;
        self.squares += from_mean * (x - self.mean);
        (self.min, self.max) = (self.min.min(x), self.max.max(x));
    }

    /// Keeps the worst runs; of equal ones the first.
    fn rank(&mut self, index: u64, x: f64) {
        let low_is_bad = self.metric.limit.is_none() && self.metric.least.is_some();
        let worse = |a: f64, b: f64| if low_is_bad { a < b } else { a > b };
        let place = self.worst.iter().position(|(_, other)| worse(x, *other)).unwrap_or(self.worst.len());
        if place < WORST {
            self.worst.insert(place, (index, x));
            self.worst.truncate(WORST);
        }
    }

    pub(super) fn histogram(&self) -> Histogram {
        let counts = if self.finite > 0 { vec![0; STEPS] } else { Vec::new() };
        let (low, high) = if self.finite > 0 { (self.min, self.max) } else { (0.0, 0.0) };
        Histogram { low, high, counts }
    }

    pub(super) fn finish(self, histogram: Histogram, sample: &[f64]) -> Distribution {
        let known = |x: f64| (self.finite > 0).then_some(x);
        Distribution {
            failures: RunShare::new(self.failed, self.finite + self.infinite + self.missing),
            finite: self.finite,
            infinite: self.infinite,
            missing: self.missing,
            mean: known(self.mean),
            deviation: known(libm::sqrt(self.squares / (self.finite.max(2) - 1) as f64)),
            min: known(self.min),
            max: known(self.max),
            quantiles: quantiles(sample),
            histogram,
            worst: self.worst.iter().map(|(index, x)| Worst { index: *index, figure: finite(*x) }).collect(),
            limit: self.metric.limit,
            least: self.metric.least,
            metric: self.metric.title,
            unit: self.unit,
        }
    }
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

impl Distribution {
    /// The figure's title with its unit, for the head of a table or an axis.
    pub(super) fn label(&self) -> String {
        match self.unit.as_str() {
            "" => self.metric.clone(),
            unit if unit.contains([' ', '/']) => format!("{} / ({unit})", self.metric),
            unit => format!("{} / {unit}", self.metric),
        }
    }
}

impl Histogram {
    pub(super) fn add(&mut self, x: f64) {
        let steps = self.counts.len();
        if !x.is_finite() || steps == 0 {
            return;
        }
        let width = self.high - self.low;
        let step = if width > 0.0 { ((x - self.low) / width * steps as f64) as usize } else { 0 };
        self.counts[step.min(steps - 1)] += 1;
    }
}

fn quantiles(sample: &[f64]) -> Option<Quantiles> {
    let mut sorted: Vec<f64> = sample.iter().copied().filter(|x| !x.is_nan()).collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    // Use the nearest run, because interpolation would invent values between a finite and an infinite one.
    let at = |share: f64| finite(sorted[libm::round(share * last as f64) as usize]);
    Some(Quantiles {
        p01: at(0.01),
        p05: at(0.05),
        p25: at(0.25),
        p50: at(0.5),
        p75: at(0.75),
        p95: at(0.95),
        p99: at(0.99),
    })
}

#[cfg(test)]
mod tests {
    use super::Collector;
    use robot_compiler::study::{Figure, Metric};

    fn collector(limit: Option<f64>, least: Option<f64>) -> Collector {
        Collector::new(&Metric { figure: Figure::Drift, joint: None, limit, least, title: "drift".to_owned() }, "rad")
    }

    #[test]
    fn figures_are_counted_once_each_and_the_worst_are_kept() {
        let mut collector = collector(Some(6.5), None);
        let all: Vec<f64> = (0..10).map(f64::from).chain([f64::NAN, f64::INFINITY, 9.0]).collect();
        all.iter().enumerate().for_each(|(index, x)| collector.add(index as u64, *x));
        let mut histogram = collector.histogram();
        all.iter().for_each(|x| histogram.add(*x));
        let found = collector.finish(histogram, &all);
        assert_eq!((found.finite, found.infinite, found.missing), (11, 1, 1));
        assert_eq!(found.failures.count, 6, "7, 8, 9, NaN, infinity, 9");
        assert!((found.mean.unwrap() - 54.0 / 11.0).abs() < 1e-14);
        let squares: f64 = (0..10).map(f64::from).chain([9.0]).map(|x| (x - 54.0 / 11.0) * (x - 54.0 / 11.0)).sum();
        assert!((found.deviation.unwrap() - (squares / 10.0).sqrt()).abs() < 1e-14);
        let worst: Vec<_> = found.worst.iter().map(|worst| worst.index).collect();
        assert_eq!(worst, [11, 9, 12, 8, 7]);
        assert_eq!(found.histogram.counts.iter().sum::<u64>(), 11);
        assert_eq!((found.histogram.counts[0], found.histogram.counts[39]), (1, 2));
        let quantiles = found.quantiles.unwrap();
        assert!(quantiles.p99.is_none() && quantiles.p50 == Some(6.0), "{quantiles:?}");
    }

    #[test]
    fn a_figure_that_must_not_be_small_has_its_worst_at_the_bottom() {
        let mut collector = collector(None, Some(0.5));
        [3.0, 0.1, 2.0].into_iter().zip(0..).for_each(|(x, index)| collector.add(index, x));
        let histogram = collector.histogram();
        let found = collector.finish(histogram, &[]);
        assert_eq!((found.worst[0].index, found.failures.count), (1, 1));
        assert!(found.quantiles.is_none());
    }
}
