//! Rows of a fit: columns of the unknowns, and the torque that they must explain.

use crate::statistics::{median, rms};
use nalgebra::{DMatrix, DVector};

/// Rows of one joint.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Index of each column among all unknowns.
    pub places: Vec<usize>,
    /// Columns; one row per sample, one column per entry of `places`.
    pub columns: DMatrix<f64>,
    /// Torque, N m or N.
    pub target: DVector<f64>,
    /// Index of the log and of the block of each row.
    pub from: Vec<(usize, usize)>,
    /// True for rows in which friction holds the joint. They have zero weight.
    pub held: Vec<bool>,
    /// Rows per second.
    pub rate: f64,
}

impl Rows {
    /// Torque minus the model's torque for `x`, N m or N.
    #[must_use]
    pub fn residual(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut left = self.target.clone();
        for (column, &place) in self.columns.column_iter().zip(&self.places) {
            left.axpy(-x[place], &column, 1.0);
        }
        left
    }

    /// 1 for every row, 0 where friction holds the joint.
    #[must_use]
    pub fn weights(&self) -> Vec<f64> {
        self.held.iter().map(|held| if *held { 0.0 } else { 1.0 }).collect()
    }

    /// Same as [`Rows::residual`]; 0 where friction holds the joint.
    #[must_use]
    pub fn moving_residual(&self, x: &DVector<f64>) -> DVector<f64> {
        self.residual(x).component_mul(&DVector::from_vec(self.weights()))
    }

    /// Robust standard deviation of the rows in which friction does not hold the joint: 1.4826 times the median magnitude, and at least half of the
    /// root mean square.
    #[must_use]
    pub fn deviation(&self, left: &DVector<f64>) -> f64 {
        let moving: Vec<f64> = left.iter().zip(&self.held).filter(|(_, held)| !**held).map(|(e, _)| *e).collect();
        let median = median(moving.iter().map(|x| x.abs()).collect());
        (1.4826 * median).max(0.5 * rms(&moving)).max(1e-9)
    }
}
