//! Covariance of a fit with autocorrelated residuals.

use super::normal::{dot, inverse};
use super::{Fit, Rows};
use nalgebra::{DMatrix, DVector};

/// Longest autocorrelation that is measured, rows.
const LAGS: usize = 60;
/// Autocorrelation below which residuals count as independent.
const ENDED: f64 = 0.03;

impl Rows {
    /// Number of neighbouring rows of this residual that carry as much information as one independent row.
    #[must_use]
    pub fn runs(&self, left: &[f64]) -> f64 {
        run_length(&autocovariance(left, self))
    }
}

impl Fit {
    /// Covariance of the unknowns. Filtered residuals, and effects that the model lacks, are correlated in time. Their measured autocorrelation
    /// enters the covariance.
    ///
    /// `H^-1 S H^-1`, with `S = sum_j sum_k gamma_j(k) (1 - k / K) sum_t a_t a_(t+k)^T`: Bartlett's weights on the autocovariance `gamma` of each
    /// joint's weighted residual (Newey and West 1987, with the residual independent of the columns). `gamma` is raised to correct for the degrees of
    /// freedom that the unknowns have used.
    #[must_use]
    pub fn covariance(&self) -> DMatrix<f64> {
        let mut spread = DMatrix::zeros(self.x.len(), self.x.len());
        for ((rows, sigma), weights) in self.rows.iter().zip(&self.sigma).zip(&self.weights) {
            add(&mut spread, rows, *sigma, weights, &self.x);
        }
        let inverse = inverse(&self.normal.matrix);
        &inverse * spread * &inverse
    }
}

fn add(spread: &mut DMatrix<f64>, rows: &Rows, sigma: f64, weights: &[f64], x: &DVector<f64>) {
    let count = rows.target.len();
    let roots: Vec<f64> = weights.iter().map(|w| w.sqrt() / sigma).collect();
    let left: Vec<f64> = rows.residual(x).iter().zip(&roots).map(|(e, w)| e * w).collect();
    let covariances = autocovariance(&left, rows);
    let lags = covariances.len();
    let bartlett = |lag: usize| 1.0 - lag as f64 / lags as f64;
    let moving = rows.held.iter().filter(|held| !**held).count();
    let independent = moving as f64 / run_length(&covariances);
    let used = rows.places.len() as f64;
    // Each joint's degrees of freedom are reduced by its friction terms and its share of the bodies, by at most nine tenths.
    let raise = independent / (independent - used.min(0.9 * independent));
    let packed: Vec<Vec<f64>> =
        rows.columns.column_iter().map(|column| column.iter().zip(&roots).map(|(x, w)| x * w).collect()).collect();
    for (lag, covariance) in covariances.iter().enumerate() {
        let factor = raise * covariance * bartlett(lag);
        for (a, &at) in rows.places.iter().enumerate() {
            for (b, &to) in rows.places.iter().enumerate() {
                // Pairs that span two logs are few, and their effect is negligible.
                let product = dot(&packed[a][..count - lag], &packed[b][lag..]);
                spread[(at, to)] += factor * product;
                if lag > 0 {
                    spread[(to, at)] += factor * product;
                }
            }
        }
    }
}

/// Number of rows that carry as much information as one independent row.
fn run_length(covariances: &[f64]) -> f64 {
    let lags = covariances.len() as f64;
    let sum: f64 = covariances.iter().enumerate().skip(1).map(|(k, c)| (1.0 - k as f64 / lags) * c).sum();
    (1.0 + 2.0 * sum / covariances[0]).max(1.0)
}

/// Autocovariance of a residual, up to the lag at which it has decayed.
fn autocovariance(left: &[f64], rows: &Rows) -> Vec<f64> {
    let count = left.len();
    let at = |lag: usize| {
        let pairs = (0..count - lag).filter(|k| rows.from[*k].0 == rows.from[k + lag].0);
        pairs.map(|k| left[k] * left[k + lag]).sum::<f64>() / count as f64
    };
    let first = at(0).max(f64::MIN_POSITIVE);
    let mut found = vec![first];
    let most = LAGS.min(count / 4);
    while found.len() < most && found.last().is_some_and(|last| *last > ENDED * first) {
        found.push(at(found.len()));
    }
    // Continue to twice the lag, because Bartlett's weights would otherwise halve the correlation.
    let end = (2 * found.len()).min(most.max(1));
    while found.len() < end {
        found.push(at(found.len()));
    }
    found
}
