//! An audit of the identified mass matrix against the maker's, over all postures.
//!
//! A controller multiplies by the mass matrix `M(q)`, so an error of `M(q)` changes its effective gains. The audit searches for the posture in which
//! the identified `M` is nearest to singular. It also searches for the posture and direction in which `M` is lightest and heaviest relative to the
//! maker's `M_0`: the extreme eigenvalues of `M_0^-1 M`, which have no unit.

use crate::arm::Arm;
use crate::random::Random;
use dynamics_core::regressor::PARAMETERS;
use nalgebra::DMatrix;

/// Number of random postures.
const POSTURES: usize = 200;
/// Number of the best postures that are improved.
const IMPROVED: usize = 2;
/// First and last step of the improvement, as shares of the range.
const STEPS: (f64, f64) = (0.1, 4e-3);
/// Range of a joint without limits, rad or m.
const FREE: (f64, f64) = (-std::f64::consts::PI, std::f64::consts::PI);

/// An extreme value and its posture.
#[derive(Clone, Debug, PartialEq)]
pub struct Extreme {
    /// The value; its unit is that of the quantity searched.
    pub value: f64,
    /// Posture at which it was found, rad or m.
    pub q: Vec<f64>,
}

/// Extremes of the mass matrix over the postures within the limits. A search found them; they are not proven bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Audit {
    /// Smallest eigenvalue of the identified mass matrix, kg m^2 (kg for slides). Above zero in a physically possible arm.
    pub smallest: Extreme,
    /// Smallest eigenvalue of the maker's mass matrix, same units.
    pub smallest_before: Extreme,
    /// Least and greatest ratio of identified to maker's inertia over all postures and directions; `None` if the maker's matrix is singular.
    pub ratio: Option<(Extreme, Extreme)>,
}

/// Computes `M(q)` from all parameters of an arm: ten of each link, then the rotors.
#[must_use]
pub fn mass_matrix(arm: &dyn Arm, parameters: &[f64], q: &[f64]) -> DMatrix<f64> {
    let n = arm.joints();
    let width = PARAMETERS * n;
    let zero = vec![0.0; n];
    let mut out = vec![0.0; n * width];
    let mut torque = |qdd: &[f64]| -> Vec<f64> {
        arm.columns(q, &zero, qdd, &mut out);
        out.chunks_exact(width).map(|row| row.iter().zip(parameters).map(|(y, pi)| y * pi).sum()).collect()
    };
    let weight = torque(&zero);
    let mut matrix = DMatrix::zeros(n, n);
    for joint in 0..n {
        let mut unit = zero.clone();
        unit[joint] = 1.0;
        for (row, (with, without)) in torque(&unit).iter().zip(&weight).enumerate() {
            matrix[(row, joint)] = with - without;
        }
        matrix[(joint, joint)] += parameters[width + joint];
    }
    // The matrix is symmetric except for rounding.
    (&matrix + matrix.transpose()) * 0.5
}

/// Compares identified parameters with the maker's, within the position limits (rad or m).
#[must_use]
pub fn audit(arm: &dyn Arm, maker: &[f64], identified: &[f64], limits: &[(f64, f64)]) -> Audit {
    let range: Vec<(f64, f64)> = limits
        .iter()
        .map(|(lo, hi)| (if lo.is_finite() { *lo } else { FREE.0 }, if hi.is_finite() { *hi } else { FREE.1 }))
        .collect();
    let least = |parameters: &[f64], q: &[f64]| mass_matrix(arm, parameters, q).symmetric_eigenvalues().min();
    let beside = |q: &[f64]| -> Option<(f64, f64)> {
        let lower = mass_matrix(arm, maker, q).cholesky()?.l();
        let half = lower.solve_lower_triangular(&mass_matrix(arm, identified, q))?;
        let values = lower.solve_lower_triangular(&half.transpose())?.symmetric_eigenvalues();
        Some((values.min(), values.max()))
    };
    let smallest = lowest(&range, &|q| least(identified, q));
    let smallest_before = lowest(&range, &|q| least(maker, q));
    let ratio = (smallest_before.value > 0.0).then(|| {
        let low = lowest(&range, &|q| beside(q).map_or(f64::INFINITY, |(low, _)| low));
        let high = lowest(&range, &|q| beside(q).map_or(f64::INFINITY, |(_, high)| -high));
        (low, Extreme { value: -high.value, ..high })
    });
    Audit { smallest, smallest_before, ratio }
}

/// Lowest value of a function over postures: tries random ones, then improves the best of them one joint at a time.
fn lowest(range: &[(f64, f64)], value: &dyn Fn(&[f64]) -> f64) -> Extreme {
    let mut random = Random::new(3);
    let mut tried: Vec<Extreme> = (0..POSTURES)
        .map(|_| {
            let q: Vec<f64> = range.iter().map(|(lo, hi)| lo + random.share() * (hi - lo)).collect();
            Extreme { value: value(&q), q }
        })
        .collect();
    tried.sort_by(|a, b| a.value.total_cmp(&b.value));
    tried.truncate(IMPROVED);
    for best in &mut tried {
        let mut step = STEPS.0;
        while step > STEPS.1 {
            let before = best.value;
            for (joint, (lo, hi)) in range.iter().enumerate() {
                for sign in [-1.0, 1.0] {
                    let mut q = best.q.clone();
                    q[joint] = (q[joint] + sign * step * (hi - lo)).clamp(*lo, *hi);
                    let there = value(&q);
                    if there < best.value {
                        *best = Extreme { value: there, q };
                    }
                }
            }
            if best.value >= before {
                step *= 0.5;
            }
        }
    }
    tried.into_iter().min_by(|a, b| a.value.total_cmp(&b.value)).unwrap_or(Extreme { value: f64::NAN, q: Vec::new() })
}
