//! Payload of an arm, from a log against a known arm.
//!
//! The load is ten parameters more on the last link: `tau - tau_known = Y_n p + friction`. Friction drifts with temperature between two
//! logs, so its coefficients are estimated anew, near those of the known arm. Every row counts by how many neighbours say the same, and
//! the known arm's own covariance goes into the interval.
//!
//! Motion without a load cannot tell torque per ampere from mass: with twice the constant everything weighs twice as much. What can is
//! the maker's masses, to within how far they are trusted. [`torque_scale`] weighs both.

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

/// Rounds of robust weights and of the load that friction feels.
const ROUNDS: usize = 5;
/// Drift of a coefficient of friction, as a share, and at least, in deviations of the residual.
const DRIFT: (f64, f64) = (0.25, 0.5);

/// An arm that is known.
#[derive(Clone, Debug)]
pub struct Known {
    /// Its base.
    pub base: Base,
    /// Base parameters.
    pub beta: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// The law of friction of each joint.
    pub laws: Vec<FrictionLaw>,
    /// Its coefficients.
    pub friction: Vec<Vec<f64>>,
    /// The filters.
    pub filters: Filters,
    /// Delay of each joint's torque that is compensated, s; empty for none.
    pub delay: Vec<f64>,
}

/// Estimated payload.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Payload {
    /// kg.
    pub mass: f64,
    /// Its standard deviation, with that of the scale of torques.
    pub mass_deviation: f64,
    /// kg, as if the scale of torques were one.
    pub unscaled: f64,
    /// Deviation of that.
    pub unscaled_deviation: f64,
    /// Mass centre in the last link's frame, m; `None` where there is no mass to speak of.
    pub com: Option<Vector3<f64>>,
    /// Deviation of each coordinate, m.
    pub com_deviation: Vector3<f64>,
    /// Inertia about the mass centre, kg m^2, of a body that is possible.
    pub inertia: Matrix3<f64>,
    /// Measured torque over true torque, and its deviation.
    pub scale: (f64, f64),
    /// Root mean square of what is left, N m or N, of each joint.
    pub rms: Vec<f64>,
}

impl Known {
    /// From an identification.
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

    /// From numbers that are taken as they are, with viscous and Coulomb friction.
    #[must_use]
    pub fn of_numbers(arm: &dyn Arm, parameters: &[f64], friction: &[(f64, f64)], filters: Filters) -> Self {
        let base = Base::of(arm);
        let beta = base.of_parameters(parameters);
        let covariance = DMatrix::from_diagonal(&beta.map(|b| (1e-3 * b).powi(2) + 1e-12));
        let laws = vec![FrictionLaw::with(Direction::Hysteresis(1e-4), &[]); base.joints];
        let friction = friction.iter().map(|(viscous, coulomb)| vec![0.0, *viscous, *coulomb]).collect();
        Self { base, beta, covariance, laws, friction, filters, delay: Vec::new() }
    }

    /// `R` restricted to the last link.
    fn last_link(&self) -> DMatrix<f64> {
        let n = self.base.joints;
        self.base.regroup.columns(PARAMETERS * (n - 1), PARAMETERS).into_owned()
    }

    /// Payload along these logs. `scale` is measured torque over true torque with its deviation: [`torque_scale`], or (1, 0).
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

    /// One over the variance that each unknown is expected to have: none for the load, drift for friction.
    fn prior(&self, sigma: &[f64], start: &DVector<f64>, more: usize) -> DVector<f64> {
        let mut prior = DVector::zeros(PARAMETERS + more);
        let joint_of = self.laws.iter().enumerate().flat_map(|(joint, law)| vec![joint; law.terms.len()]);
        for (k, joint) in joint_of.enumerate() {
            prior[PARAMETERS + k] = (DRIFT.0 * start[k].abs()).max(DRIFT.1 * sigma[joint]).powi(-2);
        }
        // Inertia about the link's origin: no load that an arm carries has a radius of gyration of more than half a metre.
        for k in 4..PARAMETERS {
            prior[k] = 1.0;
        }
        prior
    }

    /// Coupling of the estimate to an error of the known base parameters: `A^T W Y_b`.
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

/// Rows in the load's parameters and changes of friction, with what is known taken off the torque.
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
        // A ball of a decimetre about the centre that the moments say, to start from.
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
