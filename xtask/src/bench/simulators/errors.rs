//! Integration errors of both simulators, and their speeds at equal error.
//!
//! The arm follows the torques of a feedforward controller with a thousandth of the usual feedback gains. This is an open loop, which does not
//! correct integration errors. The error is the largest distance of a joint from a much finer integration by the same simulator, over 0.25 s.

use super::setup::{STEP, Settings, scene};
use crate::process::cargo_run;
use crate::table::Table;
use anyhow::{Context as _, Result, ensure};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Settings of the open loop.
const OPEN: [(&str, &str); 6] = [
    ("law", "\"feedforward\""),
    ("natural_frequency", "0.05"),
    ("scalar", "\"f64\""),
    ("sensors.encoder", "false"),
    ("actuators.saturation", "false"),
    (".duration", "0.25"),
];

/// The reference's settings.
const FINEST: Settings = &[("plant.tolerance", "1e-12")];

/// Steps that are compared, s: the control period divided by powers of two.
const STEPS: [&str; 6] = ["1e-3", "0.5e-3", "0.25e-3", "0.125e-3", "0.0625e-3", "0.03125e-3"];

/// Errors at which the speeds are compared, rad.
const AT: [f64; 2] = [1e-4, 1e-6];

/// Our reference: with friction or without.
pub(super) struct Truth {
    with_friction: bool,
    /// Its log, whose torques MuJoCo gets.
    pub(super) log: PathBuf,
    positions: Vec<Vec<f64>>,
}

impl Truth {
    pub(super) fn new(with_friction: bool, folder: &Path) -> Result<Self> {
        let log = open_loop(FINEST, with_friction, &folder.join(format!("truth-{with_friction}")))?;
        Ok(Self { with_friction, positions: positions(&log)?, log })
    }

    /// Error of an integration method, rad.
    pub(super) fn error(&self, settings: Settings, folder: &Path) -> Result<f64> {
        self.apart(&open_loop(settings, self.with_friction, &folder.join("error"))?)
    }

    fn apart(&self, log: &Path) -> Result<f64> {
        let found = positions(log)?;
        ensure!(found.len() == self.positions.len(), "{}: another number of ticks", log.display());
        let pairs = found.iter().zip(&self.positions).flat_map(|(a, b)| a.iter().zip(b));
        Ok(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max))
    }
}

/// Runs the open loop; returns its log.
fn open_loop(settings: &[(&str, &str)], with_friction: bool, out: &Path) -> Result<PathBuf> {
    let friction = [("plant.friction", if with_friction { "true" } else { "false" })];
    let path = scene("open", &[&OPEN, settings, &friction].concat())?;
    let done =
        cargo_run("host-sim").arg("run").arg(&path).args(["--quiet", "--no-report", "--out"]).arg(out).status()?;
    ensure!(done.success(), "{}: the run failed", path.display());
    Ok(out.join("log.csv"))
}

/// Positions of all joints in every tick of a log.
fn positions(log: &Path) -> Result<Vec<Vec<f64>>> {
    let text = std::fs::read_to_string(log).with_context(|| log.display().to_string())?;
    let mut lines = text.lines();
    let is_position = |name: &str| name.strip_prefix('q').is_some_and(|rest| rest.parse::<u8>().is_ok());
    let head: Vec<bool> = lines.next().unwrap_or_default().split(',').map(is_position).collect();
    ensure!(head.contains(&true), "{}: no column q1", log.display());
    let row = |line: &str| -> Result<Vec<f64>> {
        let cells = line.split(',').zip(&head).filter(|(_, wanted)| **wanted);
        cells.map(|(cell, _)| cell.parse().with_context(|| format!("{}: {cell}", log.display()))).collect()
    };
    lines.map(row).collect()
}

/// MuJoCo's cost per step and its errors, for one method, with or without friction.
pub(super) struct Rival {
    pub(super) ns: f64,
    /// Pairs of step, s, and error, rad.
    errors: Vec<(f64, f64)>,
}

impl Rival {
    pub(super) fn error(&self, step: f64) -> Option<f64> {
        self.errors.iter().find(|(of, _)| (of / step - 1.0).abs() < 1e-9).map(|(_, error)| *error)
    }
}

