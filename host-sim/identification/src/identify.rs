//! Identification in order, and predictions.

use crate::Series;
use crate::arm::Arm;
use crate::base::Base;
use crate::choose::{self, Tried};
use crate::consistent::{Consistent, Maker, nearest};
use crate::fit::{Fit, Normal, Problem, inverse, solve};
use crate::friction::{Direction, Law, Term};
use crate::log::Log;
use crate::prepare::{Filters, Prepared};
use nalgebra::{DMatrix, DVector};

/// Cut-off of the filter of torques, Hz, where the log is fast enough.
pub const TORQUE_CUTOFF: f64 = 8.0;
/// Cut-offs of motions that are tried, in cut-offs of torques.
const MOTION_CUTOFFS: [f64; 6] = [0.6, 1.0, 1.5, 2.5, 5.0, 8.0];

/// What may be chosen by hand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Cut-off of the filter of torques, Hz.
    pub torque_cutoff: Option<f64>,
    /// Cut-off of the filter of motions, Hz.
    pub motion_cutoff: Option<f64>,
    /// Offset, viscous and Coulomb friction only.
    pub plain_friction: bool,
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
    /// What was tried.
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
}

/// Identify an arm from logs.
#[must_use]
pub fn identify(arm: &dyn Arm, maker: &Maker, logs: &[Log], settings: &Settings) -> Identified {
    let base = Base::of(arm);
    let rate = logs.iter().map(Log::rate).fold(f64::MAX, f64::min);
    let torque = settings.torque_cutoff.unwrap_or(TORQUE_CUTOFF).min(0.2 * rate);
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
    let whole = fit.covariance();
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
        sigma: fit.sigma,
        condition,
        laws,
        base,
    }
}

/// The cut-off of motions with the least held-out error of torques behind their own filter, which stays the same.
fn best_cutoff(
    base: &Base,
    torque: f64,
    rate: f64,
    prepare: &dyn Fn(f64) -> Vec<Prepared>,
) -> (f64, Vec<(f64, f64)>, Vec<Prepared>) {
    // Arms with real gears, and arms whose friction creeps, as a simulated one's: each joint counts with what suits it.
    let directions = [Direction::Hysteresis(1e-4), Direction::Smooth(2e-3)];
    let mut tried = Vec::new();
    let mut best: Option<(f64, f64, Vec<Prepared>)> = None;
    for motion in MOTION_CUTOFFS.map(|share| share * torque).into_iter().filter(|f| *f < 0.4 * rate) {
        let logs = prepare(motion);
        let judge = |direction| {
            let laws = vec![Law::with(direction, &[Term::Load, Term::Root]); base.joints];
            Problem { logs: &logs, base, laws: &laws }.fit().held_out()
        };
        let [one, other] = directions.map(judge);
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
    /// Torque along a log, measured and predicted, behind the filters of the identification.
    #[must_use]
    pub fn predict(&self, arm: &dyn Arm, log: &Log) -> Prediction {
        let prepared = Prepared::new(log, arm, &self.base, self.filters);
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
        Prediction { time: prepared.time, measured: prepared.tau, model, qd: prepared.qd }
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
        let prepared = Prepared::new(log, arm, &self.base, self.filters);
        let mut model = prepared.of_bodies(self.base.of_parameters(parameters).as_slice());
        for (joint, model) in model.iter_mut().enumerate() {
            let rub: Vec<f64> =
                prepared.qd[joint].iter().zip(&*model).map(|(qd, load)| friction(joint, *qd, *load)).collect();
            model.iter_mut().zip(prepared.low_pass.apply(&rub)).for_each(|(sum, x)| *sum += x);
        }
        model
    }

    /// `(b - R pi)^T C^-1 (b - R pi)`: how far the possible bodies are from least squares, in deviations squared.
    #[must_use]
    pub fn distance(&self) -> f64 {
        let off = &self.free - &self.bodies.beta;
        off.dot(&(inverse(&self.covariance) * &off))
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
