//! Identification in order, and predictions.

use crate::Series;
use crate::arm::Arm;
use crate::base::Base;
use crate::choose::{self, Tried};
use crate::clock;
use crate::consistent::{Consistent, Maker, nearest};
use crate::correction::shifted;
use crate::delay::{Delays, delays, torque_slope};
use crate::fit::{Fit, Normal, Problem, inverse, solve};
use crate::friction::{Direction, Law, Term};
use crate::log::Log;
use crate::prepare::{Filters, Prepared};
use dynamics_core::regressor::PARAMETERS;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

/// Cut-off of the filter of torques, Hz, where the log is fast enough.
pub const TORQUE_CUTOFF: f64 = 8.0;
/// Cut-offs of motions that are tried, in cut-offs of torques.
const MOTION_CUTOFFS: [f64; 6] = [0.6, 1.0, 1.5, 2.5, 5.0, 8.0];

/// Ways of telling the direction of friction: of arms with real gears, and of arms whose friction creeps, as a simulated one's.
const DIRECTIONS: [Direction; 2] = [Direction::Hysteresis(1e-4), Direction::Smooth(2e-3)];

/// The same where a delay is looked for: the first ones to estimate it, all of them to judge it.
const DELAY_DIRECTIONS: [Direction; 7] = [
    Direction::Hysteresis(1e-4),
    Direction::Smooth(2e-3),
    Direction::Smooth(2e-2),
    Direction::Smooth(8e-2),
    Direction::Hysteresis(1e-3),
    Direction::Hysteresis(5e-3),
    Direction::Hysteresis(2e-2),
];
const BY_LAW: usize = 3;
/// Share by which a delay must lower the held-out error to be compensated: one of all torques, in half of the joints, and one of a
/// single joint, in that joint. Friction of a shape that no law here has takes less.
const WORTH_A_DELAY: f64 = 0.1;
const WORTH_ONE_DELAY: f64 = 0.25;

/// States over which a joint's torque is called known or open.
const STATES: usize = 60;

/// Settings that may be chosen by hand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Cut-off of the filter of torques, Hz.
    pub torque_cutoff: Option<f64>,
    /// Cut-off of the filter of motions, Hz.
    pub motion_cutoff: Option<f64>,
    /// Offset, viscous and Coulomb friction only.
    pub plain_friction: bool,
    /// Take the torques as they are in time: no delay is looked for.
    pub keep_delay: bool,
}

/// The model of an arm.
#[derive(Clone, Debug)]
pub struct Identified {
    /// The base parameters.
    pub base: Base,
    /// The filters that were chosen.
    pub filters: Filters,
    /// Held-out error of the motion cut-offs that were tried: Hz, and the geometric mean over the joints, N m.
    pub cutoffs: Vec<(f64, f64)>,
    /// The law of friction of each joint.
    pub laws: Vec<Law>,
    /// Its coefficients.
    pub friction: Vec<Vec<f64>>,
    /// Their standard deviations.
    pub friction_deviations: Vec<Vec<f64>>,
    /// Candidates that were tried.
    pub tried: Vec<Tried>,
    /// Least squares: base parameters before they were made those of possible bodies.
    pub free: DVector<f64>,
    /// Covariance of these.
    pub covariance: DMatrix<f64>,
    /// Possible bodies.
    pub bodies: Consistent,
    /// Residual of each joint on the logs, N m or N: robust deviation.
    pub sigma: Vec<f64>,
    /// Condition number of the weighted columns of the base parameters, each of one length.
    pub condition: f64,
    /// Delay of each joint's torque that is compensated, s.
    pub delay: Vec<f64>,
    /// The delays that the logs show.
    pub delays: Delays,
    /// Root mean square jitter of the time stamps that an even clock has replaced, s: the largest of the logs.
    pub jitter: f64,
    /// Held-out error of each joint, N m or N.
    pub held_out: Vec<f64>,
    /// Share of each joint's variance left over that rows a quarter of a second before explain: near 1, it is no noise.
    pub persistence: Vec<f64>,
}

/// Measured and predicted torque behind the same filter.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// s.
    pub time: Vec<f64>,
    /// Measured, N m or N.
    pub measured: Series,
    /// By the identified model.
    pub model: Series,
    /// Velocity of each joint behind its filter.
    pub qd: Series,
    /// Samples of each joint in which friction holds it: no model tells its torque there.
    pub held: Vec<Vec<bool>>,
}

