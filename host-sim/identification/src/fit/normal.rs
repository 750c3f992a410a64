//! Normal equations of weighted least squares.

use super::Rows;
use nalgebra::{DMatrix, DVector};

/// Ridge, as a share of the scaled diagonal. It bounds the solution in directions that no row determines.
const RIDGE: f64 = 1e-10;

/// Variance of an undetermined unknown: larger than any parameter's square, and far from overflow.
const UNSEEN: f64 = 1e8;

/// `A^T W A` and `A^T W b`.
#[derive(Clone, Debug)]
pub struct Normal {
    /// `A^T W A`, symmetric.
    pub matrix: DMatrix<f64>,
    /// `A^T W b`.
    pub right: DVector<f64>,
}

impl Normal {
    /// Sums the rows of the blocks for which `block` is true, each with weight `weight / sigma^2`.
    #[must_use]
    pub fn of(
        rows: &[Rows],
        sigma: &[f64],
        weights: &[Vec<f64>],
        block: impl Fn(usize) -> bool,
        unknowns: usize,
    ) -> Self {
        let mut normal = Self { matrix: DMatrix::zeros(unknowns, unknowns), right: DVector::zeros(unknowns) };
        for ((rows, sigma), weights) in rows.iter().zip(sigma).zip(weights) {
            normal.add(rows, *sigma, weights, &block);
        }
        normal
    }

    fn add(&mut self, rows: &Rows, sigma: f64, weights: &[f64], block: &impl Fn(usize) -> bool) {
        let taken: Vec<usize> = (0..rows.target.len()).filter(|k| block(rows.from[*k].1)).collect();
        // Packed by columns, so that the products below read adjacent memory.
        let pack = |column: usize| -> Vec<f64> {
            taken.iter().map(|k| rows.columns[(*k, column)] * (weights[*k].sqrt() / sigma)).collect()
        };
        let packed: Vec<Vec<f64>> = (0..rows.places.len()).map(pack).collect();
        let target: Vec<f64> = taken.iter().map(|k| rows.target[*k] * (weights[*k].sqrt() / sigma)).collect();
        for (a, &at) in rows.places.iter().enumerate() {
            self.right[at] += dot(&packed[a], &target);
            for (b, &to) in rows.places.iter().enumerate().take(a + 1) {
                let product = dot(&packed[a], &packed[b]);
                self.matrix[(at, to)] += product;
                if a != b {
                    self.matrix[(to, at)] += product;
                }
            }
        }
    }
}

/// Scalar product in four partial sums, which the processor can compute in parallel.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a4.zip(b4) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Scale that makes the diagonal one; zero for undetermined unknowns.
fn scales(matrix: &DMatrix<f64>) -> DVector<f64> {
    let largest = matrix.diagonal().amax();
    matrix.diagonal().map(|d| if d > 1e-30 * largest { d.sqrt().recip() } else { 0.0 })
}

/// Condition number of columns scaled to equal length, from their normal matrix.
pub(crate) fn condition(matrix: &DMatrix<f64>) -> f64 {
    let scale = matrix.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let values = scaled.symmetric_eigenvalues();
    (values.max() / values.min().max(1e-300)).sqrt()
}

/// Solution of the normal equations; undetermined unknowns are zero.
#[must_use]
pub fn solve(matrix: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let scale = scales(matrix);
    let n = right.len();
    let scaled = DMatrix::from_fn(n, n, |i, j| {
        let ridge = if i == j { RIDGE + if scale[i] > 0.0 { 0.0 } else { 1.0 } } else { 0.0 };
        matrix[(i, j)] * scale[i] * scale[j] + ridge
    });
    let found =
        scaled.cholesky().map_or_else(|| DVector::zeros(n), |factor| factor.solve(&right.component_mul(&scale)));
    found.component_mul(&scale)
}

/// Inverse of a symmetric matrix, computed with the same scaling.
#[must_use]
pub fn inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let scale = scales(matrix);
    let n = scale.len();
    let scaled = DMatrix::from_fn(n, n, |i, j| {
        let ridge = if i == j { RIDGE + if scale[i] > 0.0 { 0.0 } else { RIDGE } } else { 0.0 };
        matrix[(i, j)] * scale[i] * scale[j] + ridge
    });
    let found = scaled.cholesky().map_or_else(|| DMatrix::identity(n, n), |factor| factor.inverse());
    DMatrix::from_fn(n, n, |i, j| {
        if scale[i] > 0.0 && scale[j] > 0.0 {
            found[(i, j)] * scale[i] * scale[j]
        } else if i == j {
            UNSEEN
        } else {
            0.0
        }
    })
}
