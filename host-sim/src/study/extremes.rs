//! Extremes: the dynamics, the controller and the simulated arm at the edges of their range, cell by cell.
//!
//! A cell has a requirement, on which a user may rely. A cell with a numeric outcome also has an expected number, which
//! was measured before (`extremes/expected.csv`). The cell passes if the requirement holds and the number is within
//! [`PINNED_WITHIN`] of the expected one. A better number fails too, so that every change is seen. A cell that cannot
//! meet its requirement stays in the table as failing, with the reason.
//!
//! | module | holds |
//! |---|---|
//! | [`masses`] | masses and inertias, massless links, nearly singular inertia matrices |
//! | [`inputs`] | angles, rates, accelerations, NaN and infinite numbers, the region of small error |
//! | [`integrators`] | order, energy, chaos |
//! | [`time`] | steps, a million ticks, slow encoders, a day |
//! | [`control`] | saturation, wrong models, rough joints |
//! | [`stability`] | the longest stable period, predicted and simulated |
//! | [`sampled_loop`] | the loop linearised and sampled: dual numbers, eigenvalues |

pub mod control;
pub mod inputs;
pub mod integrators;
pub mod masses;
mod plots;
pub mod sampled_loop;
pub mod stability;
pub mod time;

pub use plots::write_plots;

use crate::failure::Failure;
use crate::table::table;
use dynamics_core::{JointSpec, Limits, Real};
use robot_compiler::Robot;
use serde::Serialize;
use std::fmt::Write;

/// Largest relative deviation from an expected number.
pub const PINNED_WITHIN: f64 = 0.02;

/// The expected numbers: `group,name,value`.
const EXPECTED: &str = include_str!("extremes/expected.csv");

/// One extreme case with its result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// Group of the cell.
    pub group: &'static str,
    /// Name, unique in the group.
    pub name: String,
    /// Description of the test.
    pub done: String,
    /// Expected result: the number and its requirement, or the outcome in words.
    pub expected: String,
    /// Result of the test.
    pub found: String,
    /// The measured number; `None` for an outcome in words.
    pub value: Option<f64>,
    /// The expected number from an earlier measurement, if any; long cells have only their requirement.
    pub pinned: Option<f64>,
    /// Whether the outcome differs from the expected one, in either direction.
    pub moved: bool,
    /// Whether the requirement holds and the outcome is the expected one.
    pub passed: bool,
    /// Reason for a failure.
    pub reason: Option<String>,
}

/// All cells with their counts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Number of cells.
    pub count: usize,
    /// Number of passing cells.
    pub passed: usize,
    /// Number of failing cells.
    pub failed: usize,
    /// The cells.
    pub cells: Vec<Cell>,
}

/// Outcome of a cell before it is judged.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Outcome {
    /// A number with its allowed range and unit.
    Number { value: f64, least: f64, most: f64, unit: &'static str },
    /// Words, compared with the expected words.
    Words { found: String, expected: String },
}

impl Outcome {
    /// A number with an upper bound.
    pub(crate) fn at_most(value: f64, most: f64, unit: &'static str) -> Self {
        Self::Number { value, least: f64::NEG_INFINITY, most, unit }
    }

    /// A number with two bounds.
    pub(crate) fn between(value: f64, least: f64, most: f64, unit: &'static str) -> Self {
        Self::Number { value, least, most, unit }
    }

    /// Words and the expected words.
    pub(crate) fn words(found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Words { found: found.into(), expected: expected.into() }
    }
}

impl Cell {
    /// Judge an outcome; `reason` explains a requirement that cannot be met.
    pub(crate) fn new(
        group: &'static str,
        name: impl Into<String>,
        done: impl Into<String>,
        outcome: Outcome,
        reason: &str,
    ) -> Self {
        let (name, done) = (name.into(), done.into());
        let pinned = pinned(group, &name);
        let (expected, found, value, moved, holds) = match outcome {
            Outcome::Words { found, expected } => {
                let holds = found == expected;
                (expected, found, None, !holds, holds)
            }
            Outcome::Number { value, least, most, unit } => {
                let near = |pinned: f64| (value - pinned).abs() <= PINNED_WITHIN * pinned.abs();
                let moved = pinned.is_some_and(|pinned| !near(pinned));
                let holds = value >= least && value <= most;
                let required = match (least.is_finite(), most.is_finite()) {
                    (true, true) => Some(format!("in {} to {}", number(least, ""), number(most, ""))),
                    (true, false) => Some(format!("at least {}", number(least, ""))),
                    (false, true) => Some(format!("at most {}", number(most, ""))),
                    (false, false) => None,
                };
                let expected: Vec<String> = pinned.map(|x| number(x, unit)).into_iter().chain(required).collect();
                (expected.join(", "), number(value, unit), Some(value), moved, holds)
            }
        };
        let why = match (holds, moved) {
            (true, false) => None,
            (true, true) => Some("not the expected number".to_owned()),
            (false, _) => Some(reason.to_owned()),
        };
        Self { group, name, done, expected, found, value, pinned, moved, passed: why.is_none(), reason: why }
    }
}

