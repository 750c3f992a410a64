//! Score of a log: the log-likelihood of its torques for bodies near the maker's.
//!
//! Torque is linear in base parameters and friction. The normal equations of each joint's rows are stored once, with the products of its columns and
//! every other joint's torque. A reversed sign, a scale or an exchange of torques then needs one small solve and no pass over the samples.
//!
//! The score is in nats, greater is better: `-sum_i N ln(sigma_i / rms_i) - d^2 / 2 - friction`. `sigma_i` is the residual of joint `i` at the most
//! likely parameters, `N` is the number of independent samples, and `d` is the distance from the maker's parameters in standard deviations. The last
//! term penalises friction that would add energy.

use crate::arm::Arm;
use crate::base::Base;
use crate::consistent::{Maker, prior};
use crate::fit::{FitProblem, inverse, solve};
use crate::friction::{Direction, FrictionLaw};
use crate::log::Log;
use crate::prepare::{Filters, Prepared};
use crate::statistics::median;
use dynamics_core::regressor::PARAMETERS;
use nalgebra::{DMatrix, DVector, Vector3};

/// Cut-off of the filters of motion and torque, Hz. Signs, scales and orders show at low frequencies.
const CUTOFF: f64 = 3.0;
/// Independent samples per second: half the residuals' autocorrelation time of real logs.
const INDEPENDENT: f64 = 3.0;
/// Smallest relative residual, as a share of the torque's root mean square. A smaller residual counts as this.
const FLOOR: f64 = 0.01;
/// Standard deviation of an offset of the torque, as a share of the torque's root mean square.
const OFFSET: f64 = 0.05;
/// Largest penalty for friction that adds energy, nats.
const GIVES_ENERGY: f64 = 40.0;
/// Standard deviation of the logarithm of the total mass ratio, and the largest penalty for it, nats.
const HEAVIER: (f64, f64) = (0.35, 80.0);
/// Weight of the maker's numbers while a scale is estimated.
const FAINT: f64 = 1e-6;
/// Iterations between residuals and parameters.
const ROUNDS: usize = 4;
/// Columns of friction: offset, viscous, Coulomb.
const FRICTION: usize = 3;
/// Gravity in a general direction, m/s^2: its base parameters contain those of every other direction.
const GENERIC: [f64; 3] = [3.1, -4.7, 6.3];

/// Prior distribution of the base parameters, from the maker's numbers.
#[derive(Clone, Debug)]
pub struct Expected {
    /// Base parameters of the arm under gravity in a general direction.
    pub base: Base,
    mean: DVector<f64>,
    precision: DMatrix<f64>,
    /// True if the maker gives the mass of every link.
    complete: bool,
}

impl Expected {
    /// Computes the prior from the maker's numbers.
    #[must_use]
    pub fn of(arm: &dyn Arm, maker: &Maker) -> Self {
        let base = Base::of(arm.under(Vector3::from(GENERIC)).as_ref());
        let (mean, covariance) = prior(&base, maker);
        Self { base, mean, precision: inverse(&covariance), complete: !maker.is_incomplete() }
    }

    /// True if an unknown is a base parameter of the links; false for a rotor's inertia alone and for friction.
    fn is_body(&self, place: usize) -> bool {
        self.base.columns.get(place).is_some_and(|k| *k < PARAMETERS * self.base.joints)
    }
}

/// Normal equations of one joint, as means over the samples.
struct Block {
    /// Indices among all unknowns.
    places: Vec<usize>,
    gram: DMatrix<f64>,
    /// Products of this joint's columns with the torque of each joint.
    cross: Vec<DVector<f64>>,
    /// Mean power of each friction term at unit coefficient.
    power: DVector<f64>,
}

impl Block {
    /// Values of this joint's own unknowns.
    fn own(&self, value: impl Fn(usize) -> f64) -> DVector<f64> {
        DVector::from_iterator(self.places.len(), self.places.iter().map(|place| value(*place)))
    }
}

/// Normal equations of a log.
pub struct Evidence {
    blocks: Vec<Block>,
    /// Mean square of each joint's torque.
    squares: Vec<f64>,
    independent: f64,
    unknowns: usize,
}

/// Source of a joint's torque: the column's joint, and the factor.
pub type Source = (usize, f64);

/// Score of one assignment of torques, and its parameters.
#[derive(Clone, Debug)]
pub struct Score {
    /// Log-likelihood, nats; greater is better.
    pub nats: f64,
    /// Residual of each joint as a share of its torque.
    pub left: Vec<f64>,
    /// Distance from the maker's parameters: sum of squares, in standard deviations.
    pub distance: f64,
    /// Power of each joint's friction over its standard deviation. Below zero, friction drives the joint.
    pub friction: Vec<f64>,
    /// Torque of the identified bodies over that of the maker's: the ratio of their weights. 1 if the maker does not give all masses.
    pub heavier: f64,
    /// Base parameters, then offset, viscous and Coulomb friction of each joint.
    pub x: DVector<f64>,
}

