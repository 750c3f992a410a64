//! A log: columns of a text file, and what is wrong with them.

mod check;
mod clock;
mod decode;
mod factor;
mod fields;
mod foreign;
mod grid;
mod header;
mod name;
mod read;
mod sets;
mod spec;
mod time_column;
mod unit;
mod vocabulary;

pub use spec::ColumnNames;

use crate::Series;
use std::fmt;

/// Options for reading a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Names of the joints, base first: a column may bear a number from 1 or a name.
    pub joints: Vec<String>,
    /// True if each joint turns.
    pub turns: Vec<bool>,
    /// Position limits, rad or m; infinite where there is none.
    pub limits: Vec<(f64, f64)>,
    /// Torque limits, N m or N; infinite where there is none.
    pub torque: Vec<f64>,
    /// Angles in the file are in degrees.
    pub degrees: bool,
    /// Torque per ampere of each joint, N m/A, for columns of currents.
    pub per_ampere: Option<Vec<f64>>,
    /// Ticks a second, where time is counted in ticks.
    pub tick_rate: Option<f64>,
    /// A joint that never moves is no reason to refuse the log.
    pub may_rest: bool,
    /// The torque per ampere was given for this log: currents are meant, even if torques are there.
    pub currents_meant: bool,
    /// Columns named by hand.
    pub columns: Option<ColumnNames>,
}

/// Measured motion and torque.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Where it was read.
    pub file: String,
    /// s; rises, not always evenly.
    pub time: Vec<f64>,
    /// Position of each joint, rad or m.
    pub q: Series,
    /// Measured velocity of each joint, rad/s or m/s, where the file has it.
    pub qd: Option<Series>,
    /// Torque of each joint, N m or N.
    pub tau: Series,
    /// The torques are currents times a torque per ampere.
    pub from_current: bool,
}

impl Log {
    /// Median rate, samples a second.
    #[must_use]
    pub fn rate(&self) -> f64 {
        let mut steps: Vec<f64> = self.time.windows(2).map(|t| t[1] - t[0]).collect();
        steps.sort_by(f64::total_cmp);
        // Uneven clocks alternate between ticks: the mean of the middle half is steadier than the median.
        let (lo, hi) = (steps.len() / 4, (3 * steps.len() / 4).max(1));
        let middle = steps.get(lo..hi.max(lo + 1)).unwrap_or(&steps);
        middle.len() as f64 / middle.iter().sum::<f64>()
    }

    /// Length, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.time.last().unwrap_or(&0.0) - self.time.first().unwrap_or(&0.0)
    }

    /// True if both hold the same samples.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        (&self.time, &self.q, &self.tau) == (&other.time, &other.q, &other.tau)
    }
}

/// Why a log is of no use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadLog {
    /// The file.
    pub file: String,
    /// Line and column.
    pub place: String,
    /// Found content.
    pub found: String,
    /// Expected content.
    pub expected: String,
}

impl fmt::Display for BadLog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: found {}", self.file, self.place, self.found)
    }
}

impl std::error::Error for BadLog {}
