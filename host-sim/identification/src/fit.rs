//! Robust weighted least squares, held-out error and standard deviations.

mod covariance;
mod normal;
mod rows;

pub(crate) use normal::condition;
pub use normal::{Normal, inverse, solve};
pub use rows::Rows;

use crate::Series;
use crate::base::Base;
use crate::friction::FrictionLaw;
use crate::prepare::Prepared;
use nalgebra::{DMatrix, DVector};

/// Rounds of robust weights. The loads in the friction terms are updated in the same rounds.
const ROUNDS: usize = 5;
/// Huber's constant: residuals beyond this many standard deviations get less weight.
const HUBER: f64 = 1.5;
/// Prior size of an offset, as a share of the torque's root mean square.
const OFFSET: f64 = 0.05;
/// Blocks that are held out in turn.
const BLOCKS: usize = 8;

/// A fit: its logs, and its unknowns, which are base parameters and the friction coefficients of each joint.
#[derive(Clone, Copy, Debug)]
pub struct FitProblem<'a> {
    /// The logs.
    pub logs: &'a [Prepared],
    /// The base parameters.
    pub base: &'a Base,
    /// Friction law of each joint.
    pub laws: &'a [FrictionLaw],
}

/// Solution of a fit and its residuals.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Base parameters, then the coefficients of each joint's friction.
    pub x: DVector<f64>,
    /// Robust standard deviation of each joint's residual, N m or N.
    pub sigma: Vec<f64>,
    /// Rows of each joint.
    pub rows: Vec<Rows>,
    /// Robust weight of each row, from 0 to 1.
    pub weights: Vec<Vec<f64>>,
    /// Normal equations of all rows, each divided by its residual's standard deviation.
    pub normal: Normal,
}

impl FitProblem<'_> {
    /// Number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.offset(self.laws.len())
    }

    /// Index of the first friction coefficient of a joint.
    #[must_use]
    pub fn offset(&self, joint: usize) -> usize {
        self.base.len() + self.laws[..joint].iter().map(|law| law.terms.len()).sum::<usize>()
    }

    /// Filtered friction torque at unit coefficients, for each joint and term.
    #[must_use]
    pub fn friction(&self, log: &Prepared, loads: &Series) -> Vec<Series> {
        let of = |(joint, law): (usize, &FrictionLaw)| {
            let found = law.columns(&log.q[joint], &log.qd[joint], &loads[joint]);
            found.iter().map(|column| log.low_pass.apply(column)).collect()
        };
        self.laws.iter().enumerate().map(of).collect()
    }

    /// Rows of each joint; `loads` are the torques that load-dependent friction terms use, for each log.
    #[must_use]
    pub fn rows(&self, loads: &[Series]) -> Vec<Rows> {
        let friction: Vec<Vec<Series>> =
            self.logs.iter().zip(loads).map(|(log, loads)| self.friction(log, loads)).collect();
        (0..self.laws.len()).map(|joint| self.rows_of(joint, &friction)).collect()
    }

    fn rows_of(&self, joint: usize, friction: &[Vec<Series>]) -> Rows {
        let bodies: Vec<usize> = (0..self.base.len()).filter(|b| self.base.acts(*b, joint)).collect();
        let start = self.offset(joint);
        let terms = self.laws[joint].terms.len();
        let places: Vec<usize> = bodies.iter().copied().chain(start..start + terms).collect();
        let mut picked = Vec::new();
        let each = (BLOCKS / self.logs.len().max(1)).max(2);
        for (index, log) in self.logs.iter().enumerate() {
            let step = log.row_step();
            picked.extend((0..log.len()).step_by(step).map(|k| (index, k, index * each + k * each / log.len())));
        }
        let columns = DMatrix::from_fn(picked.len(), places.len(), |row, column| {
            let (log, k, _) = picked[row];
            match bodies.get(column) {
                Some(b) => self.logs[log].columns[joint][(k, *b)],
                None => friction[log][joint][column - bodies.len()][k],
            }
        });
        let target =
            DVector::from_iterator(picked.len(), picked.iter().map(|(log, k, _)| self.logs[*log].tau[joint][*k]));
        let rate = self.logs.first().map_or(1.0, |log| log.rate / log.row_step() as f64);
        let held = picked.iter().map(|(log, k, _)| self.logs[*log].held[joint][*k]).collect();
        let from = picked.into_iter().map(|(log, _, block)| (log, block)).collect();
        Rows { places, columns, target, from, held, rate }
    }

    /// Normal equations of all rows. The offset has a prior around zero: on a vertical slide it cannot be told from weight, and the torque should go
    /// to the weight.
    fn normal(&self, rows: &[Rows], sigma: &[f64], weights: &[Vec<f64>]) -> Normal {
        let mut normal = Normal::of(rows, sigma, weights, |_| true, self.unknowns());
        for (joint, rows) in rows.iter().enumerate() {
            let size = rows.target.norm() / (rows.target.len().max(1) as f64).sqrt();
            let at = self.offset(joint);
            normal.matrix[(at, at)] += (OFFSET * size.max(1e-9)).powi(-2);
        }
        normal
    }

    /// Solves the least squares problem. Weights are updated from the residuals and loads from the fit, in a fixed number of rounds.
    #[must_use]
    pub fn fit(&self) -> Fit {
        let mut loads: Vec<Series> = self.logs.iter().map(|log| log.tau.clone()).collect();
        let mut rows = self.rows(&loads);
        let mut sigma: Vec<f64> = rows.iter().map(|rows| rows.deviation(&rows.target)).collect();
        let mut weights: Vec<Vec<f64>> = rows.iter().map(Rows::weights).collect();
        let mut x = DVector::zeros(self.unknowns());
        let uses_loads = self.laws.iter().any(|law| law.terms.iter().any(|term| term.uses_load()));
        for round in 0..ROUNDS {
            let normal = self.normal(&rows, &sigma, &weights);
            x = solve(&normal.matrix, &normal.right);
            for ((rows, sigma), weights) in rows.iter().zip(&mut sigma).zip(&mut weights) {
                let left = rows.residual(&x);
                *sigma = rows.deviation(&left);
                *weights = rows.weights();
                for (weight, e) in weights.iter_mut().zip(left.iter()) {
                    *weight *= (HUBER * *sigma / e.abs().max(1e-12)).min(1.0);
                }
            }
            if uses_loads && round + 1 < ROUNDS {
                loads = self.logs.iter().map(|log| log.of_bodies(&x.as_slice()[..self.base.len()])).collect();
                rows = self.rows(&loads);
            }
        }
        let normal = self.normal(&rows, &sigma, &weights);
        Fit { x, sigma, rows, weights, normal }
    }
}