/// Finds a method's results in MuJoCo's output.
pub(super) fn of_mujoco(peer: &Value, method: &str, with_friction: bool) -> Result<Rival> {
    let asked = |step: &&Value| {
        step.get("method").and_then(Value::as_str) == Some(method)
            && step.get("friction").and_then(Value::as_bool) == Some(with_friction)
    };
    let read = || {
        let found = peer.get("steps")?.as_array()?.iter().find(asked)?;
        let pair = |pair: &Value| Some((pair.get(0)?.as_f64()?, pair.get(1)?.as_f64()?));
        let errors = found.get("errors")?.as_array()?.iter().map(pair).collect::<Option<_>>()?;
        Some(Rival { ns: found.get("ns")?.as_f64()?, errors })
    };
    read().with_context(|| format!("MuJoCo's side has no {method}, friction {with_friction}"))
}

/// Distance of MuJoCo's finest integration from ours, rad.
pub(super) fn apart(peer: &Value, with_friction: bool) -> Result<f64> {
    let key = if with_friction { "apart_with_friction" } else { "apart" };
    peer.get(key).and_then(Value::as_f64).with_context(|| format!("MuJoCo's side has no `{key}`"))
}

/// Ratio of simulated to real time, for the steps alone, at a step of 0.25 ms.
pub(super) struct Pace {
    pub(super) method: &'static str,
    pub(super) with_friction: bool,
    pub(super) ours: f64,
    pub(super) mujoco: f64,
}

/// The fastest fixed-step method of each simulator with a sufficiently small error. The cost of a step does not depend on its length.
pub(super) fn at_equal_error(paces: &[Pace], truth: &[Truth; 2], peer: &Value, folder: &Path) -> Result<Table> {
    let mut table = Table::new(&[
        "error at most, rad",
        "friction",
        "ours",
        "times faster than real",
        "MuJoCo",
        "times faster than real",
        "ours / MuJoCo's",
    ]);
    let mut ours: Vec<Found> = Vec::new();
    let mut theirs: Vec<Found> = Vec::new();
    for Pace { method, with_friction, ours: pace, mujoco } in paces {
        let (integrator, name) = match *method {
            "RK4" => ("\"runge-kutta\"", "Runge-Kutta"),
            _ => ("\"semi-implicit-euler\"", "semi-implicit Euler"),
        };
        let own = truth
            .iter()
            .find(|truth| truth.with_friction == *with_friction)
            .context("a reference for each friction")?;
        let rival = of_mujoco(peer, method, *with_friction)?;
        for step in STEPS {
            let settings = [("plant.integrator", integrator), ("plant.tolerance", ""), ("plant.step", step)];
            let error = own.apart(&open_loop(&settings, *with_friction, &folder.join("error"))?)?;
            let length: f64 = step.parse()?;
            let found = |error, pace: f64| Found {
                with_friction: *with_friction,
                name,
                step: length,
                error,
                pace: pace * length / STEP,
            };
            ours.push(found(error, *pace));
            theirs.extend(rival.error(length).map(|error| found(error, *mujoco)));
        }
    }
    for at in AT {
        for with_friction in [false, true] {
            let best = |all: &[Found]| {
                let fit = all.iter().filter(|found| found.with_friction == with_friction && found.error <= at);
                fit.max_by(|a, b| a.pace.total_cmp(&b.pace)).cloned()
            };
            let (ours, theirs) = (best(&ours), best(&theirs));
            let cells = |found: &Option<Found>| match found {
                Some(Found { name, step, error, pace, .. }) => {
                    [format!("{name}, {} ms: {}", step * 1e3, short(*error)), format!("{pace:.0}")]
                }
                None => ["no step above 0.03 ms".to_owned(), "-".to_owned()],
            };
            let ratio = ours.as_ref().zip(theirs.as_ref()).map(|(ours, theirs)| ours.pace / theirs.pace);
            let friction = if with_friction { "viscous, Coulomb" } else { "none" };
            let [a, b] = [cells(&ours), cells(&theirs)];
            let ratio = ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.1}"));
            table.row(&[vec![format!("{at:.0e}"), friction.into()], a.to_vec(), b.to_vec(), vec![ratio]].concat());
        }
    }
    Ok(table)
}

/// A method at one step length, with its error and its speed.
#[derive(Clone)]
struct Found {
    with_friction: bool,
    name: &'static str,
    step: f64,
    error: f64,
    pace: f64,
}

/// Formats with two digits.
pub(super) fn short(error: f64) -> String {
    format!("{error:.1e}")
}
