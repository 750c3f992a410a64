//! Delay between a joint's torque and its position, estimated from a log.
//!
//! A torque that is recorded late by `d` is `tau(t) = m(t - d)`, to first order `m - d m'` for the model's torque `m`. So `-m'` becomes one more
//! column in the joint's rows, and its coefficient estimates the remaining delay. This is a Gauss-Newton step: the torque is then shifted by the
//! estimate and the columns are computed again. The column comes from the model. The measured torque's noise would bias the estimate towards zero.

use crate::arm::Arm;
use crate::base::Base;
use crate::choose::EARNED;
use crate::correction::shifted;
use crate::filter::{derivative, spline};
use crate::fit::{Fit, FitProblem, Normal, Rows, inverse, solve};
use crate::friction::{Direction, FrictionLaw};
use crate::log::Log;
use crate::prepare::{Filters, Prepared};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Largest delay that is searched for, s.
const LONGEST: f64 = 0.25;
/// Largest change in one step, s: the linearisation holds for a fraction of the fastest motion's period.
const STEP: f64 = 0.04;
/// Number of Gauss-Newton steps.
const STEPS: usize = 8;
/// Change of a delay below which it has settled, s.
const SETTLED: f64 = 3e-4;
/// Prior standard deviation of a delay, s.
const EXPECTED: f64 = 0.1;

/// Rules for the direction of friction: the first ones estimate a delay, all of them judge it.
const DIRECTIONS: [Direction; 7] = [
    Direction::Hysteresis(1e-4),
    Direction::Smooth(2e-3),
    Direction::Smooth(2e-2),
    Direction::Smooth(8e-2),
    Direction::Hysteresis(1e-3),
    Direction::Hysteresis(5e-3),
    Direction::Hysteresis(2e-2),
];
const BY_LAW: usize = 3;
/// Relative reduction of the held-out error that a delay must achieve to be compensated. The first applies to a delay of all torques, in half of the
/// joints. The second applies to a delay of a single joint, in that joint. Friction that no law here describes achieves less.
const WORTH_A_DELAY: f64 = 0.1;
const WORTH_ONE_DELAY: f64 = 0.25;

/// A delay is compensated if it is larger than this many standard deviations.
const SURE: f64 = 4.0;
/// Delay that filters and friction can cause in the estimate, s. Smaller delays are ignored.
const OWN: f64 = 1e-3;

/// Delay of each joint's torque relative to its position, with standard deviations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Delays {
    /// Delay of each joint, s; negative if the position is late.
    pub value: Vec<f64>,
    /// Standard deviation of each delay, s.
    pub deviation: Vec<f64>,
}

impl Delays {
    /// Mean delay of all joints, weighted by their standard deviations, and its standard deviation, s.
    #[must_use]
    pub fn common(&self) -> (f64, f64) {
        let (mut sum, mut weight) = (0.0, 0.0);
        for (d, s) in self.value.iter().zip(&self.deviation) {
            let w = s.max(1e-6).powi(-2);
            sum += w * d;
            weight += w;
        }
        (sum / weight.max(1e-300), weight.max(1e-300).sqrt().recip())
    }

    /// Delays that are worth a try. The flag is true for a delay common to all joints. The common one comes first, then the delay of each joint that
    /// is significant.
    ///
    /// The positions of all joints may be late together, but not those of a single joint: such an estimate comes from friction.
    #[must_use]
    pub fn candidates(&self) -> Vec<(bool, Vec<f64>)> {
        let n = self.value.len();
        let mut found = Vec::new();
        let (common, sure) = self.common();
        if common.abs() > SURE * sure + OWN {
            found.push((true, vec![common; n]));
        }
        let own = |(d, s): (&f64, &f64)| if *d > SURE * s + OWN { *d } else { 0.0 };
        let own: Vec<f64> = self.value.iter().zip(&self.deviation).map(own).collect();
        if own.iter().any(|d| *d != 0.0) {
            found.push((false, own));
        }
        found
    }
}

