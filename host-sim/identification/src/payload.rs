//! Payload of an arm, estimated from a log and a known arm.
//!
//! The load adds ten parameters to the last link: `tau - tau_known = Y_n p + friction`. Friction drifts with temperature between two logs, so its
//! coefficients are estimated again, near those of the known arm. Weights account for autocorrelated residuals, and the interval includes the known
//! arm's covariance.
//!
//! Motion without a load cannot separate torque per ampere from mass: with twice the constant everything weighs twice as much. The maker's masses
//! can, within their uncertainty. [`torque_scale`] combines both.

mod scale;

pub use scale::torque_scale;

use crate::Series;
use crate::arm::Arm;
use crate::base::Base;
use crate::clock::repaired;
use crate::consistent::{Maker, central, nearest};
use crate::correction::shifted;
use crate::fit::{FitProblem, Normal, Rows, inverse, solve};
use crate::friction::{Direction, FrictionLaw};
use crate::identify::Identified;
use crate::log::Log;
use crate::prepare::{Filters, Prepared};
use dynamics_core::regressor::PARAMETERS;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Rounds of robust weights and of the load in the friction terms.
const ROUNDS: usize = 5;
/// Standard deviation of a friction coefficient's drift: relative, and at least this multiple of the residual's standard deviation.
const DRIFT: (f64, f64) = (0.25, 0.5);

/// An identified arm.
#[derive(Clone, Debug)]
pub struct Known {
    /// Its base-parameter form.
    pub base: Base,
    /// Base parameters.
    pub beta: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Friction law of each joint.
    pub laws: Vec<FrictionLaw>,
    /// Friction coefficients of each joint.
    pub friction: Vec<Vec<f64>>,
    /// Filters of the identification.
    pub filters: Filters,
    /// Delay of each joint's torque that is compensated, s; empty for none.
    pub delay: Vec<f64>,
}

/// Estimated payload.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Payload {
    /// Mass, kg.
    pub mass: f64,
    /// Standard deviation of the mass, kg, including the uncertainty of the torque scale.
    pub mass_deviation: f64,
    /// Mass if the torque scale were 1, kg.
    pub unscaled: f64,
    /// Standard deviation of `unscaled`, kg.
    pub unscaled_deviation: f64,
    /// Centre of mass in the last link's frame, m; `None` if the mass is negligible.
    pub com: Option<Vector3<f64>>,
    /// Standard deviation of each coordinate of `com`, m.
    pub com_deviation: Vector3<f64>,
    /// Inertia about the centre of mass, kg m^2, of a physically consistent body.
    pub inertia: Matrix3<f64>,
    /// Measured torque over true torque, and its standard deviation.
    pub scale: (f64, f64),
    /// Root mean square of each joint's residual, N m or N.
    pub rms: Vec<f64>,
}

impl Known {
    /// Takes the arm from an identification.
    #[must_use]
    pub fn of(found: &Identified) -> Self {
        Self {
            base: found.base.clone(),
            beta: found.bodies.beta.clone(),
            covariance: found.covariance.clone(),
            laws: found.laws.clone(),
            friction: found.friction.clone(),
            filters: found.filters,
            delay: found.delay.clone(),
        }
    }

    /// Takes given parameters as exact, with viscous and Coulomb friction.
    #[must_use]
    pub fn of_numbers(arm: &dyn Arm, parameters: &[f64], friction: &[(f64, f64)], filters: Filters) -> Self {
        let base = Base::of(arm);
        let beta = base.of_parameters(parameters);
        let covariance = DMatrix::from_diagonal(&beta.map(|b| (1e-3 * b).powi(2) + 1e-12));
        let laws = vec![FrictionLaw::with(Direction::Hysteresis(1e-4), &[]); base.joints];
        let friction = friction.iter().map(|(viscous, coulomb)| vec![0.0, *viscous, *coulomb]).collect();
        Self { base, beta, covariance, laws, friction, filters, delay: Vec::new() }
    }

