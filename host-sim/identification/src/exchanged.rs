//! Columns of two joints that stand in each other's place.

use crate::Series;
use crate::arm::Arm;
use crate::base::Base;
use crate::fit::{Problem, deviation};
use crate::friction::{Direction, Law};
use crate::identify::{TORQUE_CUTOFF, rms};
use crate::log::Log;
use crate::prepare::{Filters, Prepared};

/// Share of its torque that a joint must miss before anything is suspected.
const SUSPECT: f64 = 0.3;
/// What an exchange may leave of the errors of all joints together, at most.
const BETTER: f64 = 0.5;

/// What of a log was exchanged, and between which joints, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exchanged {
    /// Torques.
    Torques(usize, usize),
    /// Positions.
    Positions(usize, usize),
}

/// Two joints whose torques no bodies explain, and would if their torques, or their positions, were exchanged. `None` for a log that the
/// arm explains, or that no exchange mends.
#[must_use]
pub fn exchanged(arm: &dyn Arm, log: &Log) -> Option<Exchanged> {
    let base = Base::of(arm);
    let cutoff = TORQUE_CUTOFF.min(0.2 * log.rate());
    let missed = |log: &Log| -> Vec<f64> {
        let logs = [Prepared::new(log, arm, &base, Filters { motion: cutoff, torque: cutoff })];
        let laws = vec![Law::with(Direction::Hysteresis(1e-4), &[]); base.joints];
        let fit = Problem { logs: &logs, base: &base, laws: &laws }.fit();
        let left = fit.rows.iter().map(|rows| deviation(rows.residual(&fit.x).as_slice()));
        left.zip(rms(&logs[0].tau)).map(|(left, size)| left / size.max(1e-12)).collect()
    };
    let now = missed(log);
    let suspects: Vec<usize> = (0..now.len()).filter(|joint| now[*joint] > SUSPECT).collect();
    let pairs =
        suspects.iter().flat_map(|a| (0..now.len()).filter(|b| *b != *a).map(move |b| (*a.min(&b), *a.max(&b))));
    let turned = |series: &Series, (a, b): (usize, usize)| {
        let mut series = series.clone();
        series.swap(a, b);
        series
    };
    let before: f64 = now.iter().sum();
    let mut best = (BETTER * before, None);
    for (a, b) in pairs {
        let torques = Log { tau: turned(&log.tau, (a, b)), ..log.clone() };
        let positions = Log { q: turned(&log.q, (a, b)), ..log.clone() };
        for (tried, name) in [(torques, Exchanged::Torques(a, b)), (positions, Exchanged::Positions(a, b))] {
            let after = missed(&tried).iter().sum();
            if after < best.0 {
                best = (after, Some(name));
            }
        }
    }
    best.1
}