impl Report {
    /// Run every cell but the long ones.
    ///
    /// # Errors
    /// A shipped robot cannot be read.
    pub fn new() -> Result<Self, Failure> {
        let mut cells = masses::cells();
        cells.extend(inputs::cells()?);
        cells.extend(integrators::cells()?);
        cells.extend(time::cells()?);
        cells.extend(control::cells()?);
        cells.extend(stability::cells()?);
        Ok(Self::of(cells))
    }

    /// Build a report and count its cells.
    #[must_use]
    pub fn of(cells: Vec<Cell>) -> Self {
        let passed = cells.iter().filter(|cell| cell.passed).count();
        Self { count: cells.len(), passed, failed: cells.len() - passed, cells }
    }

    /// Table for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = table(["group", "cell", "expected", "found", ""], usize::MAX);
        for cell in &self.cells {
            let mark = if cell.passed { "pass" } else { "FAIL" };
            table.add_row([cell.group, &cell.name, &cell.expected, &cell.found, mark]);
        }
        let mut text = format!("{table}\n");
        for cell in self.cells.iter().filter(|cell| !cell.passed) {
            let reason = cell.reason.as_deref().unwrap_or_default();
            let _ = writeln!(text, "fails: {}, {}: {reason}", cell.group, cell.name);
        }
        text + &self.count()
    }

    /// Markdown: a table per group, then the counts.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!("{}\n", self.count());
        let mut group = "";
        for cell in &self.cells {
            if cell.group != group {
                group = cell.group;
                let _ = write!(
                    text,
                    "\n### {}\n\n| cell | what is done | expected | found | |\n|---|---|---|---|---|\n",
                    title(group)
                );
            }
            let mark = match &cell.reason {
                None => "pass".to_owned(),
                Some(reason) => format!("**fails**: {reason}"),
            };
            let bars = |text: &str| text.replace('|', "\\|");
            let row = [&cell.name, &cell.done, &cell.expected, &cell.found, &mark].map(|text| bars(text));
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
        text
    }

    fn count(&self) -> String {
        format!("{} cells: {} passed, {} failed", self.count, self.passed, self.failed)
    }
}

/// A group's name with a capital letter.
fn title(group: &str) -> String {
    let mut letters = group.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Number with three digits, with an exponent if it is very large or small.
fn number(x: f64, unit: &str) -> String {
    let size = x.abs();
    let text = if x == 0.0 {
        "0".to_owned()
    } else if (0.01..1e4).contains(&size) {
        let decimals = (2 - libm::floor(libm::log10(size)) as i32).max(0) as usize;
        format!("{x:.decimals$}")
    } else {
        format!("{x:.2e}")
    };
    if unit.is_empty() { text } else { format!("{text} {unit}") }
}

/// The expected number of a cell.
fn pinned(group: &str, name: &str) -> Option<f64> {
    let mut rows = csv::ReaderBuilder::new().has_headers(true).from_reader(EXPECTED.as_bytes());
    let found = rows.records().flatten().find(|row| row.get(0) == Some(group) && row.get(1) == Some(name))?;
    found.get(2)?.parse().ok()
}

/// Random numbers in [-1, 1), the same in every run: a linear congruential generator with Knuth's multiplier.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub(crate) fn joints<const N: usize>(&mut self, size: f64) -> [f64; N] {
        core::array::from_fn(|_| size * self.next())
    }
}

/// Name of a scalar, `f32` or `f64`.
pub(crate) fn scalar_name<S: Real>() -> &'static str {
    if size_of::<S>() == size_of::<f32>() { "f32" } else { "f64" }
}

/// The shipped Puma 560.
pub(crate) fn puma() -> Result<Robot, Failure> {
    Robot::from_toml_str(include_str!("../../../robots/puma560.toml"), "robots/puma560.toml").map_err(Failure::input)
}

/// The shipped UR5.
pub(crate) fn ur5() -> Result<Robot, Failure> {
    Robot::from_toml_str(include_str!("../../../robots/ur5.toml"), "robots/ur5.toml").map_err(Failure::input)
}

/// The shipped planar arm with two rods.
pub(crate) fn planar() -> Result<Robot, Failure> {
    Robot::from_toml_str(include_str!("../../../robots/planar2r.toml"), "robots/planar2r.toml").map_err(Failure::input)
}

/// The joints of a robot.
pub(crate) fn joints<const N: usize>(robot: &Robot) -> Result<[JointSpec; N], Failure> {
    let specs: Vec<JointSpec> = robot.joints.iter().map(|joint| joint.spec).collect();
    <[JointSpec; N]>::try_from(specs)
        .map_err(|_| Failure::Input(miette::miette!("{} does not have {N} joints", robot.name)))
}

/// Joints without their limits.
pub(crate) fn unlimited<const N: usize>(joints: [JointSpec; N]) -> [JointSpec; N] {
    joints.map(|joint| JointSpec { limits: Limits::none(), ..joint })
}
