//! Extremes: the dynamics, the controller and the simulated arm at the edges of their range, cell by cell.
//!
//! A cell is a requirement, on which a user may rely, or a record ([`Kind`]). A cell with a numeric outcome also has an
//! expected number, which was measured before (`extremes/expected.csv`). The cell passes if its requirement holds, if it
//! has one, and the number is within [`PINNED_WITHIN`] of the expected one. A better number fails too, so that every
//! change is seen. A cell that cannot meet its requirement stays in the table as failing, with the reason.
//!
//! | module | holds |
//! |---|---|
//! | `cell` | a cell, its outcome and its judgement |
//! | [`masses`] | masses and inertias, massless links, nearly singular inertia matrices |
//! | [`inputs`] | angles, rates, accelerations, NaN and infinite numbers, the region of small error |
//! | [`integrators`] | order, energy, chaos |
//! | [`time`] | steps, a million ticks, slow encoders, a day |
//! | [`control`] | saturation, wrong models, rough joints |
//! | [`stability`] | the longest stable period, predicted and simulated |
//! | [`sampled_loop`] | the loop linearised and sampled: dual numbers, eigenvalues |

mod cell;
pub mod control;
pub mod inputs;
pub mod integrators;
pub mod masses;
mod page;
pub mod sampled_loop;
pub mod stability;
pub mod time;

pub(crate) use cell::Outcome;
pub use cell::{Cell, Kind, PINNED_WITHIN};

use dynamics_core::{JointSpec, Limits, Real};
use robot_compiler::Robot;
use serde::Serialize;
use sim::failure::Failure;
use sim::table::table;
use std::fmt::Write;

/// Largest relative error of a torque that is required in single and double precision. Single: a tenth of what use allows
/// (1e-4 of a torque limit). Double: as many units in the last place.
pub(crate) const ROUNDING_MOST: [f64; 2] = [1e-5, 2e-14];

/// All cells with their counts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Number of cells.
    pub count: usize,
    /// Number of passing cells.
    pub passed: usize,
    /// Number of failing cells.
    pub failed: usize,
    /// Number of cells that are records.
    pub records: usize,
    /// The cells.
    pub cells: Vec<Cell>,
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
        let records = cells.iter().filter(|cell| cell.kind == Kind::Record).count();
        Self { count: cells.len(), passed, failed: cells.len() - passed, records, cells }
    }

    /// Table for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = table(["group", "cell", "kind", "expected", "found", ""], usize::MAX);
        for cell in &self.cells {
            let mark = if cell.passed { cell.passes() } else { "FAIL" };
            table.add_row([cell.group, &cell.name, cell.kind.name(), &cell.expected, &cell.found, mark]);
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
                    "\n### {}\n\n| cell | what is done | kind | expected | found | |\n|---|---|---|---|---|---|\n",
                    title(group)
                );
            }
            let mark = match &cell.reason {
                None => cell.passes().to_owned(),
                Some(reason) => format!("**fails**: {reason}"),
            };
            let bars = |text: &str| text.replace('|', "\\|");
            let row = [&cell.name, &cell.done, cell.kind.name(), &cell.expected, &cell.found, &mark].map(bars);
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
        text
    }

    fn count(&self) -> String {
        let Self { count, passed, failed, records, .. } = self;
        let required = count - records;
        format!("{count} cells: {passed} passed, {failed} failed; {required} requirements, {records} records")
    }
}

/// A group's name with a capital letter.
fn title(group: &str) -> String {
    let mut letters = group.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
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
