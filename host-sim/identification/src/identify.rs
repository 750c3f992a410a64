//! The identification procedure, from logs to a model.

use crate::Series;
use crate::arm::Arm;
use crate::base::Base;
use crate::choose::{self, Tried};
use crate::clock::repaired;
use crate::consistent::{Consistent, Maker, nearest};
use crate::correction::shifted;
use crate::delay::{Delays, best_delay, torque_slope};
use crate::fit::{Fit, FitProblem, Normal, condition, inverse, solve};
use crate::friction::{Direction, FrictionLaw, Term};
use crate::log::Log;
use crate::prepare::{Filters, Prepared};
use crate::random::Random;
use nalgebra::{DMatrix, DVector};

/// Default cut-off of the torque filter if the log is fast enough, Hz.
pub const TORQUE_CUTOFF: f64 = 8.0;
/// Motion cut-offs that are tried, as multiples of the torque cut-off.
const MOTION_CUTOFFS: [f64; 6] = [0.6, 1.0, 1.5, 2.5, 5.0, 8.0];

/// Direction rules of friction: for arms with real gears, and for arms whose friction creeps, such as simulated ones.
const DIRECTIONS: [Direction; 2] = [Direction::Hysteresis(1e-4), Direction::Smooth(2e-3)];

/// Number of random states over which the remaining uncertainty of a joint's torque is evaluated.
const STATES: usize = 60;

/// Settings that the user may override.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Cut-off of the torque filter, Hz; chosen automatically if `None`.
    pub torque_cutoff: Option<f64>,
    /// Cut-off of the motion filter, Hz; chosen automatically if `None`.
    pub motion_cutoff: Option<f64>,
    /// Use offset, viscous and Coulomb friction only.
    pub plain_friction: bool,
    /// Keep the torques as they are in time, without a search for delays.
    pub keep_delay: bool,
}

/// The identified model of an arm.
#[derive(Clone, Debug)]
pub struct Identified {
    /// The base parameters.
    pub base: Base,
    /// The filters that were chosen.
    pub filters: Filters,
    /// Motion cut-offs that were tried: the cut-off, Hz, and the geometric mean of the joints' held-out errors, N m.
    pub cutoffs: Vec<(f64, f64)>,
    /// Friction law of each joint.
    pub laws: Vec<FrictionLaw>,
    /// Friction coefficients of each joint, one per term.
    pub friction: Vec<Vec<f64>>,
    /// Standard deviations of the friction coefficients.
    pub friction_deviations: Vec<Vec<f64>>,
    /// Friction candidates that were tried.
    pub tried: Vec<Tried>,
    /// Base parameters from least squares, before physical consistency is enforced.
    pub free: DVector<f64>,
    /// Covariance of `free`.
    pub covariance: DMatrix<f64>,
    /// Physically consistent bodies.
    pub bodies: Consistent,
    /// Robust standard deviation of each joint's residual on the logs, N m or N.
    pub sigma: Vec<f64>,
    /// Condition number of the weighted base-parameter columns, each scaled to equal length.
    pub condition: f64,
    /// Delay of each joint's torque that is compensated, s.
    pub delay: Vec<f64>,
    /// The delays that the logs show.
    pub delays: Delays,
    /// Root mean square jitter of the time stamps that an even clock has replaced, s: the largest over the logs.
    pub jitter: f64,
    /// Held-out error of each joint, N m or N.
    pub held_out: Vec<f64>,
    /// Autocorrelation of each joint's residual at a lag of 0.25 s. Near 1, the residual is a model error and no noise.
    pub persistence: Vec<f64>,
}

/// Identifies an arm from logs.
#[must_use]
pub fn identify(arm: &dyn Arm, maker: &Maker, logs: &[Log], settings: &Settings) -> Identified {
    let base = Base::of(arm);
    let (logs, jitter): (Vec<Log>, Vec<f64>) = logs.iter().map(repaired).unzip();
    let jitter = jitter.into_iter().fold(0.0, f64::max);
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
        (vec![FrictionLaw::with(Direction::Hysteresis(1e-4), &[]); base.joints], Vec::new())
    } else {
        choose::laws(&prepared, &base)
    };
    let problem = FitProblem { logs: &prepared, base: &base, laws: &laws };
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

/// Adds the effect of delay errors to the covariance: the uncertainty of a compensated delay, or the whole of one that is not compensated.
fn add_delay(covariance: &mut DMatrix<f64>, logs: &[Prepared], fit: &Fit, delay: &[f64], delays: &Delays) {
    for (joint, applied) in delay.iter().enumerate() {
        let (Some(value), Some(deviation)) = (delays.value.get(joint), delays.deviation.get(joint)) else { continue };
        let left = if (value - applied).abs() < 3.0 * deviation { 0.0 } else { value - applied };
        let change = fit.change(joint, &torque_slope(logs, fit, joint)) * deviation.hypot(left);
        *covariance += &change * change.transpose();
    }
}

