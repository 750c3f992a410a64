//! Physically consistent bodies: the nearest to the data and to the maker's numbers.
//!
//! A body is physically consistent if its pseudo-inertia `P = [Sigma, h; h^T, m]` with `Sigma = tr(I) / 2 1 - I` is positive definite (Wensing, Kim
//! and Slotine 2018). With the maker's `P_0 = L_0 L_0^T` every such body is `P = L_0 T T^T L_0^T`, where `T` is lower triangular with `exp(theta)` on
//! its diagonal. These are log-Cholesky coordinates (Rucker and Wensing 2022) relative to the maker's body, which is `theta = 0`. The solution of
//!
//! `min_theta (b - R pi(theta))^T Lambda (b - R pi(theta)) + |theta|^2 / rho^2`
//!
//! is found by the Levenberg-Marquardt method. `b` are the base parameters of the data and `Lambda` is their inverse covariance. In directions that
//! the data do not determine, the maker's numbers stay.

use crate::base::Base;
use crate::fit::{inverse, solve};
use dynamics_core::regressor::PARAMETERS;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, Vector3};

/// Largest number of Levenberg-Marquardt steps; about ten are usual.
const STEPS: usize = 100;
/// Floor of the eigenvalues of a maker's body, as a share of its largest eigenvalue, and of the arm's largest mass.
const FLOOR: f64 = 1e-4;
/// Assumed radius of gyration of a body for which the maker gives an inertia and no mass, m.
const RADIUS: f64 = 0.2;
/// Body for which the maker gives nothing: assumed mass, kg, and relative standard deviation (a factor of 20 either way).
const GUESS: (f64, f64) = (0.5, 1.5);
/// Standard deviation of the logarithm of a rotor's inertia: if the maker gives a value, and if it is unknown.
const ROTOR: (f64, f64) = (0.5, 2.0);

/// The maker's numbers of an arm, in the frames of the model's links.
#[derive(Clone, Debug, PartialEq)]
pub struct Maker {
    /// Ten parameters of each link, SI units.
    pub links: Vec<[f64; PARAMETERS]>,
    /// Ten parameters of what is fixed to each link and is not identified, such as a tool.
    pub fixed: Vec<[f64; PARAMETERS]>,
    /// Reflected inertia of each rotor, kg m^2; 0 if it is not known.
    pub rotors: Vec<f64>,
    /// Trust in the maker's numbers: relative standard deviation of the roots of masses and second moments.
    pub deviation: f64,
}

impl Maker {
    /// Trust in one link's numbers: relative standard deviation of the roots of mass and second moments.
    #[must_use]
    pub fn deviation_of(&self, link: usize) -> f64 {
        if is_missing(&self.links[link]) { GUESS.1 } else { self.deviation }
    }

    /// Largest mass and largest moment of inertia of a link, kg and kg m^2.
    fn largest(&self) -> (f64, f64) {
        let heaviest = self.links.iter().fold(1e-3_f64, |m, link| m.max(link[0]));
        (heaviest, self.links.iter().map(|link| link[9].abs()).fold(1e-6, f64::max))
    }

    /// True if a link has neither mass nor inertia: the file describes geometry alone.
    #[must_use]
    pub fn is_incomplete(&self) -> bool {
        self.links.iter().any(is_missing)
    }
}

/// True if the maker gives no inertial parameter of a body.
fn is_missing(parameters: &[f64; PARAMETERS]) -> bool {
    parameters.iter().all(|x| x.abs() < 1e-12)
}

/// Physically consistent bodies and rotors, with their standard deviations.
#[derive(Clone, Debug)]
pub struct Consistent {
    /// All parameters: ten of each link without what is fixed to it, then the rotors.
    pub parameters: Vec<f64>,
    /// Standard deviation of each parameter.
    pub deviations: Vec<f64>,
    /// Share of the maker's uncertainty that is left for each parameter. Near 1, the data do not determine it.
    pub unseen: Vec<f64>,
    /// Base parameters: `R` times the vector of all parameters, also of those held at a known value. The torques depend on these alone.
    pub beta: DVector<f64>,
    /// Covariance of the base parameters from data and maker.
    pub beta_covariance: DMatrix<f64>,
    /// Covariance of the base parameters from the maker's numbers alone.
    pub beta_before: DMatrix<f64>,
}

