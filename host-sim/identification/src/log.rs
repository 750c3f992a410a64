//! A measured log, and the reader that checks it.

mod check;
mod clock;
mod decode;
mod factor;
mod fields;
mod foreign;
mod grid;
mod header;
mod heading_words;
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
    /// Names of the joints, base first. A column's name may contain a joint's name, or its number.
    pub joints: Vec<String>,
    /// True for each revolute joint.
    pub turns: Vec<bool>,
    /// Position limits, rad or m; infinite where there is none.
    pub limits: Vec<(f64, f64)>,
    /// Torque limits, N m or N; infinite where there is none.
    pub torque: Vec<f64>,
    /// Angles in the file are in degrees.
    pub degrees: bool,
    /// Torque per ampere of each joint, N m/A (N/A for slides), to convert columns of currents.
    pub per_ampere: Option<Vec<f64>>,
    /// Ticks per second, if time is counted in ticks.
    pub tick_rate: Option<f64>,
    /// Accept a log in which a joint never moves.
    pub may_rest: bool,
    /// The torque per ampere was given for this log: read the currents even if torque columns exist.
    pub currents_meant: bool,
    /// Columns that the user has named.
    pub columns: Option<ColumnNames>,
}

/// Measured motion and torque.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Name of the file it was read from.
    pub file: String,
    /// Time of each sample, s; strictly rising, not always evenly spaced.
    pub time: Vec<f64>,
    /// Position of each joint, rad or m.
    pub q: Series,
    /// Measured velocity of each joint, rad/s or m/s, if the file has it.
    pub qd: Option<Series>,
    /// Torque of each joint, N m or N.
    pub tau: Series,
    /// True if the torques are currents times a torque per ampere.
    pub from_current: bool,
}

impl Log {
    /// Typical sampling rate, samples per second: from the mean of the middle half of the time steps.
    #[must_use]
    pub fn rate(&self) -> f64 {
        let mut steps: Vec<f64> = self.time.windows(2).map(|t| t[1] - t[0]).collect();
        steps.sort_by(f64::total_cmp);
        // Uneven clocks alternate between ticks, so the mean of the middle half is steadier than the median.
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

/// A reason to reject a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadLog {
    /// The file.
    pub file: String,
    /// Line and column.
    pub place: String,
    /// Content that was found.
    pub found: String,
    /// Content that was expected.
    pub expected: String,
}

impl fmt::Display for BadLog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: found {}", self.file, self.place, self.found)
    }
}

impl std::error::Error for BadLog {}
