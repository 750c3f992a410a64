//! Filtered torques and model columns of a log.

use crate::Series;
use crate::arm::Arm;
use crate::base::Base;
use crate::filter::{LowPass, derivative, even_times, lines, spline, thinned};
use crate::held::held;
use crate::log::Log;
use nalgebra::DMatrix;

/// Sampling rates that suffice after the torque filter and after the motion filter, in multiples of the cut-off.
const PER_CUTOFF: (f64, f64) = (10.0, 5.0);

/// Rows per second, in multiples of the torque cut-off; a filtered torque contains no more information.
const ROWS_PER_CUTOFF: f64 = 4.0;

/// Cut-offs of the two filters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filters {
    /// Cut-off for positions, which are differentiated after filtering, Hz.
    pub motion: f64,
    /// Cut-off for measured and predicted torques alike, Hz.
    pub torque: f64,
}

/// A log prepared for least squares. All series are even in time.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Samples per second.
    pub rate: f64,
    /// Time of each sample, s.
    pub time: Vec<f64>,
    /// Filtered position, rad or m.
    pub q: Series,
    /// Derivative of `q`, rad/s or m/s.
    pub qd: Series,
    /// Second derivative of `q`, rad/s^2 or m/s^2.
    pub qdd: Series,
    /// Filtered torque, N m or N.
    pub tau: Series,
    /// The filter of torques.
    pub low_pass: LowPass,
    /// Cut-off of the torque filter, Hz.
    pub cutoff: f64,
    /// Filtered base-parameter columns at each joint: samples x base parameters.
    pub columns: Vec<DMatrix<f64>>,
    /// True for samples in which friction holds the joint.
    pub held: Vec<Vec<bool>>,
}

impl Prepared {
    /// Resamples a log evenly, filters its motion, and computes the base-parameter columns.
    ///
    /// Positions pass the motion filter and are differentiated twice, which gives the columns. The columns and the torque then pass the same torque
    /// filter, so that filtering itself adds no error.
    #[must_use]
    pub fn new(log: &Log, arm: &dyn Arm, base: &Base, filters: Filters) -> Self {
        let rate = log.rate();
        let even = even_times(&log.time, rate);
        let motion = LowPass::new(filters.motion, rate);
        let raw: Series = log.q.iter().map(|q| spline(&log.time, q, &even)).collect();
        let smooth: Series = raw.iter().map(|q| motion.apply(q)).collect();
        let speed: Series = smooth.iter().map(|q| derivative(q, rate)).collect();
        let change: Series = speed.iter().map(|qd| derivative(qd, rate)).collect();
        let first = LowPass::new(filters.torque, rate);
        let torque: Series = log.tau.iter().map(|tau| first.apply(&lines(&log.time, tau, &even))).collect();

        let step =
            ((rate / (PER_CUTOFF.0 * filters.torque).max(PER_CUTOFF.1 * filters.motion)).floor() as usize).max(1);
        let rate = rate / step as f64;
        let low_pass = LowPass::new(filters.torque, rate);
        let time: Vec<f64> = even.iter().step_by(step).copied().collect();
        let (q, qd, qdd) = (thinned(&smooth, step), thinned(&speed, step), thinned(&change, step));
        let columns = columns(arm, base, [&q, &qd, &qdd], &low_pass);
        let cutoff = filters.torque;
        let held = held(&thinned(&raw, step), rate, cutoff);
        Self { rate, time, q, qd, qdd, tau: thinned(&torque, step), low_pass, cutoff, columns, held }
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Number of samples from one row of the fit to the next.
    #[must_use]
    pub fn row_step(&self) -> usize {
        ((self.rate / (ROWS_PER_CUTOFF * self.cutoff)).floor() as usize).max(1)
    }

    /// True if there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Torque of the bodies at each joint for these base parameters, N m or N.
    #[must_use]
    pub fn of_bodies(&self, beta: &[f64]) -> Series {
        let row = |columns: &DMatrix<f64>| {
            let mut sum = vec![0.0; columns.nrows()];
            for (column, beta) in columns.column_iter().zip(beta) {
                for (sum, x) in sum.iter_mut().zip(column.iter()) {
                    *sum += beta * x;
                }
            }
            sum
        };
        self.columns.iter().map(row).collect()
    }
}

fn columns(arm: &dyn Arm, base: &Base, motion: [&Series; 3], low_pass: &LowPass) -> Vec<DMatrix<f64>> {
    let count = motion[0].first().map_or(0, Vec::len);
    let mut found: Vec<DMatrix<f64>> = (0..base.joints).map(|_| DMatrix::zeros(count, base.len())).collect();
    for k in 0..count {
        let state = motion.map(|series| series.iter().map(|samples| samples[k]).collect::<Vec<f64>>());
        for (matrix, row) in found.iter_mut().zip(base.rows(arm, state.each_ref().map(Vec::as_slice))) {
            matrix.row_mut(k).tr_copy_from(&row);
        }
    }
    for (i, matrix) in found.iter_mut().enumerate() {
        for b in (0..base.len()).filter(|b| base.acts(*b, i)) {
            let smooth = low_pass.apply(matrix.column(b).into_owned().as_slice());
            matrix.column_mut(b).copy_from_slice(&smooth);
        }
    }
    found
}