/// Identify an arm from logs.
#[must_use]
pub fn identify(arm: &dyn Arm, maker: &Maker, logs: &[Log], settings: &Settings) -> Identified {
    let base = Base::of(arm);
    let jitter = logs.iter().map(clock::jitter).fold(0.0, f64::max);
    let logs: Vec<Log> = logs.iter().map(clock::repaired).collect();
    let rate = logs.iter().map(Log::rate).fold(f64::MAX, f64::min);
    let torque = settings.torque_cutoff.unwrap_or(TORQUE_CUTOFF).min(0.2 * rate);
    let (delay, delays) = if settings.keep_delay {
        (vec![0.0; base.joints], Delays::default())
    } else {
        best_delay(arm, &base, &logs, torque)
    };
    let logs: Vec<Log> = logs.iter().map(|log| shifted(log, &delay)).collect();
    let prepare = |motion: f64| -> Vec<Prepared> {
        logs.iter().map(|log| Prepared::new(log, arm, &base, Filters { motion, torque })).collect()
    };
    let (motion, cutoffs, prepared) = match settings.motion_cutoff {
        Some(motion) => (motion, Vec::new(), prepare(motion)),
        None => best_cutoff(&base, torque, rate, &prepare),
    };
    let (laws, tried) = if settings.plain_friction {
        (vec![Law::with(Direction::Hysteresis(1e-4), &[]); base.joints], Vec::new())
    } else {
        choose::laws(&prepared, &base)
    };
    let problem = Problem { logs: &prepared, base: &base, laws: &laws };
    let fit = problem.fit();
    let mut whole = fit.covariance();
    add_delay(&mut whole, &prepared, &fit, &delay, &delays);
    add_position_noise(&mut whole, arm, &problem, &fit, &logs, Filters { motion, torque });
    let b = base.len();
    let covariance = whole.view((0, 0), (b, b)).into_owned();
    let free = fit.x.rows(0, b).into_owned();
    let bodies = nearest(&base, maker, &free, &covariance);
    let friction = friction_beside(&problem, &fit, &bodies.beta);
    let deviation = |joint: usize, k: usize| {
        let at = problem.offset(joint) + k;
        whole[(at, at)].max(0.0).sqrt()
    };
    let friction_deviations = laws
        .iter()
        .enumerate()
        .map(|(joint, law)| (0..law.terms.len()).map(|k| deviation(joint, k)).collect())
        .collect();
    let condition = condition(&fit.normal.matrix.view((0, 0), (b, b)).into_owned());
    Identified {
        filters: Filters { motion, torque },
        cutoffs,
        friction,
        friction_deviations,
        tried,
        free,
        covariance,
        bodies,
        held_out: fit.held_out(),
        persistence: fit.persistence(),
        sigma: fit.sigma,
        condition,
        delay,
        delays,
        jitter,
        laws,
        base,
    }
}

/// The delays that lower the held-out error, and those that the logs show.
///
/// Friction that turns over otherwise than its law says looks like a delay. So delays are estimated by each way of telling the direction,
/// and each joint is judged by the one that suits it, with and without its delay.
fn best_delay(arm: &dyn Arm, base: &Base, logs: &[Log], torque: f64) -> (Vec<f64>, Delays) {
    let n = base.joints;
    let prepare = |delay: &[f64]| -> Vec<Prepared> {
        let filters = Filters { motion: torque, torque };
        logs.iter().map(|log| Prepared::new(&shifted(log, delay), arm, base, filters)).collect()
    };
    let laws = DELAY_DIRECTIONS.map(|direction| vec![Law::with(direction, &[]); n]);
    let judge_by = |count: usize, logs: &[Prepared]| -> Vec<Vec<f64>> {
        laws[..count].par_iter().map(|laws| Problem { logs, base, laws }.fit().held_out()).collect()
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
            if mean(&there) < error + (1.0 - choose::EARNED).ln() {
                (best, error, seen) = (candidate, mean(&there), chosen(&there));
            }
        }
    }
    (best, seen)
}

/// Adds what an error of the delays does to the unknowns: what is left of them, or all of one that is not compensated.
fn add_delay(covariance: &mut DMatrix<f64>, logs: &[Prepared], fit: &Fit, delay: &[f64], delays: &Delays) {
    for (joint, applied) in delay.iter().enumerate() {
        let (Some(value), Some(deviation)) = (delays.value.get(joint), delays.deviation.get(joint)) else { continue };
        let left = if (value - applied).abs() < 3.0 * deviation { 0.0 } else { value - applied };
        let change = fit.change(joint, &torque_slope(logs, fit, joint)) * deviation.hypot(left);
        *covariance += &change * change.transpose();
    }
}

