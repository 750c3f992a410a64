//! The combinations of inertial parameters that torques depend on.

use crate::arm::{Arm, parameter_count, parameter_name};
use crate::random::Random;
use dynamics_core::regressor::PARAMETERS;
use nalgebra::{DMatrix, DVector};

/// Number of random states from which the combinations are found. Each gives one row per joint.
const STATES: usize = 60;
/// A column is independent if, after projection onto the columns before it, at least this share of its length is left.
const INDEPENDENT: f64 = 1e-8;
/// Coefficients of a combination below this are rounding errors and count as zero.
const NOTHING: f64 = 1e-9;

/// Base parameters: the smallest set of numbers that determines the torque of every motion.
///
/// `tau = Y pi = Y_b beta` with `beta = R pi`, where `Y_b` are the columns of [`Base::columns`].
#[derive(Clone, Debug)]
pub struct Base {
    /// Number of joints.
    pub joints: usize,
    /// The parameters whose columns are kept, one for each base parameter.
    pub columns: Vec<usize>,
    /// `R`, base parameters by parameters.
    pub regroup: DMatrix<f64>,
    /// Singular values on both sides of the rank, over the largest: the last that counts and the first that does not. Columns are scaled to equal
    /// length.
    pub gap: (f64, f64),
}

impl Base {
    /// Finds the base parameters numerically, from torques at random states.
    ///
    /// Columns are tried in an order that gives the usual names: within a link `Iyy`, `mz` and `m` come last, and rotors come at the very end. A
    /// column is kept if a part of it remains after projection onto the kept columns.
    #[must_use]
    pub fn of(arm: &dyn Arm) -> Self {
        let n = arm.joints();
        let total = parameter_count(n);
        let stack = random_rows(arm);
        let norms: Vec<f64> = stack.column_iter().map(|column| column.norm()).collect();
        let largest = norms.iter().fold(0.0_f64, |a, b| a.max(*b));
        let scale = |k: usize| if norms[k] > INDEPENDENT * largest { norms[k].recip() } else { 0.0 };
        let scaled = DMatrix::from_fn(stack.nrows(), total, |row, k| stack[(row, k)] * scale(k));

        let (mut columns, mut directions): (Vec<usize>, Vec<DVector<f64>>) = (Vec::new(), Vec::new());
        for k in preferred(n) {
            let mut rest = scaled.column(k).into_owned();
            // Project twice, which reduces rounding errors.
            for direction in directions.iter().chain(&directions) {
                let along = direction.dot(&rest);
                rest.axpy(-along, direction, 1.0);
            }
            let left = rest.norm();
            if left > INDEPENDENT {
                directions.push(rest / left);
                columns.push(k);
            }
        }
        // Sort by link again, for readable reports.
        columns.sort_unstable();
        let kept = scaled.select_columns(&columns);
        let gram = kept.tr_mul(&kept);
        let right = kept.tr_mul(&scaled);
        let mut regroup =
            gram.cholesky().map_or_else(|| DMatrix::zeros(columns.len(), total), |factor| factor.solve(&right));
        for (b, k) in (0..columns.len()).flat_map(|b| (0..total).map(move |k| (b, k))) {
            // Undo the scaling: parameter k contributes this much to base parameter b.
            let value = regroup[(b, k)] * if scale(k) > 0.0 { scale(columns[b]) / scale(k) } else { 0.0 };
            let near = value.round();
            let snapped = if (value - near).abs() < NOTHING { near } else { value };
            regroup[(b, k)] = if columns.contains(&k) { f64::from(u8::from(columns[b] == k)) } else { snapped };
        }
        let gap = gap(&scaled, columns.len());
        Self { joints: n, columns, regroup, gap }
    }