/// Ten parameters from a pseudo-inertia.
fn of_pseudo(p: &Matrix4<f64>) -> [f64; PARAMETERS] {
    let sigma: Matrix3<f64> = p.fixed_view::<3, 3>(0, 0).into_owned();
    let i = Matrix3::from_diagonal_element(sigma.trace()) - sigma;
    [p[(3, 3)], p[(0, 3)], p[(1, 3)], p[(2, 3)], i.m11, i.m12, i.m13, i.m22, i.m23, i.m33]
}

/// Pseudo-inertia from ten parameters.
#[must_use]
pub fn pseudo(parameters: &[f64; PARAMETERS]) -> Matrix4<f64> {
    let [m, hx, hy, hz, xx, xy, xz, yy, yz, zz] = *parameters;
    let half = (xx + yy + zz) / 2.0;
    Matrix4::new(half - xx, -xy, -xz, hx, -xy, half - yy, -yz, hy, -xz, -yz, half - zz, hz, hx, hy, hz, m)
}

/// Lower Cholesky factor of the nearest body that has some mass and size. Makers may leave out both.
fn factor(parameters: &[f64; PARAMETERS], mass: f64) -> Matrix4<f64> {
    // In metres and kilograms the eigenvalues of a sound link differ by orders of magnitude. With 0.1 m as the unit of length they are comparable.
    let unit = Matrix4::from_diagonal(&nalgebra::Vector4::new(10.0, 10.0, 10.0, 1.0));
    let mut given = pseudo(parameters);
    if is_missing(parameters) {
        let size = RADIUS * RADIUS / 3.0;
        given = Matrix4::from_diagonal(&nalgebra::Vector4::new(size, size, size, 1.0)) * GUESS.0;
    }
    if given[(3, 3)] <= 0.0 {
        // An inertia without a mass: assume the mass that has this inertia at the typical radius of gyration.
        given[(3, 3)] = (given.trace() / (RADIUS * RADIUS)).max(0.0);
    }
    let scaled = unit * given * unit;
    let eigen = scaled.symmetric_eigen();
    let floor = FLOOR * eigen.eigenvalues.amax().max(mass);
    let values = eigen.eigenvalues.map(|x| x.max(floor));
    let raised = eigen.eigenvectors * Matrix4::from_diagonal(&values) * eigen.eigenvectors.transpose();
    let back = Matrix4::from_diagonal(&nalgebra::Vector4::new(0.1, 0.1, 0.1, 1.0));
    let symmetric = back * (raised + raised.transpose()) * back * 0.5;
    symmetric.cholesky().map_or_else(Matrix4::identity, |c| c.l())
}

/// Positions of the elements of `theta` in `T`: the diagonal first, then the elements below it.
const PLACES: [(usize, usize); PARAMETERS] =
    [(0, 0), (1, 1), (2, 2), (3, 3), (1, 0), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2)];

fn triangle(theta: &[f64]) -> Matrix4<f64> {
    let mut t = Matrix4::zeros();
    for (k, &(row, column)) in PLACES.iter().enumerate() {
        t[(row, column)] = if row == column { theta[k].exp() } else { theta[k] };
    }
    t
}

/// Parameters of the body at `theta` relative to the body of factor `l`, and their derivatives by `theta`.
fn body(l: &Matrix4<f64>, theta: &[f64]) -> ([f64; PARAMETERS], [[f64; PARAMETERS]; PARAMETERS]) {
    let t = triangle(theta);
    let around = |inner: Matrix4<f64>| of_pseudo(&(l * inner * l.transpose()));
    let slopes = core::array::from_fn(|k| {
        let (row, column) = PLACES[k];
        let mut change = Matrix4::zeros();
        change[(row, column)] = if row == column { t[(row, column)] } else { 1.0 };
        let inner = change * t.transpose();
        around(inner + inner.transpose())
    });
    (around(t * t.transpose()), slopes)
}