/// Estimates the delays of the torques in prepared logs.
#[must_use]
pub fn delays(logs: &[Prepared], base: &Base, laws: &[FrictionLaw]) -> Delays {
    let problem = FitProblem { logs, base, laws };
    let loads: Vec<_> = logs.iter().map(|log| log.tau.clone()).collect();
    let rows = problem.rows(&loads);
    let n = base.joints;
    let unknowns = problem.unknowns();
    let mut found = Delays { value: vec![0.0; n], deviation: vec![EXPECTED; n] };
    let mut sigma: Vec<f64> = rows.iter().map(|rows| rows.deviation(&rows.target)).collect();
    let mut x = DVector::zeros(unknowns);
    for step in 0..STEPS {
        let mut more: Vec<Rows> = rows.clone();
        for (joint, rows) in more.iter_mut().enumerate() {
            rows.target = moved(logs, joint, found.value[joint], rows.target.len());
            if step > 0 {
                let slope = slope(logs, rows, &x);
                let width = rows.columns.ncols();
                rows.columns = std::mem::replace(&mut rows.columns, DMatrix::zeros(0, 0)).insert_column(width, 0.0);
                rows.columns.column_mut(width).copy_from(&slope);
                rows.places.push(unknowns + joint);
            }
        }
        let weights: Vec<Vec<f64>> = more
            .iter()
            .zip(&sigma)
            .map(|(rows, sigma)| {
                let left = if step == 0 { DVector::zeros(rows.target.len()) } else { rows.residual(&padded(&x, n)) };
                // Near its ends a log is continued by reflection, which is wrong for a shifted torque, so these samples get little weight.
                let count = left.len();
                let end = (count / 20).clamp(1, 8);
                let inside = |k: usize| if k < end || k + end >= count { 1e-6 } else { 1.0 };
                let weight = |(k, e): (usize, &f64)| inside(k) * (1.5 * sigma / e.abs().max(1e-12)).min(1.0);
                let weights = left.iter().enumerate().map(weight);
                weights.zip(rows.weights()).map(|(weight, moving)| weight * moving).collect()
            })
            .collect();
        let mut normal = Normal::of(&more, &sigma, &weights, |_| true, unknowns + n);
        for joint in 0..n {
            normal.matrix[(unknowns + joint, unknowns + joint)] += EXPECTED.powi(-2);
            // Keep the offset small.
            let at = problem.offset(joint);
            normal.matrix[(at, at)] += 1e-9 * normal.matrix[(at, at)];
        }
        let all = solve(&normal.matrix, &normal.right);
        x = all.rows(0, unknowns).into_owned();
        for (rows, sigma) in more.iter().zip(&mut sigma) {
            *sigma = rows.deviation(&rows.residual(&all));
        }
        if step > 0 {
            let mut change = 0.0_f64;
            for joint in 0..n {
                let next = found.value[joint] + all[unknowns + joint].clamp(-STEP, STEP);
                let next = next.clamp(-LONGEST, LONGEST);
                change = change.max((next - found.value[joint]).abs());
                found.value[joint] = next;
            }
            if change < SETTLED || step + 1 == STEPS {
                let covariance = inverse(&normal.matrix);
                for joint in 0..n {
                    let left = more[joint].moving_residual(&all);
                    let runs = more[joint].runs(left.as_slice());
                    let at = unknowns + joint;
                    found.deviation[joint] = (covariance[(at, at)].max(0.0) * runs).sqrt();
                }
            }
            if change < SETTLED {
                break;
            }
        }
    }
    found
}

fn padded(x: &DVector<f64>, more: usize) -> DVector<f64> {
    let mut all = DVector::zeros(x.len() + more);
    all.rows_mut(0, x.len()).copy_from(x);
    all
}

/// Torque of a joint at the rows' times, moved earlier by `delay`, s.
fn moved(logs: &[Prepared], joint: usize, delay: f64, count: usize) -> DVector<f64> {
    let mut all = Vec::with_capacity(count);
    for log in logs {
        let (Some(first), Some(last)) = (log.time.first(), log.time.last()) else { continue };
        let at: Vec<f64> =
            (0..log.len()).step_by(log.row_step()).map(|k| (log.time[k] + delay).clamp(*first, *last)).collect();
        all.extend(spline(&log.time, &log.tau[joint], &at));
    }
    DVector::from_vec(all)
}

/// Time derivative of the torque that a fit predicts for one joint, at its rows, N m/s or N/s: the error per second of delay.
pub(crate) fn torque_slope(logs: &[Prepared], fit: &Fit, joint: usize) -> DVector<f64> {
    -slope(logs, &fit.rows[joint], &fit.x)
}