    /// Number of base parameters.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// True if no parameter has an effect.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Expression of a base parameter in standard parameters, for example `Ixx2 - Iyy2 + 0.43 m3`.
    #[must_use]
    pub fn name(&self, index: usize) -> String {
        let row = self.regroup.row(index);
        let own = parameter_name(self.columns[index], self.joints);
        let others = row.iter().enumerate().filter(|(k, c)| *k != self.columns[index] && **c != 0.0);
        others.fold(own, |text, (k, c)| {
            let sign = if *c < 0.0 { '-' } else { '+' };
            let size = c.abs();
            let factor = if (size - 1.0).abs() < NOTHING { String::new() } else { format!("{size:.4} ") };
            format!("{text} {sign} {factor}{}", parameter_name(k, self.joints))
        })
    }

    /// The link (or the rotor's joint), counted from 0, of a base parameter's own column.
    #[must_use]
    pub fn link(&self, index: usize) -> usize {
        let k = self.columns[index];
        k.checked_sub(PARAMETERS * self.joints).unwrap_or(k / PARAMETERS)
    }

    /// True if a base parameter can affect the torque of a joint.
    #[must_use]
    pub fn acts(&self, index: usize, joint: usize) -> bool {
        let rotor = self.columns[index] >= PARAMETERS * self.joints;
        if rotor { self.link(index) == joint } else { self.link(index) >= joint }
    }

    /// `beta = R pi`.
    #[must_use]
    pub fn of_parameters(&self, parameters: &[f64]) -> DVector<f64> {
        &self.regroup * DVector::from_column_slice(parameters)
    }

    /// `Y_b` in one state: a row for each joint, in the units of [`Arm::columns`].
    #[must_use]
    pub fn rows(&self, arm: &dyn Arm, [q, qd, qdd]: [&[f64]; 3]) -> Vec<DVector<f64>> {
        let width = PARAMETERS * self.joints;
        let mut out = vec![0.0; self.joints * width];
        arm.columns(q, qd, qdd, &mut out);
        let row = |joint: usize| {
            let column = |k: &usize| match k.checked_sub(width) {
                Some(rotor) if rotor == joint => qdd[joint],
                Some(_) => 0.0,
                None => out[joint * width + k],
            };
            DVector::from_iterator(self.len(), self.columns.iter().map(column))
        };
        (0..self.joints).map(row).collect()
    }
}

/// Columns of parameters in the order in which they are kept.
fn preferred(joints: usize) -> Vec<usize> {
    const FIRST: [usize; 7] = [4, 5, 6, 8, 9, 1, 2];
    const THEN: [usize; 3] = [7, 3, 0];
    let of_links =
        |which: &'static [usize]| (0..joints).flat_map(move |link| which.iter().map(move |k| PARAMETERS * link + k));
    of_links(&FIRST).chain(of_links(&THEN)).chain(PARAMETERS * joints..parameter_count(joints)).collect()
}

/// The regressor at random states: a row for each state and joint, a column for each parameter.
fn random_rows(arm: &dyn Arm) -> DMatrix<f64> {
    let n = arm.joints();
    let mut random = Random::new(16);
    let mut out = vec![0.0; n * PARAMETERS * n];
    let mut stack = DMatrix::zeros(STATES * n, parameter_count(n));
    for state in 0..STATES {
        let [q, qd, qdd] = [3.0, 2.0, 5.0].map(|size| random.list(n, size));
        arm.columns(&q, &qd, &qdd, &mut out);
        for i in 0..n {
            for k in 0..PARAMETERS * n {
                stack[(state * n + i, k)] = out[i * PARAMETERS * n + k];
            }
            stack[(state * n + i, PARAMETERS * n + i)] = qdd[i];
        }
    }
    stack
}

/// Singular values on both sides of the rank, over the largest.
fn gap(scaled: &DMatrix<f64>, rank: usize) -> (f64, f64) {
    let values = scaled.clone().qr().r().singular_values();
    let mut values: Vec<f64> = values.iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    let largest = values.first().copied().unwrap_or(1.0);
    let at = |k: usize| values.get(k).map_or(0.0, |x| x / largest);
    (at(rank.saturating_sub(1)), at(rank))
}