struct Search<'a> {
    base: &'a Base,
    factors: Vec<Matrix4<f64>>,
    fixed: DVector<f64>,
    rotors: Vec<f64>,
    /// Inverse variance of each coordinate.
    trust: DVector<f64>,
}

impl Search<'_> {
    /// Parameters without what is fixed, and their derivatives by `theta`.
    fn parameters(&self, theta: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.factors.len();
        let total = theta.len();
        let (mut value, mut slope) = (DVector::zeros(total), DMatrix::zeros(total, total));
        for (link, l) in self.factors.iter().enumerate() {
            let at = PARAMETERS * link;
            let (found, slopes) = body(l, &theta.as_slice()[at..at + PARAMETERS]);
            value.rows_mut(at, PARAMETERS).copy_from_slice(&found);
            for (coordinate, slopes) in slopes.iter().enumerate() {
                slope.view_mut((at, at + coordinate), (PARAMETERS, 1)).copy_from_slice(slopes);
            }
        }
        for (joint, rotor) in self.rotors.iter().enumerate() {
            let at = PARAMETERS * n + joint;
            value[at] = rotor * theta[at].exp();
            slope[(at, at)] = value[at];
        }
        (value, slope)
    }

    fn cost(&self, theta: &DVector<f64>, wanted: &DVector<f64>, precision: &DMatrix<f64>) -> f64 {
        let off = wanted - &self.base.regroup * (self.parameters(theta).0 + &self.fixed);
        off.dot(&(precision * &off)) + theta.component_mul(theta).dot(&self.trust)
    }

    /// Gauss-Newton matrix of the whole cost.
    fn curvature(&self, slope: &DMatrix<f64>, precision: &DMatrix<f64>) -> DMatrix<f64> {
        let through = &self.base.regroup * slope;
        through.tr_mul(&(precision * &through)) + DMatrix::from_diagonal(&self.trust)
    }

    fn run(&self, wanted: &DVector<f64>, precision: &DMatrix<f64>) -> DVector<f64> {
        let mut theta = DVector::zeros(self.base.regroup.ncols());
        let mut cost = self.cost(&theta, wanted, precision);
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            let (value, slope) = self.parameters(&theta);
            let off = wanted - &self.base.regroup * (value + &self.fixed);
            let through = &self.base.regroup * &slope;
            let downhill = through.tr_mul(&(precision * off)) - theta.component_mul(&self.trust);
            let curvature = self.curvature(&slope, precision);
            let mut better = None;
            for _ in 0..12 {
                let mut damped = curvature.clone();
                for k in 0..theta.len() {
                    damped[(k, k)] *= 1.0 + damping;
                }
                let step = solve(&damped, &downhill);
                // Limit a step to a factor of e.
                let longest = step.amax();
                let next = &theta + step * (1.0 / longest.max(1.0));
                let there = self.cost(&next, wanted, precision);
                if there < cost {
                    better = Some((next, there));
                    break;
                }
                damping *= 4.0;
            }
            let Some((next, there)) = better else { break };
            let gained = cost - there;
            (theta, cost) = (next, there);
            damping = (damping / 8.0).max(1e-12);
            if gained < 1e-9 * (1.0 + cost) {
                break;
            }
        }
        theta
    }
}

