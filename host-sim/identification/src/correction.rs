//! Corrections of a log: signs, scales, order of columns and delay.

use crate::Series;
use crate::filter::lines;
use crate::log::Log;

/// Operations that turn the columns of a file into positions and torques of the arm's joints.
///
/// They apply in this order: [`Correction::positions_from`] and [`Correction::torques_from`] sort the columns, then the factors multiply them, then
/// the torque is shifted in time. Joints are counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    /// For each joint, the index of the file's columns that hold its position and velocity.
    pub positions_from: Vec<usize>,
    /// For each joint, the index of the file's column that holds its torque.
    pub torques_from: Vec<usize>,
    /// Factor of each joint's position and velocity; -1 reverses the sign.
    pub position: Vec<f64>,
    /// Factor of each joint's torque.
    pub torque: Vec<f64>,
    /// Delay of each joint's torque in the log, s. Negative if the positions are late.
    pub delay: Vec<f64>,
}

impl Correction {
    /// No change, for `joints` joints.
    #[must_use]
    pub fn none(joints: usize) -> Self {
        Self {
            positions_from: (0..joints).collect(),
            torques_from: (0..joints).collect(),
            position: vec![1.0; joints],
            torque: vec![1.0; joints],
            delay: vec![0.0; joints],
        }
    }

    /// True if nothing changes.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::none(self.position.len())
    }

    /// Returns the log with sorted, scaled and shifted columns. A delay shortens the log by its own length.
    #[must_use]
    pub fn apply(&self, log: &Log) -> Log {
        let moved = |series: &Series, from: &[usize], factor: &[f64]| -> Series {
            let one = |(from, factor): (&usize, &f64)| series[*from].iter().map(|x| x * factor).collect();
            from.iter().zip(factor).map(one).collect()
        };
        let sorted = Log {
            q: moved(&log.q, &self.positions_from, &self.position),
            qd: log.qd.as_ref().map(|qd| moved(qd, &self.positions_from, &self.position)),
            tau: moved(&log.tau, &self.torques_from, &self.torque),
            ..log.clone()
        };
        shifted(&sorted, &self.delay)
    }
}

/// Returns the log with each joint's torque moved earlier by its delay, s.
#[must_use]
pub fn shifted(log: &Log, delay: &[f64]) -> Log {
    if delay.iter().all(|d| *d == 0.0) {
        return log.clone();
    }
    let (late, early) = delay.iter().fold((0.0_f64, 0.0_f64), |(a, b), d| (a.max(*d), b.min(*d)));
    let (Some(first), Some(last)) = (log.time.first(), log.time.last()) else { return log.clone() };
    // Keep only the times at which every joint has a torque.
    let inside = |t: f64| t - first >= -early - 1e-9 && last - t >= late - 1e-9;
    let kept: Vec<usize> = (0..log.time.len()).filter(|k| inside(log.time[*k])).collect();
    let pick = |series: &Series| -> Series { series.iter().map(|x| kept.iter().map(|k| x[*k]).collect()).collect() };
    let time: Vec<f64> = kept.iter().map(|k| log.time[*k]).collect();
    let torque = |(tau, delay): (&Vec<f64>, &f64)| {
        let at: Vec<f64> = time.iter().map(|t| (t + delay).clamp(*first, *last)).collect();
        lines(&log.time, tau, &at)
    };
    let tau = log.tau.iter().zip(delay).map(torque).collect();
    Log { q: pick(&log.q), qd: log.qd.as_ref().map(pick), tau, time, ..log.clone() }
}