/// Adds what noise of the positions does to the unknowns. Noise in a column makes its coefficient too small, and no residual shows it:
/// a second fit with as much noise again moves as far as the first one has.
fn add_position_noise(
    covariance: &mut DMatrix<f64>,
    arm: &dyn Arm,
    problem: &Problem<'_>,
    fit: &Fit,
    logs: &[Log],
    filters: Filters,
) {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut share = || (f64::from(random.next_u32()) + 0.5) / (f64::from(u32::MAX) + 1.0);
    let mut normal = || (-2.0 * share().ln()).sqrt() * (std::f64::consts::TAU * share()).cos();
    let noisier: Vec<Prepared> = logs
        .iter()
        .map(|log| {
            let noise = |q: &Vec<f64>| -> Vec<f64> {
                let size = position_noise(q);
                q.iter().map(|q| q + size * normal()).collect()
            };
            let q = log.q.iter().map(noise).collect();
            Prepared::new(&Log { q, ..log.clone() }, arm, problem.base, filters)
        })
        .collect();
    let moved = Problem { logs: &noisier, ..*problem }.fit().x - &fit.x;
    *covariance += &moved * moved.transpose();
}

/// Standard deviation of the noise of a position, from third differences, which leave little of a motion.
fn position_noise(q: &[f64]) -> f64 {
    let third: f64 = q.windows(4).map(|q| (q[3] - 3.0 * q[2] + 3.0 * q[1] - q[0]).powi(2)).sum();
    (third / (20 * q.len().max(1)) as f64).sqrt()
}

/// The cut-off of motions with the least held-out error of torques behind their own filter, which stays the same.
fn best_cutoff(
    base: &Base,
    torque: f64,
    rate: f64,
    prepare: &dyn Fn(f64) -> Vec<Prepared>,
) -> (f64, Vec<(f64, f64)>, Vec<Prepared>) {
    // Each joint counts with the direction that suits it.
    let mut tried = Vec::new();
    let mut best: Option<(f64, f64, Vec<Prepared>)> = None;
    for motion in MOTION_CUTOFFS.map(|share| share * torque).into_iter().filter(|f| *f < 0.4 * rate) {
        let logs = prepare(motion);
        let judge = |direction| {
            let laws = vec![Law::with(direction, &[Term::Load, Term::Root]); base.joints];
            Problem { logs: &logs, base, laws: &laws }.fit().held_out()
        };
        let (one, other) = rayon::join(|| judge(DIRECTIONS[0]), || judge(DIRECTIONS[1]));
        let errors: Vec<f64> = one.iter().zip(&other).map(|(a, b)| a.min(*b)).collect();
        let mean = (errors.iter().map(|e| e.max(1e-12).ln()).sum::<f64>() / errors.len() as f64).exp();
        tried.push((motion, mean));
        if best.as_ref().is_none_or(|(_, least, _)| mean < *least) {
            best = Some((motion, mean, logs));
        }
    }
    best.map_or_else(|| (torque, Vec::new(), prepare(torque)), |(motion, _, logs)| (motion, tried, logs))
}

/// Coefficients of friction for these base parameters.
fn friction_beside(problem: &Problem<'_>, fit: &Fit, beta: &DVector<f64>) -> Vec<Vec<f64>> {
    let loads: Vec<Series> = problem.logs.iter().map(|log| log.of_bodies(beta.as_slice())).collect();
    let rows = problem.rows(&loads);
    let normal = Normal::of(&rows, &fit.sigma, &fit.weights, |_| true, problem.unknowns());
    let b = beta.len();
    let more = problem.unknowns() - b;
    let right = normal.right.rows(b, more) - normal.matrix.view((b, 0), (more, b)) * beta;
    let found = solve(&normal.matrix.view((b, b), (more, more)).into_owned(), &right);
    let of = |(joint, law): (usize, &Law)| {
        let at = problem.offset(joint) - b;
        found.as_slice()[at..at + law.terms.len()].to_vec()
    };
    problem.laws.iter().enumerate().map(of).collect()
}

/// Ratio of the largest and the least singular value of columns of one length, from their normal matrix.
fn condition(matrix: &DMatrix<f64>) -> f64 {
    let scale = matrix.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let values = scaled.symmetric_eigenvalues();
    (values.max() / values.min().max(1e-300)).sqrt()
}

impl Identified {
    /// The log by an even clock if its stamps jitter, and without the delay of its torques.
    #[must_use]
    pub fn in_time(&self, log: &Log) -> Log {
        shifted(&clock::repaired(log), &self.delay)
    }