    /// `R` restricted to the parameters of the last link.
    fn last_link(&self) -> DMatrix<f64> {
        let n = self.base.joints;
        self.base.regroup.columns(PARAMETERS * (n - 1), PARAMETERS).into_owned()
    }

    /// Estimates the payload along these logs. `scale` is measured over true torque and its standard deviation: from [`torque_scale`], or (1, 0).
    #[must_use]
    pub fn payload(&self, arm: &dyn Arm, logs: &[Log], scale: (f64, f64)) -> Payload {
        let in_time = |log: &Log| shifted(&repaired(log).0, &self.delay);
        let prepared: Vec<Prepared> =
            logs.iter().map(|log| Prepared::new(&in_time(log), arm, &self.base, self.filters)).collect();
        let problem = FitProblem { logs: &prepared, base: &self.base, laws: &self.laws };
        let last = self.last_link();
        let b = self.base.len();
        let more = problem.unknowns() - b;
        let start = DVector::from_vec(self.friction.concat());
        let mut held = DVector::zeros(PARAMETERS);
        let mut known = DVector::zeros(problem.unknowns());
        known.rows_mut(0, b).copy_from(&self.beta);
        known.rows_mut(b, more).copy_from(&start);
        let mut weights: Vec<Vec<f64>> = Vec::new();
        let mut sigma = vec![1.0; self.laws.len()];
        let (mut matrix, mut through) = (DMatrix::zeros(0, 0), DMatrix::zeros(0, 0));
        for _ in 0..ROUNDS {
            let carried = &self.beta + &last * &held;
            let loads: Vec<Series> = prepared.iter().map(|log| log.of_bodies(carried.as_slice())).collect();
            let rows = problem.rows(&loads);
            let asked: Vec<Rows> = rows.iter().map(|rows| rows_of_load(rows, b, &last, &known)).collect();
            if weights.is_empty() {
                weights = asked.iter().map(Rows::weights).collect();
                sigma = asked.iter().map(|rows| rows.deviation(&rows.target)).collect();
            }
            let prior = self.prior(&sigma, &start, more);
            let normal = Normal::of(&asked, &sigma, &weights, |_| true, PARAMETERS + more);
            matrix = &normal.matrix + DMatrix::from_diagonal(&prior);
            let x = solve(&matrix, &normal.right);
            held = x.rows(0, PARAMETERS).into_owned();
            for ((rows, sigma), weights) in asked.iter().zip(&mut sigma).zip(&mut weights) {
                let left = rows.residual(&x);
                let size = rows.deviation(&left);
                let runs = rows.runs(left.as_slice());
                *sigma = size;
                let weight = |e: &f64| (1.5 * size / e.abs().max(1e-12)).min(1.0) / runs;
                *weights = left.iter().zip(rows.weights()).map(|(e, moving)| moving * weight(e)).collect();
            }
            through = self.through(&rows, &asked, &sigma, &weights, more);
        }
        let spread = inverse(&matrix);
        let by_arm = &spread * through;
        let spread = &spread + &by_arm * &self.covariance * by_arm.transpose();
        let covariance = spread.view((0, 0), (PARAMETERS, PARAMETERS)).into_owned();
        Payload::of(&held, &covariance, scale, sigma)
    }

    /// Prior inverse variance of each unknown: zero for the load, the drift for friction.
    fn prior(&self, sigma: &[f64], start: &DVector<f64>, more: usize) -> DVector<f64> {
        let mut prior = DVector::zeros(PARAMETERS + more);
        let joint_of = self.laws.iter().enumerate().flat_map(|(joint, law)| vec![joint; law.terms.len()]);
        for (k, joint) in joint_of.enumerate() {
            prior[PARAMETERS + k] = (DRIFT.0 * start[k].abs()).max(DRIFT.1 * sigma[joint]).powi(-2);
        }
        // Inertia about the link's origin: the prior assumes a radius of gyration below about half a metre.
        for k in 4..PARAMETERS {
            prior[k] = 1.0;
        }
        prior
    }

