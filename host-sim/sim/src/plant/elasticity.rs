//! Elastic joints: a motor side and a link side, connected by a spring, a damper and, optionally, backlash.
//!
//! With `theta` the motor's position on the joint side of its gear, `q` the link's position, `J` the rotor's reflected
//! inertia, `D` the arm's inertia without rotors, and `x = theta - q` the twist:
//!
//! ```text
//! J theta'' = tau - friction(theta') - s          the motor side: drive, friction, brake
//! D(q) q'' + h + G = s + J^T w                    the link side
//! s = k x + d x'                                  without backlash
//! s = k b + d x', never against b; b = x less its part within -w/2 .. w/2          with backlash w
//! ```
//!
//! A gear flank pushes but does not pull, hence "never against". As in a rigid joint, a rotor turns only about its own joint. (M. W. Spong, Modeling
//! and control of elastic joint robots, 1987; M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash, 2002.)

use super::dynamics::{Arm, Mechanism};
use super::state::{Point, State, States};
use dynamics_core::Trig;
use dynamics_core::trig::Polynomial;
use nalgebra::DMatrix;
use robot_compiler::scene::Side;

/// Springs, dampers and backlash between the two sides of every joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elasticity<const N: usize> {
    /// `k`, N m/rad or N/m, above zero.
    pub stiffness: [f64; N],
    /// `d`, N m s/rad or N s/m.
    pub damping: [f64; N],
    /// Backlash `w`, from flank to flank, rad or m; `None`: the flanks always touch.
    pub backlash: Option<[f64; N]>,
}

/// The motor sides of an arm.
#[derive(Clone, Debug)]
pub(super) struct Motors<const N: usize> {
    pub(super) springs: Elasticity<N>,
    /// Reflected rotor inertia, kg m^2 or kg.
    pub(super) inertia: [f64; N],
    pub(super) state: State<N>,
    /// The side of the joints that the sensors measure.
    pub(super) side: Side,
}

/// Both sides of every joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BothSides<const N: usize> {
    pub(super) link: States<N, 1>,
    pub(super) motor: States<N, 1>,
}

impl<const N: usize> Point<N, 1> for BothSides<N> {
    fn combine<const K: usize>(&self, others: [&Self; K], f: impl Fn(usize, f64, [f64; K]) -> f64) -> Self {
        let link = self.link.combine(others.map(|other| &other.link), &f);
        Self { link, motor: self.motor.combine(others.map(|other| &other.motor), &f) }
    }

    fn kicked(&self, slope: &Self, h: &[f64; 1]) -> Self {
        Self { link: self.link.kicked(&slope.link, h), motor: self.motor.kicked(&slope.motor, h) }
    }

    fn largest(&self) -> [f64; 1] {
        let ([link], [motor]) = (self.link.largest(), self.motor.largest());
        if link <= motor { [motor] } else { [link] }
    }

    fn take(&mut self, other: &Self, lanes: &[bool; 1]) {
        self.link.take(&other.link, lanes);
        self.motor.take(&other.motor, lanes);
    }

    fn friction_side(&self) -> &States<N, 1> {
        &self.motor
    }

    fn friction_side_mut(&mut self) -> &mut States<N, 1> {
        &mut self.motor
    }
}

impl<const N: usize> Elasticity<N> {
    /// Torques `s` from the motor sides to the link sides, N m or N.
    #[must_use]
    pub fn torques(&self, motor: &State<N>, link: &State<N>) -> [f64; N] {
        #[cfg(test)]
        super::calls::count(super::calls::Effect::Elasticity);
        core::array::from_fn(|i| {
            let (twist, rate) = (motor.q[i] - link.q[i], motor.qd[i] - link.qd[i]);
            let whole = |stretch: f64| self.stiffness[i] * stretch + self.damping[i] * rate;
            let Some(backlash) = &self.backlash else {
                return whole(twist);
            };
            let stretch = beyond(backlash[i], twist);
            if stretch > 0.0 {
                whole(stretch).max(0.0)
            } else if stretch < 0.0 {
                whole(stretch).min(0.0)
            } else {
                0.0
            }
        })
    }

