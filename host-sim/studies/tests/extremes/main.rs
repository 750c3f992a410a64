//! Extremes: the dynamics, the controller and the simulated arm at the edges of their range. Each case is a cell of a table.
//!
//! A cell is a requirement, on which a user may rely, or a record ([`Kind`]). A cell with a numeric outcome also has an expected number, which was
//! measured before (`expected.csv`). The cell passes if its requirement holds, if it has one, and the number is within [`PINNED_WITHIN`] of the
//! expected one. A better number fails too, so that every change is noticed. A cell that cannot meet its requirement stays in the table as failing,
//! with the reason.
//!
//! Run `UPDATE_EXTREMES=1 cargo nextest run -p studies --test extremes` twice to write tables and page again: the page is made from the tables.
//!
//! | module | holds |
//! |---|---|
//! | `cell` | a cell, its outcome and its judgement |
//! | `masses` | masses and inertias, massless links, nearly singular inertia matrices |
//! | `inputs` | angles, rates, accelerations, NaN and infinite numbers, the region of small error |
//! | `integrators` | order, energy, chaos |
//! | `time` | steps, a million ticks, slow encoders, a day |
//! | `control` | saturation, wrong models, rough joints |
//! | `stability` | the longest stable period, predicted and simulated |
//! | `sampled_loop` | the loop linearised and sampled: dual numbers, eigenvalues |
//! | `tables` | the tables of `docs/measured/extremes`, and the page |
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, reason = "tests")]

mod cell;
mod control;
mod inputs;
mod integrators;
mod masses;
mod sampled_loop;
mod stability;
mod tables;
mod time;

use cell::{Cell, Kind, Outcome};
use dynamics_core::{JointSpec, Limits, Real};
use robot_compiler::Robot;
use sim::failure::Failure;

/// Largest allowed relative error of a torque in single and double precision. Single: a tenth of the practical tolerance (1e-4 of a torque limit).
/// Double: the same number of units in the last place.
pub(crate) const ROUNDING_MOST: [f64; 2] = [1e-5, 2e-14];

/// Cells that fail at present.
const FAILING: [(&str, &str); 8] = [
    ("integrators", "energy over 100 s, steps of 1 ms, planar 2R, semi-implicit Euler"),
    ("integrators", "energy over 100 s, steps of 2.5 ms, planar 2R, semi-implicit Euler"),
    ("integrators", "energy over 100 s, steps of 1 ms, Puma 560, semi-implicit Euler"),
    ("integrators", "energy over 100 s, steps of 2.5 ms, Puma 560, semi-implicit Euler"),
    ("time", "observed speed with a period of 1e-6 s, f32"),
    ("time", "observed speed with a period of 1e-5 s, f32"),
    ("control", "Coulomb friction three times the model's"),
    ("control", "torque limits times 0.25"),
];

/// True if nothing requires the number of a cell, by its name; it must then be a record.
fn is_record(cell: &Cell) -> bool {
    let starts = [
        "predicted period, ",
        "chaotic 2R, ",
        "clock drift, had it been summed",
        "breakaway, peak speed, creeping",
        "breakaway, slips, creeping",
    ];
    let beyond_a_turn = cell.name.starts_with("region at ") && !cell.name.starts_with("region at 1 turn,");
    starts.iter().any(|start| cell.name.starts_with(start))
        || cell.name.ends_with("forward, accelerations")
        || beyond_a_turn
}

/// Random numbers in [-1, 1), the same in every run: a linear congruential generator with Knuth's multiplier.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// The next number.
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// One number for each joint, in [-size, size).
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
    Robot::from_toml_str(include_str!("../../../../robots/puma560.toml"), "robots/puma560.toml").map_err(Failure::input)
}

/// The shipped UR5.
pub(crate) fn ur5() -> Result<Robot, Failure> {
    Robot::from_toml_str(include_str!("../../../../robots/ur5.toml"), "robots/ur5.toml").map_err(Failure::input)
}

/// The shipped planar arm with two rods.
pub(crate) fn planar() -> Result<Robot, Failure> {
    Robot::from_toml_str(include_str!("../../../../robots/planar2r.toml"), "robots/planar2r.toml")
        .map_err(Failure::input)
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

/// Asserts for the cells of one group that none has moved, that exactly the known ones fail, and that the group's table is up to date.
fn hold(group: &str, count: usize, cells: &[Cell]) {
    tables::hold(group, cells);
    let wrong: Vec<String> = cells
        .iter()
        .filter(|cell| cell.group != group || cell.passed == FAILING.contains(&(cell.group, &cell.name)))
        .chain(cells.iter().filter(|cell| cell.value.is_some() && cell.moved))
        .map(|cell| {
            format!("{},{:?},{:?}: found {}, expected {}", cell.group, cell.name, cell.value, cell.found, cell.expected)
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(
        cells.iter().all(|cell| cell.value.is_some() == cell.pinned.is_some()),
        "a number without its expected one"
    );
    let unlike: Vec<&String> =
        cells.iter().filter(|cell| (cell.kind == Kind::Record) != is_record(cell)).map(|cell| &cell.name).collect();
    assert!(unlike.is_empty(), "{unlike:?}");
    // A requirement must be a meaningful bound: if its window is above zero, the upper end is at most 100 times the lower end.
    for cell in cells.iter().filter(|cell| cell.kind == Kind::Requirement) {
        if let Some((least, most)) = cell.expected.split_once(", in ").and_then(|(_, window)| window.split_once(" to "))
        {
            let [least, most]: [f64; 2] = [least, most].map(|bound| bound.parse().unwrap());
            assert!(least <= 0.0 || most <= 100.0 * least, "{}: {}", cell.name, cell.expected);
        }
    }
    let known = FAILING.iter().filter(|(of, _)| *of == group).count();
    let failed = cells.iter().filter(|cell| !cell.passed).count();
    assert_eq!((cells.len(), failed), (count, known));
    // Every failing cell has a reason, and all names are unique.
    assert!(cells.iter().all(|cell| cell.passed || cell.reason.as_ref().is_some_and(|why| !why.is_empty())));
    let mut names: Vec<&String> = cells.iter().map(|cell| &cell.name).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), count);
}

#[test]
fn masses_and_inertias() {
    hold("masses", 114, &masses::cells());
}

#[test]
fn inputs_are_right_or_a_fault() {
    hold("inputs", 90, &inputs::cells().unwrap());
}

#[test]
fn integrators_keep_their_order() {
    hold("integrators", 32, &integrators::cells().unwrap());
}

#[test]
fn time_does_not_drift() {
    hold("time", 27, &time::cells().unwrap());
}

#[test]
fn control_stays_bounded() {
    hold("control", 16, &control::cells().unwrap());
}

#[test]
fn stable_periods_are_predicted() {
    hold("stability", 47, &stability::cells().unwrap());
}

/// 24 simulated hours take two minutes, so without `UPDATE_EXTREMES` only a tenth of an hour is run.
#[test]
fn a_day_does_not_drift() {
    let cells = time::long_cells(if tables::is_update() { 24.0 } else { 0.1 }).unwrap();
    if tables::is_update() {
        tables::hold("long", &cells);
    }
    assert!(cells.iter().all(|cell| cell.passed), "{cells:?}");
}