/// Adds the effect of position noise to the covariance. Noise in a column biases its coefficient towards zero, and no residual shows it. A second fit
/// with the same amount of noise added again moves about as far as the first fit is biased.
fn add_position_noise(
    covariance: &mut DMatrix<f64>,
    arm: &dyn Arm,
    problem: &FitProblem<'_>,
    fit: &Fit,
    logs: &[Log],
    filters: Filters,
) {
    let mut random = Random::new(11);
    let noisier: Vec<Prepared> = logs
        .iter()
        .map(|log| {
            let noise = |q: &Vec<f64>| -> Vec<f64> {
                let size = position_noise(q);
                q.iter().map(|q| q + size * random.normal()).collect()
            };
            let q = log.q.iter().map(noise).collect();
            Prepared::new(&Log { q, ..log.clone() }, arm, problem.base, filters)
        })
        .collect();
    let moved = FitProblem { logs: &noisier, ..*problem }.fit().x - &fit.x;
    *covariance += &moved * moved.transpose();
}

/// Standard deviation of a position's noise, from third differences, to which a smooth motion contributes little.
fn position_noise(q: &[f64]) -> f64 {
    let third: f64 = q.windows(4).map(|q| (q[3] - 3.0 * q[2] + 3.0 * q[1] - q[0]).powi(2)).sum();
    (third / (20 * q.len().max(1)) as f64).sqrt()
}

/// Motion cut-off with the smallest held-out error of the torques. The torque filter stays the same.
fn best_cutoff(
    base: &Base,
    torque: f64,
    rate: f64,
    prepare: &dyn Fn(f64) -> Vec<Prepared>,
) -> (f64, Vec<(f64, f64)>, Vec<Prepared>) {
    // Each joint is judged with the direction rule that suits it.
    let mut tried = Vec::new();
    let mut best: Option<(f64, f64, Vec<Prepared>)> = None;
    for motion in MOTION_CUTOFFS.map(|share| share * torque).into_iter().filter(|f| *f < 0.4 * rate) {
        let logs = prepare(motion);
        let judge = |direction| {
            let laws = vec![FrictionLaw::with(direction, &[Term::Load, Term::Root]); base.joints];
            FitProblem { logs: &logs, base, laws: &laws }.fit().held_out()
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

/// Friction coefficients that are optimal for these base parameters.
fn friction_beside(problem: &FitProblem<'_>, fit: &Fit, beta: &DVector<f64>) -> Vec<Vec<f64>> {
    let loads: Vec<Series> = problem.logs.iter().map(|log| log.of_bodies(beta.as_slice())).collect();
    let rows = problem.rows(&loads);
    let normal = Normal::of(&rows, &fit.sigma, &fit.weights, |_| true, problem.unknowns());
    let b = beta.len();
    let more = problem.unknowns() - b;
    let right = normal.right.rows(b, more) - normal.matrix.view((b, 0), (more, b)) * beta;
    let found = solve(&normal.matrix.view((b, b), (more, more)).into_owned(), &right);
    let of = |(joint, law): (usize, &FrictionLaw)| {
        let at = problem.offset(joint) - b;
        found.as_slice()[at..at + law.terms.len()].to_vec()
    };
    problem.laws.iter().enumerate().map(of).collect()
}

impl Identified {
    /// Share of the maker's uncertainty about each joint's torque that remains, over random states. It is 1 if the logs contain no information about
    /// the joint.
    #[must_use]
    pub fn open(&self, arm: &dyn Arm) -> Vec<f64> {
        let n = self.base.joints;
        let mut random = Random::new(5);
        let mut sums = vec![(0.0, 0.0); n];
        for _ in 0..STATES {
            let state = [3.0, 1.5, 3.0].map(|size| random.list(n, size));
            let rows = self.base.rows(arm, state.each_ref().map(Vec::as_slice));
            for (row, (after, before)) in rows.iter().zip(&mut sums) {
                *after += row.dot(&(&self.bodies.beta_covariance * row));
                *before += row.dot(&(&self.bodies.beta_before * row));
            }
        }
        sums.iter().map(|(after, before)| (after / before.max(1e-300)).max(0.0).sqrt()).collect()
    }

    /// `(b - R pi)^T C^-1 (b - R pi)`: squared distance of the consistent bodies from least squares, in standard deviations.
    #[must_use]
    pub fn distance(&self) -> f64 {
        let off = &self.free - &self.bodies.beta;
        off.dot(&(inverse(&self.covariance) * &off))
    }
}