/// Minus the time derivative of the model's torque at the rows' times, N m/s or N/s.
fn slope(logs: &[Prepared], rows: &Rows, x: &DVector<f64>) -> DVector<f64> {
    let model = &rows.target - rows.residual(&padded(x, 0));
    let mut slope = Vec::with_capacity(model.len());
    let mut start = 0;
    for log in logs {
        let step = log.row_step();
        let count = log.len().div_ceil(step);
        let part = &model.as_slice()[start..start + count];
        slope.extend(derivative(part, log.rate / step as f64).iter().map(|x| -x));
        start += count;
    }
    DVector::from_vec(slope)
}

/// Returns the delays that lower the held-out error, and those that the logs show, s.
///
/// Friction that reverses in another way than its law looks like a delay. So delays are estimated with each direction rule, and each joint is judged
/// with the rule that suits it, with and without its delay.
pub(crate) fn best_delay(arm: &dyn Arm, base: &Base, logs: &[Log], torque: f64) -> (Vec<f64>, Delays) {
    let n = base.joints;
    let prepare = |delay: &[f64]| -> Vec<Prepared> {
        let filters = Filters { motion: torque, torque };
        logs.iter().map(|log| Prepared::new(&shifted(log, delay), arm, base, filters)).collect()
    };
    let laws = DIRECTIONS.map(|direction| vec![FrictionLaw::with(direction, &[]); n]);
    let judge_by = |count: usize, logs: &[Prepared]| -> Vec<Vec<f64>> {
        laws[..count].par_iter().map(|laws| FitProblem { logs, base, laws }.fit().held_out()).collect()
    };
    let judge = |logs: &[Prepared]| judge_by(laws.len(), logs);
    let least = |errors: &[Vec<f64>]| -> Vec<(usize, f64)> {
        let of = |joint: usize| errors.iter().map(|e| e[joint]).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        (0..n).map(|joint| of(joint).unwrap_or((0, f64::MAX))).collect()
    };
    let mean = |errors: &[(usize, f64)]| errors.iter().map(|(_, e)| e.max(1e-12).ln()).sum::<f64>() / n.max(1) as f64;
    let prepared = prepare(&vec![0.0; n]);
    let by_law: Vec<Delays> = laws[..BY_LAW].par_iter().map(|laws| delays(&prepared, base, laws)).collect();
    let any = by_law.iter().any(|delays| !delays.candidates().is_empty());
    let now = least(&judge_by(if any { laws.len() } else { BY_LAW }, &prepared));
    let chosen = |pick: &[(usize, f64)]| {
        let of = |joint: usize| if pick[joint].0 < BY_LAW { pick[joint].0 } else { 0 };
        Delays {
            value: (0..n).map(|joint| by_law[of(joint)].value[joint]).collect(),
            deviation: (0..n).map(|joint| by_law[of(joint)].deviation[joint]).collect(),
        }
    };
    let (mut best, mut error, mut seen) = (vec![0.0; n], mean(&now), chosen(&now));
    for delays in &by_law {
        for (is_common, mut candidate) in delays.candidates() {
            let mut there = least(&judge(&prepare(&candidate)));
            let lower = |there: &[(usize, f64)], joint: usize, by: f64| there[joint].1 < (1.0 - by) * now[joint].1;
            if is_common {
                if 2 * (0..n).filter(|joint| lower(&there, *joint, WORTH_A_DELAY)).count() < n {
                    continue;
                }
            } else {
                let worth: Vec<bool> = (0..n).map(|joint| lower(&there, joint, WORTH_ONE_DELAY)).collect();
                if !worth.contains(&true) {
                    continue;
                }
                if candidate.iter().zip(&worth).any(|(d, worth)| *d != 0.0 && !worth) {
                    candidate.iter_mut().zip(&worth).filter(|(_, worth)| !**worth).for_each(|(d, _)| *d = 0.0);
                    there = least(&judge(&prepare(&candidate)));
                }
            }
            if mean(&there) < error + (1.0 - EARNED).ln() {
                (best, error, seen) = (candidate, mean(&there), chosen(&there));
            }
        }
    }
    (best, seen)
}