impl Evidence {
    /// Computes the normal equations from logs of an arm. `arm` has the gravity to be tested, `expected` the prior.
    #[must_use]
    pub fn of(arm: &dyn Arm, expected: &Expected, logs: &[Log]) -> Self {
        let base = &expected.base;
        let prepared: Vec<Prepared> = logs
            .iter()
            .map(|log| {
                let cutoff = CUTOFF.min(0.2 * log.rate());
                Prepared::new(log, arm, base, Filters { motion: cutoff, torque: cutoff })
            })
            .collect();
        let laws = vec![FrictionLaw::with(Direction::Smooth(0.02), &[]); base.joints];
        let problem = FitProblem { logs: &prepared, base, laws: &laws };
        let loads: Vec<_> = prepared.iter().map(|log| log.tau.clone()).collect();
        let rows = problem.rows(&loads);
        let targets: Vec<&DVector<f64>> = rows.iter().map(|rows| &rows.target).collect();
        let count = targets.first().map_or(1, |target| target.len().max(1)) as f64;
        let blocks = rows
            .iter()
            .map(|rows| {
                // The last columns belong to friction, and the viscous one is the filtered velocity.
                let first = rows.columns.ncols() - FRICTION;
                let speed = rows.columns.column(first + 1).into_owned();
                let mut power = DVector::zeros(rows.columns.ncols());
                for k in first + 1..rows.columns.ncols() {
                    power[k] = rows.columns.column(k).dot(&speed) / count;
                }
                Block {
                    places: rows.places.clone(),
                    gram: rows.columns.tr_mul(&rows.columns) / count,
                    cross: targets.iter().map(|target| rows.columns.tr_mul(*target) / count).collect(),
                    power,
                }
            })
            .collect();
        let duration: f64 = logs.iter().map(Log::duration).sum();
        Self {
            blocks,
            squares: targets.iter().map(|target| (target.norm_squared() / count).max(1e-18)).collect(),
            independent: (INDEPENDENT * duration).min(count),
            unknowns: problem.unknowns(),
        }
    }

    /// Assigns each joint its own torque.
    #[must_use]
    pub fn as_recorded(&self) -> Vec<Source> {
        (0..self.blocks.len()).map(|joint| (joint, 1.0)).collect()
    }

    /// Score with the torques assigned by `sources`.
    #[must_use]
    pub fn score(&self, expected: &Expected, sources: &[Source]) -> Score {
        let solved = self.solve(expected, sources, 1.0, None);
        let off = solved.x.rows(0, expected.base.len()) - &expected.mean;
        let distance = (&expected.precision * &off).dot(&off);
        let power = |block: &Block| {
            let mut row = DVector::zeros(self.unknowns);
            block.places.iter().zip(block.power.iter()).for_each(|(k, p)| row[*k] = *p);
            let variance = solved.factor.as_ref().map_or(1.0, |factor| row.dot(&factor.solve(&row)));
            row.dot(&solved.x) / variance.max(1e-300).sqrt()
        };
        let friction: Vec<f64> = self.blocks.iter().map(power).collect();
        let heavier = if expected.complete { self.heavier(expected, &solved.x, &solved.squares) } else { 1.0 };
        let left: Vec<f64> = solved.left.iter().zip(&solved.squares).map(|(left, all)| (left / all).sqrt()).collect();
        let gain: f64 = left.iter().map(|left| -self.independent * left.ln()).sum();
        let driven: f64 = friction.iter().map(|z| (0.5 * z.min(0.0).powi(2)).min(GIVES_ENERGY)).sum();
        let scale = if heavier > 0.0 { 0.5 * (heavier.ln() / HEAVIER.0).powi(2) } else { HEAVIER.1 };
        let nats = gain - 0.5 * distance - driven - scale.min(HEAVIER.1);
        Score { nats, left, distance, friction, heavier, x: solved.x }
    }

    /// Factors of all torques with which the bodies would weigh about as much as the maker's. The first comes from a fit. The second comes from the
    /// size of the torques alone, which no reversed sign affects.
    pub(crate) fn common_scales(&self, expected: &Expected, sources: &[Source]) -> [f64; 2] {
        let solved = self.solve(expected, sources, FAINT, None);
        let fitted = self.heavier(expected, &solved.x, &solved.squares).abs().recip();
        let size = |(block, square): (&Block, &f64)| {
            let own = block.own(|place| expected.mean.get(place).copied().unwrap_or(0.0));
            ((&block.gram * &own).dot(&own) / square).sqrt()
        };
        [fitted, median(self.blocks.iter().zip(&solved.squares).map(size).collect())]
    }