impl Fit {
    /// Root mean square of each joint's residual in held-out blocks, N m or N.
    #[must_use]
    pub fn held_out(&self) -> Vec<f64> {
        let blocks = 1 + self.rows.iter().flat_map(|rows| rows.from.iter().map(|(_, block)| *block)).max().unwrap_or(0);
        let mut squares = vec![(0.0, 0usize); self.rows.len()];
        for block in 0..blocks {
            let held = Normal::of(&self.rows, &self.sigma, &self.weights, |b| b == block, self.x.len());
            let x = solve(&(&self.normal.matrix - &held.matrix), &(&self.normal.right - &held.right));
            for (rows, (sum, count)) in self.rows.iter().zip(&mut squares) {
                let left = rows.residual(&x);
                for ((e, (_, of)), held) in left.iter().zip(&rows.from).zip(&rows.held) {
                    if *of == block && !held {
                        *sum += e * e;
                        *count += 1;
                    }
                }
            }
        }
        squares.iter().map(|(sum, count)| (sum / (*count).max(1) as f64).sqrt()).collect()
    }

    /// Autocorrelation of each joint's residual at a lag of 0.25 s, from 0 to 1. It is near 0 for noise, and larger if the model lacks an effect.
    #[must_use]
    pub fn persistence(&self) -> Vec<f64> {
        let of = |rows: &Rows| {
            let left = rows.moving_residual(&self.x);
            let lag = ((0.25 * rows.rate).round() as usize).max(1);
            let pairs = (0..left.len().saturating_sub(lag)).filter(|k| rows.from[*k].0 == rows.from[k + lag].0);
            let product: f64 = pairs.map(|k| left[k] * left[k + lag]).sum();
            (product / left.norm_squared().max(1e-300)).max(0.0)
        };
        self.rows.iter().map(of).collect()
    }

    /// Change of the unknowns caused by a change of one joint's torque, given for each row.
    #[must_use]
    pub fn change(&self, joint: usize, torque: &DVector<f64>) -> DVector<f64> {
        let rows = &self.rows[joint];
        let weighed = DVector::from_iterator(
            torque.len(),
            torque.iter().zip(&self.weights[joint]).map(|(t, w)| t * w / (self.sigma[joint] * self.sigma[joint])),
        );
        let mut right = DVector::zeros(self.x.len());
        for (column, &place) in rows.columns.column_iter().zip(&rows.places) {
            right[place] += column.dot(&weighed);
        }
        solve(&self.normal.matrix, &right)
    }
}