    /// Energy in the springs, J.
    #[must_use]
    pub fn energy(&self, motor: &State<N>, link: &State<N>) -> f64 {
        let stretch = |i: usize| {
            let twist = motor.q[i] - link.q[i];
            self.backlash.map_or(twist, |backlash| beyond(backlash[i], twist))
        };
        (0..N).map(|i| 0.5 * self.stiffness[i] * stretch(i) * stretch(i)).sum()
    }

    /// Twist at which the springs carry these torques, rad or m; for zero torque, the middle of the backlash.
    fn twist(&self, torques: &[f64; N]) -> [f64; N] {
        core::array::from_fn(|i| {
            let side = if torques[i] == 0.0 { 0.0 } else { torques[i].signum() };
            torques[i] / self.stiffness[i] + self.backlash.map_or(0.0, |backlash| 0.5 * backlash[i] * side)
        })
    }

    /// Natural frequencies of the undriven, undamped arm about `q`, rad/s, in descending order: `2 N`. `N` of them are zero, because the joints turn
    /// freely. `None` if a joint of the arm without rotors moves no mass.
    #[must_use]
    pub fn natural_frequencies(&self, arm: &Arm<N>, q: &[f64; N]) -> Option<Vec<f64>> {
        let mut found: Vec<f64> = spectrum(&self.stiffness, arm, q)?.iter().map(|x| libm::sqrt(x.max(0.0))).collect();
        found.sort_by(|a, b| b.total_cmp(a));
        Some(found)
    }

    /// Highest rate at `q`, 1/s, of an oscillation or of a decay by the dampers.
    #[must_use]
    pub fn fastest(&self, arm: &Arm<N>, q: &[f64; N]) -> Option<f64> {
        let decay = spectrum(&self.damping, arm, q)?.into_iter().fold(0.0, f64::max);
        Some(self.natural_frequencies(arm, q)?.first().map_or(decay, |omega| omega.max(decay)))
    }
}

/// Part of a twist beyond the backlash.
fn beyond(backlash: f64, twist: f64) -> f64 {
    #[cfg(test)]
    super::calls::count(super::calls::Effect::Backlash);
    let half = 0.5 * backlash;
    twist - twist.clamp(-half, half)
}

/// Eigenvalues of `M^-1 [[c, -c], [-c, c]]`, where `M` is the inertia of links and rotors and `c` is diagonal.
fn spectrum<const N: usize>(c: &[f64; N], arm: &Arm<N>, q: &[f64; N]) -> Option<Vec<f64>> {
    let mut bare = arm.mechanism();
    let rotors = bare.take_rotors();
    let links = bare.terms(&Polynomial.sin_cos_all(q), q, &[0.0; N]).mass_matrix;
    let (mut inertia, mut joined) = (DMatrix::<f64>::zeros(2 * N, 2 * N), DMatrix::<f64>::zeros(2 * N, 2 * N));
    inertia.view_mut((0, 0), (N, N)).copy_from(&links);
    for i in 0..N {
        inertia[(N + i, N + i)] = rotors[i];
        (joined[(i, i)], joined[(N + i, N + i)]) = (c[i], c[i]);
        (joined[(i, N + i)], joined[(N + i, i)]) = (-c[i], -c[i]);
    }
    // L^-1 C L^-T, with M = L L^T.
    let l = inertia.cholesky()?.l();
    let half = l.solve_lower_triangular(&joined)?;
    let whole = l.solve_lower_triangular(&half.transpose())?;
    Some(whole.symmetric_eigenvalues().iter().copied().collect())
}

impl<const N: usize> Motors<N> {
    /// Motor sides at rest. The rotors are removed from the arm. The springs hold the arm at `link` against gravity and the wrench at the tip.
    pub(super) fn new(springs: Elasticity<N>, mechanism: &mut Mechanism<N>, link: &State<N>, side: Side) -> Self {
        let inertia = mechanism.take_rotors();
        let terms = mechanism.terms(&Polynomial.sin_cos_all(&link.q), &link.q, &link.qd);
        let twist = springs.twist(&core::array::from_fn(|i| terms.gravity[i] - terms.tip[i]));
        let state = State { q: core::array::from_fn(|i| link.q[i] + twist[i]), qd: link.qd };
        Self { springs, inertia, state, side }
    }
}