    /// Factor of one joint's torque with which it agrees with the bodies that the other joints determine.
    pub(crate) fn joint_scale(&self, expected: &Expected, sources: &[Source], joint: usize) -> f64 {
        let solved = self.solve(expected, sources, 1.0, Some(joint));
        let block = &self.blocks[joint];
        let own = block.own(|place| if expected.is_body(place) { solved.x[place] } else { 0.0 });
        // Measured torque over the bodies' torque; friction and the rotor are fitted at the same time.
        let free: Vec<usize> = (0..block.places.len()).filter(|k| !expected.is_body(block.places[*k])).collect();
        let moved = &block.gram * &own;
        let size = free.len() + 1;
        let mut matrix = DMatrix::zeros(size, size);
        let mut right = DVector::zeros(size);
        let (from, scale) = sources[joint];
        (matrix[(0, 0)], right[0]) = (own.dot(&moved), scale * block.cross[from].dot(&own));
        for (i, &at) in free.iter().enumerate() {
            (matrix[(0, i + 1)], matrix[(i + 1, 0)]) = (moved[at], moved[at]);
            right[i + 1] = scale * block.cross[from][at];
            for (j, &to) in free.iter().enumerate() {
                matrix[(i + 1, j + 1)] = block.gram[(at, to)];
            }
        }
        solve(&matrix, &right)[0].abs().recip()
    }

    /// Torque of the bodies over that from the maker's numbers, without rotors.
    fn heavier(&self, expected: &Expected, x: &DVector<f64>, squares: &[f64]) -> f64 {
        let (mut both, mut maker) = (0.0, 0.0);
        for (block, square) in self.blocks.iter().zip(squares) {
            let pick = |of: &DVector<f64>| block.own(|place| if expected.is_body(place) { of[place] } else { 0.0 });
            let given = pick(&expected.mean);
            let through = &block.gram * &given;
            both += through.dot(&pick(x)) / square;
            maker += through.dot(&given) / square;
        }
        both / maker.max(1e-300)
    }

    /// Most likely parameters, by iterating between residuals and parameters. `trust` is the weight of the maker's numbers.
    fn solve(&self, expected: &Expected, sources: &[Source], trust: f64, without: Option<usize>) -> Solved {
        let b = expected.base.len();
        let squares: Vec<f64> = sources.iter().map(|(from, factor)| self.squares[*from] * factor * factor).collect();
        let mut left: Vec<f64> = squares.clone();
        let mut x = DVector::zeros(self.unknowns);
        let start = &expected.precision * &expected.mean * trust;
        let mut factor = None;
        for _ in 0..ROUNDS {
            let mut matrix = DMatrix::zeros(self.unknowns, self.unknowns);
            matrix.view_mut((0, 0), (b, b)).copy_from(&(&expected.precision * trust));
            let mut right = DVector::zeros(self.unknowns);
            right.rows_mut(0, b).copy_from(&start);
            for (joint, block) in self.blocks.iter().enumerate() {
                let weight = if without == Some(joint) { 1e-9 } else { 1.0 } * self.independent / left[joint];
                let (from, scale) = sources[joint];
                for (i, &at) in block.places.iter().enumerate() {
                    right[at] += weight * scale * block.cross[from][i];
                    for (j, &to) in block.places.iter().enumerate() {
                        matrix[(at, to)] += weight * block.gram[(i, j)];
                    }
                }
                let own = b + FRICTION * joint;
                matrix[(own, own)] += (OFFSET * OFFSET * squares[joint]).recip();
                for k in own + 1..own + FRICTION {
                    matrix[(k, k)] += 1e-9 * matrix[(k, k)] + 1e-12;
                }
            }
            let Some(found) = matrix.cholesky() else { break };
            x = found.solve(&right);
            for (joint, block) in self.blocks.iter().enumerate() {
                let (from, scale) = sources[joint];
                let own = block.own(|place| x[place]);
                let square =
                    squares[joint] - 2.0 * scale * block.cross[from].dot(&own) + (&block.gram * &own).dot(&own);
                left[joint] = square.max(FLOOR * FLOOR * squares[joint]);
            }
            factor = Some(found);
        }
        Solved { x, left, squares, factor }
    }
}

/// Parameters, mean squares of the residuals, and mean squares of the torques.
struct Solved {
    x: DVector<f64>,
    left: Vec<f64>,
    squares: Vec<f64>,
    factor: Option<nalgebra::Cholesky<f64, nalgebra::Dyn>>,
}
