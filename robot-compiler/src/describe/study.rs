//! Studies: many runs of a scene whose keys vary.

use crate::describe::diagnostics::{FileError, Source};
use crate::names::Named;
use std::ops::Range;
use std::path::PathBuf;

mod unit;

/// A study file: the scene to run, the number of runs, and the figures of every run.
#[derive(Clone, Debug)]
pub struct Study {
    /// Short name.
    pub name: String,
    /// The file from which it was read.
    pub path: PathBuf,
    /// The scene, its changes, and the figures of each run.
    pub experiment: Experiment,
    /// Number of the runs, and how values are chosen for them.
    pub runs: Runs,
    pub(crate) source: Source,
    /// Locations in the file that a self-contained copy changes.
    pub(crate) places: Places,
}

/// Locations in a study file that a copy of it changes.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    /// Location of the scene's path.
    pub(crate) scene: Range<usize>,
    /// Location of the number of runs; `None` for a grid, whose values determine it.
    pub(crate) count: Option<Range<usize>>,
}

/// A scene, its changes, and the figures that are kept of each run.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// The scene file.
    pub scene: PathBuf,
    /// Keys whose value differs from their file's, the same in all runs.
    pub set: Vec<Setting>,
    /// Keys whose value changes from run to run.
    pub vary: Vec<Vary>,
    /// Figures of each run.
    pub metrics: Vec<Metric>,
}

/// A key of a scene or robot file, as a path of names, and its location in the study file.
#[derive(Clone, Debug)]
pub struct Key {
    /// The path as written in the study: `plant.payload.mass`, `robot.joint.elbow.mass`.
    pub name: String,
    pub(crate) place: Range<usize>,
}

/// A key with a fixed value, or a key that is removed.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The key.
    pub key: Key,
    /// Its value, as TOML; `None` removes the key.
    pub value: Option<String>,
}

/// A key whose value changes from run to run.
#[derive(Clone, Debug)]
pub struct Vary {
    /// The key.
    pub key: Key,
    /// Its values.
    pub values: Values,
    /// Relation of a number to the file's own value.
    pub relative: Relative,
    /// Number of values in a grid.
    pub steps: u64,
}

/// Values of a key over the runs.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Uniform between two values.
    Uniform(f64, f64),
    /// Log-uniform between two values.
    LogUniform(f64, f64),
    /// Normal, truncated to a range.
    Normal {
        /// Mean before the truncation.
        mean: f64,
        /// Standard deviation before the truncation.
        deviation: f64,
        /// Lowest and highest value; may be infinite.
        within: (f64, f64),
    },
    /// Whole numbers between two values, both included, equally likely.
    Whole(i64, i64),
    /// Listed values, equally likely.
    List(Vec<Literal>),
}

/// A listed value.
#[derive(Clone, Debug, PartialEq)]
pub struct Literal {
    /// The value as TOML.
    pub toml: String,
    /// The value as a cell of a table: strings without their quotes.
    pub cell: String,
    /// The value as a number, if it is one.
    pub number: Option<f64>,
}

/// Relation of a number to the file's own value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relative {
    /// Replaces it.
    Value,
    /// Multiplies it.
    Factor,
    /// Is added to it.
    Offset,
}

impl Named for Relative {
    const NAMES: &'static [(&'static str, &'static str, Self)] = &[
        ("factor", "The file's own value is multiplied by the number", Self::Factor),
        ("offset", "The number is added to the file's own value", Self::Offset),
    ];
}

/// Design of a study: how its values are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Design {
    /// Independent random numbers.
    Random,
    /// A Sobol sequence, which fills the space of the values evenly.
    Sobol,
    /// Every combination.
    Grid,
}

/// Number of the runs, and how values are chosen for them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Runs {
    /// Design of a study: how its values are chosen.
    pub design: Design,
    /// Number of runs.
    pub count: u64,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// A figure of a run, and the limits beyond which the run fails.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// The figure.
    pub figure: Figure,
    /// Joint, counted from 1; `None`: the largest magnitude of all joints.
    pub joint: Option<usize>,
    /// Greatest value with which a run passes.
    pub limit: Option<f64>,
    /// Least value with which a run passes.
    pub least: Option<f64>,
    /// Title of its column.
    pub title: String,
}

/// A figure of a run. All but `Drift` and `SpeedMax` are fields of a run's `summary.json`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Root mean square of the tracking error, rad or m.
    TrackingRms,
    /// Greatest tracking error, rad or m.
    TrackingMax,
    /// Root mean square of the commanded torque, N m or N.
    TorqueRms,
    /// Greatest commanded torque, N m or N.
    TorquePeak,
    /// Root mean square of the torque's change from one tick to the next, N m or N.
    TorqueChatter,
    /// Root mean square of the estimated external torque, N m or N; NaN if there is no estimate.
    ExternalRms,
    /// Magnitude of the error at the end of the last rest, rad or m; NaN without a rest.
    RestError,
    /// Time from the end of the motion until the error stays within 2 % of the move, or `resolution` if that is more, s; infinite if it
    /// does not.
    SettlingTime,
    /// Ticks in which a limit of position, velocity, torque or torque rate acted.
    LimitedTicks,
    /// Number of faults.
    Faults,
    /// 1 if a joint left its reference by more than `reach`, otherwise 0.
    OutOfReach,
    /// Distance of a joint's final position from its initial one, rad or m.
    Drift,
    /// Greatest speed, rad/s or m/s.
    SpeedMax,
}

impl Named for Figure {
    const NAMES: &'static [(&'static str, &'static str, Self)] = &[
        ("tracking_rms", "", Self::TrackingRms),
        ("tracking_max", "", Self::TrackingMax),
        ("torque_rms", "", Self::TorqueRms),
        ("torque_peak", "", Self::TorquePeak),
        ("torque_chatter", "", Self::TorqueChatter),
        ("external_rms", "", Self::ExternalRms),
        ("rest_error", "", Self::RestError),
        ("settling_time", "", Self::SettlingTime),
        ("limited_ticks", "", Self::LimitedTicks),
        ("faults", "", Self::Faults),
        ("out_of_reach", "", Self::OutOfReach),
        ("drift", "", Self::Drift),
        ("speed_max", "", Self::SpeedMax),
    ];
}

impl Figure {
    /// True if the figure exists for each joint.
    #[must_use]
    pub const fn is_per_joint(self) -> bool {
        !matches!(self, Self::Faults | Self::OutOfReach)
    }
}

impl Metric {
    /// True if a run with this figure passes; NaN does not.
    #[must_use]
    pub fn passes(&self, figure: f64) -> bool {
        self.limit.is_none_or(|limit| figure <= limit) && self.least.is_none_or(|least| figure >= least)
    }
}

impl Values {
    /// Number of different values, if they are countable.
    #[must_use]
    pub fn countable(&self) -> Option<u64> {
        match self {
            Self::Whole(low, high) => Some(high.abs_diff(*low) + 1),
            Self::List(list) => Some(list.len() as u64),
            Self::Uniform(..) | Self::LogUniform(..) | Self::Normal { .. } => None,
        }
    }

    /// True if all values are numbers.
    #[must_use]
    pub fn are_numbers(&self) -> bool {
        match self {
            Self::List(list) => list.iter().all(|value| value.number.is_some()),
            _ => true,
        }
    }
}

impl Study {
    /// An error at a key of the study.
    pub(crate) fn at(&self, key: &Key, problem: impl Into<String>, expected: impl Into<String>) -> FileError {
        self.source.error(key.place.clone(), key.name.clone(), problem, expected)
    }
}