    /// Torque along a log, measured and predicted, behind the filters of the identification.
    #[must_use]
    pub fn predict(&self, arm: &dyn Arm, log: &Log) -> Prediction {
        let prepared = Prepared::new(&self.in_time(log), arm, &self.base, self.filters);
        let loads = prepared.of_bodies(self.bodies.beta.as_slice());
        let problem = Problem { logs: std::slice::from_ref(&prepared), base: &self.base, laws: &self.laws };
        let mut model = loads.clone();
        for ((model, columns), coefficients) in
            model.iter_mut().zip(problem.friction(&prepared, &loads)).zip(&self.friction)
        {
            for (column, c) in columns.iter().zip(coefficients) {
                model.iter_mut().zip(column).for_each(|(sum, x)| *sum += c * x);
            }
        }
        Prediction { time: prepared.time, measured: prepared.tau, model, qd: prepared.qd, held: prepared.held }
    }

    /// Torque along a log by other parameters and a law `friction(joint, qd, load)` of one's own, N m or N: what a robot file says. The
    /// load is the torque of the bodies.
    #[must_use]
    pub fn predict_by(
        &self,
        arm: &dyn Arm,
        log: &Log,
        parameters: &[f64],
        friction: &dyn Fn(usize, f64, f64) -> f64,
    ) -> Series {
        let prepared = Prepared::new(&self.in_time(log), arm, &self.base, self.filters);
        let mut model = prepared.of_bodies(self.base.of_parameters(parameters).as_slice());
        for (joint, model) in model.iter_mut().enumerate() {
            let rub: Vec<f64> =
                prepared.qd[joint].iter().zip(&*model).map(|(qd, load)| friction(joint, *qd, *load)).collect();
            model.iter_mut().zip(prepared.low_pass.apply(&rub)).for_each(|(sum, x)| *sum += x);
        }
        model
    }

    /// Share of the maker's uncertainty about each joint's torque that is left, over states all around: 1 if the logs say nothing of it.
    #[must_use]
    pub fn open(&self, arm: &dyn Arm) -> Vec<f64> {
        let (n, width) = (self.base.joints, PARAMETERS * self.base.joints);
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut draw = |size: f64| -> Vec<f64> {
            (0..n).map(|_| size * (2.0 * f64::from(random.next_u32()) / f64::from(u32::MAX) - 1.0)).collect()
        };
        let mut out = vec![0.0; n * width];
        let mut sums = vec![(0.0, 0.0); n];
        for _ in 0..STATES {
            let (q, qd, qdd) = (draw(3.0), draw(1.5), draw(3.0));
            arm.columns(&q, &qd, &qdd, &mut out);
            for (joint, (after, before)) in sums.iter_mut().enumerate() {
                let row = DVector::from_iterator(
                    self.base.len(),
                    self.base.columns.iter().map(|k| match k.checked_sub(width) {
                        Some(rotor) if rotor == joint => qdd[joint],
                        Some(_) => 0.0,
                        None => out[joint * width + k],
                    }),
                );
                *after += row.dot(&(&self.bodies.beta_covariance * &row));
                *before += row.dot(&(&self.bodies.beta_before * &row));
            }
        }
        sums.iter().map(|(after, before)| (after / before.max(1e-300)).max(0.0).sqrt()).collect()
    }

    /// `(b - R pi)^T C^-1 (b - R pi)`: how far the possible bodies are from least squares, in deviations squared.
    #[must_use]
    pub fn distance(&self) -> f64 {
        let off = &self.free - &self.bodies.beta;
        off.dot(&(inverse(&self.covariance) * &off))
    }
}

impl Prediction {
    /// Measured torque that a model leaves, N m or N; 0 where friction holds a joint.
    #[must_use]
    pub fn left(&self, model: &Series) -> Series {
        self.moving(&difference(&self.measured, model))
    }

    /// A series of torques without those of held joints: 0 in their place.
    #[must_use]
    pub fn moving(&self, series: &Series) -> Series {
        let of = |(x, held): (&Vec<f64>, &Vec<bool>)| {
            x.iter().zip(held).map(|(x, held)| if *held { 0.0 } else { *x }).collect()
        };
        series.iter().zip(&self.held).map(of).collect()
    }

    /// Share of the samples in which friction holds each joint.
    #[must_use]
    pub fn held_share(&self) -> Vec<f64> {
        let of = |held: &Vec<bool>| held.iter().filter(|held| **held).count() as f64 / held.len().max(1) as f64;
        self.held.iter().map(of).collect()
    }
}

/// Root mean square of each joint.
#[must_use]
pub fn rms(series: &Series) -> Vec<f64> {
    series.iter().map(|x| (x.iter().map(|x| x * x).sum::<f64>() / x.len().max(1) as f64).sqrt()).collect()
}

/// Difference of two series.
#[must_use]
pub fn difference(a: &Series, b: &Series) -> Series {
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b).collect()).collect()
}
