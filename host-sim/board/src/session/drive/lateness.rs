//! Lateness and duration of ticks.

use hdrhistogram::Histogram;
use std::fmt;
use std::time::{Duration, Instant};

/// Longest time that is distinguished, ns: a minute.
const LONGEST_NS: u64 = 60_000_000_000;

/// Times of many ticks.
#[derive(Clone, Debug)]
pub struct Times(Histogram<u64>);

/// Quantiles of times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantiles {
    /// Median.
    pub p50: Duration,
    /// 99 of 100 are no longer.
    pub p99: Duration,
    /// 9,999 of 10,000 are no longer.
    pub p99_99: Duration,
    /// The longest.
    pub worst: Duration,
}

impl Times {
    /// No times, distinguished to 1 %.
    ///
    /// # Errors
    /// None: the bounds are constants.
    pub fn new() -> Result<Self, hdrhistogram::CreationError> {
        Histogram::new_with_bounds(1, LONGEST_NS, 2).map(Self)
    }

    /// Adds a time.
    pub fn add(&mut self, time: Duration) {
        self.0.saturating_record(u64::try_from(time.as_nanos()).unwrap_or(u64::MAX));
    }

    /// Number of times.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.0.len()
    }

    /// Quantiles.
    #[must_use]
    pub fn quantiles(&self) -> Quantiles {
        let at = |quantile| Duration::from_nanos(self.0.value_at_quantile(quantile));
        Quantiles { p50: at(0.5), p99: at(0.99), p99_99: at(0.9999), worst: Duration::from_nanos(self.0.max()) }
    }
}

impl fmt::Display for Quantiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let us = |time: Duration| time.as_secs_f64() * 1e6;
        let [p50, p99, p99_99, worst] = [self.p50, self.p99, self.p99_99, self.worst].map(us);
        write!(f, "p50 {p50:.0}, p99 {p99:.0}, p99.99 {p99_99:.0}, worst {worst:.0} us")
    }
}

/// Times of the ticks of a session.
#[derive(Clone, Debug)]
pub struct TickTimes {
    /// From the time when a tick was due to its begin.
    pub late: Times,
    /// From its begin to its end.
    pub took: Times,
    /// Both together: a tick ends in time if this is shorter than the period.
    pub ended: Times,
    /// Ticks that ended after the next one was due.
    pub overruns: u64,
}

impl TickTimes {
    /// No ticks.
    ///
    /// # Errors
    /// As [`Times::new`].
    pub fn new() -> Result<Self, hdrhistogram::CreationError> {
        Ok(Self { late: Times::new()?, took: Times::new()?, ended: Times::new()?, overruns: 0 })
    }

    /// Adds a tick that was due at `due`, began at `begun` and has ended now.
    pub(super) fn add(&mut self, due: Instant, begun: Instant, in_time: bool) {
        self.late.add(begun.saturating_duration_since(due));
        self.took.add(begun.elapsed());
        self.ended.add(due.elapsed());
        self.overruns += u64::from(!in_time);
    }
}

impl fmt::Display for TickTimes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { late, took, ended: _, overruns } = self;
        write!(
            f,
            "{} ticks; late: {}; took: {}; {overruns} ended too late",
            late.count(),
            late.quantiles(),
            took.quantiles()
        )
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

    use super::{LONGEST_NS, Times};
    use std::time::Duration;

    #[test]
    fn quantiles_are_right_to_one_percent_and_the_worst_is_the_worst() {
        let mut times = Times::new().unwrap();
        for us in 1..=100_000 {
            times.add(Duration::from_micros(us));
        }
        times.add(Duration::from_nanos(2 * LONGEST_NS));
        let found = times.quantiles();
        let near = |time: Duration, us: f64| (time.as_secs_f64() * 1e6 / us - 1.0).abs() < 0.011;
        assert!(near(found.p50, 50_000.0) && near(found.p99, 99_000.0) && near(found.p99_99, 99_990.0), "{found:?}");
        assert!(found.worst >= Duration::from_nanos(LONGEST_NS), "{found:?}");
        assert_eq!(times.count(), 100_001);
    }
}
