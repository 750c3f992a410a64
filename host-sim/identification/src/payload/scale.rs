//! The scale of measured torques.

use super::Known;
use crate::arm::Arm;
use crate::base::Base;
use crate::consistent::Maker;
use dynamics_core::regressor::PARAMETERS;
use nalgebra::{DMatrix, DVector};

/// Uncertainty of the maker's masses (relative) and centres of mass (m) when they judge the scale of torques.
const MAKER: (f64, f64) = (0.2, 0.05);
/// Range in which the scale is searched.
const SCALES: (f64, f64) = (0.7, 1.4);

/// Estimates measured over true torque and its standard deviation, from the maker's masses. `deviation` is the relative standard deviation of the
/// torque constant.
///
/// With `s` the scale, gravity's base parameters are `g ~ N(s g_maker, C + s^2 S)`, where `S` assumes masses known to 20 % and centres of mass to 5
/// cm, and `s ~ N(1, deviation)`. Returns the posterior mean and standard deviation of `s`.
#[must_use]
pub fn torque_scale(arm: &dyn Arm, known: &Known, maker: &Maker, deviation: f64) -> (f64, f64) {
    let directions = gravity_directions(arm, &known.base);
    let n = known.base.joints;
    let mut parameters = vec![0.0; known.base.regroup.ncols()];
    for (place, (own, fixed)) in
        parameters.iter_mut().zip(maker.links.iter().flatten().zip(maker.fixed.iter().flatten()))
    {
        *place = own + fixed;
    }
    let total: f64 = maker.links.iter().map(|link| link[0]).sum();
    let mut spread = DMatrix::zeros(parameters.len(), parameters.len());
    for link in 0..n {
        let at = PARAMETERS * link;
        let mass = maker.links[link][0].max(0.02 * total);
        let centre = |k: usize| if k == 0 { 1.0 } else { maker.links[link][k] / maker.links[link][0].max(1e-9) };
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            spread[(at + i, at + j)] = (MAKER.0 * mass).powi(2) * centre(i) * centre(j);
            if i == j && i > 0 {
                spread[(at + i, at + j)] += (MAKER.1 * mass).powi(2);
            }
        }
    }
    let through = directions.transpose() * &known.base.regroup;
    let made = &through * DVector::from_vec(parameters);
    let of_maker = &through * spread * through.transpose();
    let (found, of_data) = (directions.tr_mul(&known.beta), directions.transpose() * &known.covariance * &directions);
    let cost = |s: f64| {
        let c = &of_data + &of_maker * (s * s);
        let off = &found - &made * s;
        c.cholesky().map_or(f64::INFINITY, |factor| {
            let determinant: f64 = factor.l_dirty().diagonal().iter().map(|d| 2.0 * d.ln()).sum();
            off.dot(&factor.solve(&off)) + determinant + ((s - 1.0) / deviation).powi(2)
        })
    };
    let step = 0.0025;
    let count = ((SCALES.1 - SCALES.0) / step) as usize;
    let costs: Vec<(f64, f64)> = (0..=count).map(|k| SCALES.0 + k as f64 * step).map(|s| (s, cost(s))).collect();
    let least = costs.iter().map(|(_, c)| *c).fold(f64::INFINITY, f64::min);
    let moment = |power: i32, about: f64| {
        costs.iter().map(|(s, c)| (s - about).powi(power) * (-0.5 * (c - least)).exp()).sum::<f64>()
    };
    let mean = moment(1, 0.0) / moment(0, 0.0);
    (mean, (moment(2, mean) / moment(0, 0.0)).sqrt())
}

/// Directions among the base parameters on which gravity torques depend.
fn gravity_directions(arm: &dyn Arm, base: &Base) -> DMatrix<f64> {
    let n = base.joints;
    let zero = vec![0.0; n];
    let mut gram = DMatrix::zeros(base.len(), base.len());
    for state in 0..200 {
        let q: Vec<f64> =
            (0..n).map(|joint| 3.0 * (f64::from(state) * (1.0 + 0.37 * joint as f64) + joint as f64).sin()).collect();
        for row in base.rows(arm, [&q, &zero, &zero]) {
            gram += &row * row.transpose();
        }
    }
    let eigen = gram.symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    let kept: Vec<usize> = (0..base.len()).filter(|k| eigen.eigenvalues[*k] > 1e-9 * largest).collect();
    eigen.eigenvectors.select_columns(&kept)
}