    /// Sensitivity of the estimate to errors of the known base parameters: `A^T W Y_b`.
    fn through(&self, rows: &[Rows], asked: &[Rows], sigma: &[f64], weights: &[Vec<f64>], more: usize) -> DMatrix<f64> {
        let b = self.base.len();
        let mut sum = DMatrix::zeros(PARAMETERS + more, b);
        for (((rows, asked), sigma), weights) in rows.iter().zip(asked).zip(sigma).zip(weights) {
            for (column, &place) in asked.columns.column_iter().zip(&asked.places) {
                let weighed: DVector<f64> = DVector::from_iterator(
                    column.len(),
                    column.iter().zip(weights).map(|(x, w)| x * w / (sigma * sigma)),
                );
                for (own, &at) in rows.columns.column_iter().zip(&rows.places).filter(|(_, at)| **at < b) {
                    sum[(place, at)] += weighed.dot(&own);
                }
            }
        }
        sum
    }
}

/// Rows in the load's parameters and in changes of friction, after the known torque is subtracted.
fn rows_of_load(rows: &Rows, base: usize, last: &DMatrix<f64>, known: &DVector<f64>) -> Rows {
    let bodies = rows.places.iter().filter(|place| **place < base).count();
    let mut columns = DMatrix::zeros(rows.target.len(), PARAMETERS + rows.places.len() - bodies);
    for (column, &place) in rows.places[..bodies].iter().enumerate() {
        for k in 0..PARAMETERS {
            let factor = last[(place, k)];
            if factor != 0.0 {
                columns.column_mut(k).axpy(factor, &rows.columns.column(column), 1.0);
            }
        }
    }
    let mut places: Vec<usize> = (0..PARAMETERS).collect();
    for (k, &place) in rows.places[bodies..].iter().enumerate() {
        columns.column_mut(PARAMETERS + k).copy_from(&rows.columns.column(bodies + k));
        places.push(PARAMETERS + place - base);
    }
    Rows {
        places,
        columns,
        target: rows.residual(known),
        from: rows.from.clone(),
        held: rows.held.clone(),
        rate: rows.rate,
    }
}

impl Payload {
    fn of(held: &DVector<f64>, covariance: &DMatrix<f64>, scale: (f64, f64), rms: Vec<f64>) -> Self {
        let deviation = |k: usize| covariance[(k, k)].max(0.0).sqrt();
        let mass = held[0] / scale.0;
        let mut payload = Self {
            mass,
            mass_deviation: (deviation(0) / scale.0).hypot(mass * scale.1 / scale.0),
            unscaled: held[0],
            unscaled_deviation: deviation(0),
            scale,
            rms,
            ..Self::default()
        };
        if held[0] < 2.0 * deviation(0) {
            return payload;
        }
        // Start from a ball about 0.1 m in size at the centre of mass that the moments give.
        let centre = Vector3::new(held[1], held[2], held[3]) / held[0];
        let round = Matrix3::from_diagonal_element(centre.dot(&centre)) - centre * centre.transpose();
        let ball = (round + Matrix3::from_diagonal_element(0.004)) * held[0];
        let start = [held[0], held[1], held[2], held[3], ball.m11, ball.m12, ball.m13, ball.m22, ball.m23, ball.m33];
        let maker = Maker { links: vec![start], fixed: vec![[0.0; PARAMETERS]], rotors: vec![0.0], deviation: 1.0 };
        let mut regroup = DMatrix::zeros(PARAMETERS, PARAMETERS + 1);
        regroup.fill_diagonal(1.0);
        let base = Base { joints: 1, columns: (0..PARAMETERS).collect(), regroup, gap: (1.0, 0.0) };
        let body = nearest(&base, &maker, held, covariance);
        let ten: [f64; PARAMETERS] = core::array::from_fn(|k| body.parameters[k]);
        let (mass, com, inertia) = central(&ten);
        payload.com = Some(com);
        payload.com_deviation = Vector3::new(deviation(1), deviation(2), deviation(3)) / mass;
        payload.inertia = inertia / scale.0;
        payload
    }
}
