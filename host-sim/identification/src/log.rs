//! A log: columns of a CSV file, and what is wrong with them.

mod check;
mod header;

use crate::Series;
use std::fmt;

/// How a log is to be read.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Names of the joints, base first: a column may bear a number from 1 or a name.
    pub joints: Vec<String>,
    /// Whether each joint turns.
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

    /// Reads and checks the text of a CSV file with a header.
    ///
    /// Columns: `time` (or `t`, in s; or `tick`), and per joint `q_1` .., optionally `qd_1` .., and `tau_1` .. or `current_1` ..;
    /// variants of these names are in the manual of `host-sim identify`. A row in which all positions, or all torques, are empty is left out. Other columns are left alone.
    ///
    /// # Errors
    /// [`BadLog`] names the line and the column: a column that is missing or there twice, a field that is no number, time that runs back
    /// or has a gap, units that cannot be, a joint that never moves, clipped torques, columns of two joints exchanged, too few samples.
    pub fn read(text: &[u8], file: &str, reading: &Reading) -> Result<Self, BadLog> {
        let wrong =
            |place: String, found: String, expected: String| BadLog { file: file.to_owned(), place, found, expected };
        let mut rows = csv::ReaderBuilder::new().flexible(true).trim(csv::Trim::All).from_reader(text);
        let head = rows
            .headers()
            .map_err(|error| wrong("line 1".to_owned(), error.to_string(), "a header of column names".to_owned()))?
            .clone();
        let head: Vec<String> = head.iter().map(str::to_owned).collect();
        let places = header::Places::find(&head, reading)
            .map_err(|(found, expected)| wrong("line 1".to_owned(), found, expected))?;
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); places.all.len()];
        let mut lines = Vec::new();
        for (index, row) in rows.records().enumerate() {
            let row = row.map_err(|error| {
                wrong(format!("row {}", index + 1), error.to_string(), "numbers with commas between".to_owned())
            })?;
            let line = row.position().map_or(index as u64 + 2, csv::Position::line);
            // A tick without a reading, or without a torque: a record has such before the arm is armed.
            let empty = |of: &[usize]| of.iter().all(|place| row.get(*place) == Some(""));
            if empty(places.positions()) || empty(places.torques()) {
                continue;
            }
            for (&place, column) in places.all.iter().zip(&mut columns) {
                let text = row.get(place).unwrap_or("");
                let number = text.parse::<f64>().ok().filter(|x| x.is_finite());
                if text.is_empty() && places.speeds().contains(&place) {
                    column.push(f64::NAN);
                    continue;
                }
                column.push(number.ok_or_else(|| {
                    let found = if text.is_empty() { "nothing".to_owned() } else { format!("{text:?}") };
                    wrong(format!("line {line}, {}", head[place]), found, "a finite number".to_owned())
                })?);
            }
            lines.push(line);
        }
        let table = check::Table { file, head: &head, places: &places, lines: &lines };
        table.checked(columns, reading)
    }
}

/// Why a log is of no use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadLog {
    /// The file.
    pub file: String,
    /// Line and column.
    pub place: String,
    /// What is there.
    pub found: String,
    /// What should be.
    pub expected: String,
}

impl fmt::Display for BadLog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: found {}", self.file, self.place, self.found)
    }
}

impl std::error::Error for BadLog {}