/// Returns the bodies nearest to the base parameters `wanted`, weighted by `covariance`, and to the maker's numbers.
#[must_use]
pub fn nearest(base: &Base, maker: &Maker, wanted: &DVector<f64>, covariance: &DMatrix<f64>) -> Consistent {
    let n = base.joints;
    let (heaviest, largest) = maker.largest();
    let rotors: Vec<f64> = maker.rotors.iter().map(|r| if *r > 0.0 { *r } else { 0.1 * largest }).collect();
    let mut trust = DVector::zeros(base.regroup.ncols());
    for link in 0..n {
        trust.rows_mut(PARAMETERS * link, PARAMETERS).fill(maker.deviation_of(link).powi(-2));
    }
    for (joint, rotor) in maker.rotors.iter().enumerate() {
        trust[PARAMETERS * n + joint] = if *rotor > 0.0 { ROTOR.0 } else { ROTOR.1 }.powi(-2);
    }
    let mut fixed = DVector::zeros(base.regroup.ncols());
    fixed.iter_mut().zip(maker.fixed.iter().flatten()).for_each(|(place, value)| *place = *value);
    let factors = maker.links.iter().map(|link| factor(link, heaviest)).collect();
    let search = Search { base, factors, fixed, rotors, trust };
    let precision = inverse(covariance);
    let theta = search.run(wanted, &precision);
    let (value, slope) = search.parameters(&theta);
    let seen = search.curvature(&slope, &precision);
    let spread = &slope * inverse(&seen) * slope.transpose();
    let before = &slope * DMatrix::from_diagonal(&search.trust.map(f64::recip)) * slope.transpose();
    let deviations: Vec<f64> = spread.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect();
    let unseen = deviations.iter().zip(before.diagonal().iter()).map(|(d, b)| d / b.sqrt().max(1e-300)).collect();
    let beta = &base.regroup * (&value + &search.fixed);
    let of_beta = |covariance: &DMatrix<f64>| &base.regroup * covariance * base.regroup.transpose();
    let (beta_covariance, beta_before) = (of_beta(&spread), of_beta(&before));
    Consistent { parameters: value.as_slice().to_vec(), deviations, unseen, beta, beta_covariance, beta_before }
}

/// Standard deviation of the roots of a maker's masses and second moments while the log itself is in doubt.
const WIDE: f64 = 0.25;
/// Standard deviation of a rotor's inertia: relative if it is known; otherwise in multiples of the largest link's inertia.
const WIDE_ROTOR: (f64, f64) = (1.0, 10.0);

/// Mean and covariance of the base parameters from the maker's numbers, linearised and wide. The hypothesis tests judge a log with it before they
/// trust its columns.
#[must_use]
pub fn prior(base: &Base, maker: &Maker) -> (DVector<f64>, DMatrix<f64>) {
    let n = base.joints;
    let total = base.regroup.ncols();
    let (heaviest, largest) = maker.largest();
    let (mut mean, mut covariance) = (DVector::zeros(total), DMatrix::zeros(total, total));
    for (link, (own, fixed)) in maker.links.iter().zip(&maker.fixed).enumerate() {
        let at = PARAMETERS * link;
        let wide = WIDE.max(maker.deviation_of(link));
        let (value, slopes) = body(&factor(own, heaviest), &[0.0; PARAMETERS]);
        for i in 0..PARAMETERS {
            mean[at + i] = value[i] + fixed[i];
            for j in 0..PARAMETERS {
                let product: f64 = slopes.iter().map(|slope| slope[i] * slope[j]).sum();
                covariance[(at + i, at + j)] = wide * wide * product;
            }
        }
    }
    for (joint, rotor) in maker.rotors.iter().enumerate() {
        let at = PARAMETERS * n + joint;
        mean[at] = if *rotor > 0.0 { *rotor } else { 0.1 * largest };
        let deviation = if *rotor > 0.0 { WIDE_ROTOR.0 * rotor } else { WIDE_ROTOR.1 * largest };
        covariance[(at, at)] = deviation * deviation;
    }
    (&base.regroup * mean, &base.regroup * covariance * base.regroup.transpose())
}

/// Mass (kg), centre of mass (m) and inertia about it (kg m^2), from ten parameters about an origin.
#[must_use]
pub fn central(parameters: &[f64; PARAMETERS]) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let [m, hx, hy, hz, xx, xy, xz, yy, yz, zz] = *parameters;
    let c = Vector3::new(hx, hy, hz) / m;
    let about_origin = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    (m, c, about_origin - (Matrix3::from_diagonal_element(c.dot(&c)) - c * c.transpose()) * m)
}
