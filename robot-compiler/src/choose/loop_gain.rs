//! Feedback strength of a loop with a reduced model, relative to the same loop with the full model.
//!
//! The feedback demands an acceleration, `Kd e' + Kp e`. A matrix `B(q)` turns it into a torque, and the arm's inertia
//! `M(q)` turns the torque back into an acceleration. About the reference, with weight and velocity terms set aside,
//!
//! ```text
//! M e'' + B (Kd e' + Kp e) = 0
//! ```
//!
//! In computed torque, `B` is the model's inertia matrix: `M` itself if the model is full. In the other laws it is the
//! diagonal of fixed inertias. Omitting a term that has inertia makes `B` smaller. With equal gains on every joint, each
//! eigenvalue `g` of `B_full^-1 B_less` is the loop gain of a mode. The mode has `g` times the stiffness, so a steady torque
//! moves it `1 / g` times as far. It has `sqrt(g)` times the natural frequency and damping ratio. Both matrices are
//! symmetric, and no omitted term has negative inertia, so `g` lies between 0 and 1.

use crate::describe::scene::{ModelSpec, SceneFile};
use dynamics_core::control::FeedbackInertia;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::{Dynamics, Live, Model, SinCos};
use nalgebra::{DMatrix, SMatrix, SVector};

/// The least loop gain of a model that lacks some of its terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopGain {
    /// Least eigenvalue of `B_full^-1 B_less`, 0 to 1.
    pub least: f64,
    /// The joint with the most kinetic energy in that mode, counted from 0; the first joint if the loop gain is 1.
    pub joint: usize,
}

impl LoopGain {
    /// Loop gain of the full model.
    pub const FULL: Self = Self { least: 1.0, joint: 0 };

    /// Least loop gain with which a term may be dropped. A mode tuned for critical damping then has a damping ratio of
    /// 0.71 and overshoots by 4 %, and a steady torque moves it twice as far.
    pub const LEAST: f64 = 0.5;

    /// True if the feedback is too weak with this loop gain. NaN counts as too weak.
    #[must_use]
    pub fn is_too_weak(&self) -> bool {
        self.least.is_nan() || self.least < Self::LEAST
    }

    /// The weaker of two.
    #[must_use]
    pub(super) fn weaker(self, other: Self) -> Self {
        if other.least < self.least { other } else { self }
    }

    /// Loop gain at one posture, from `B` of the full and of the reduced model. Zero if the full model's matrix is
    /// singular: nothing is known about such a loop.
    pub(super) fn of<const N: usize>(full: &SMatrix<f64, N, N>, less: &SMatrix<f64, N, N>) -> Self {
        let [full, less] = [full, less].map(|matrix| DMatrix::from_fn(N, N, |i, j| matrix[(i, j)]));
        let scale: Vec<f64> = (0..N).map(|i| full[(i, i)]).collect();
        let weak = Self { least: 0.0, joint: 0 };
        let Some(factor) = full.cholesky() else { return weak };
        // L^-1 B L^-T has the eigenvalues of the pair, and is symmetric.
        let Some(half) = factor.l().solve_lower_triangular(&less) else { return weak };
        let Some(whole) = factor.l().solve_lower_triangular(&half.transpose()) else { return weak };
        let modes = whole.symmetric_eigen();
        let (mode, least) = modes
            .eigenvalues
            .iter()
            .copied()
            .enumerate()
            .fold((0, f64::INFINITY), |weakest, (i, g)| if g < weakest.1 { (i, g) } else { weakest });
        let column = modes.eigenvectors.column(mode).into_owned();
        let Some(motion) = factor.l().transpose().solve_upper_triangular(&column) else { return weak };
        let energy = |i: usize| scale[i] * motion[i] * motion[i];
        let joint = (0..N).max_by(|&a, &b| energy(a).total_cmp(&energy(b))).unwrap_or(0);
        Self { least, joint }
    }
}

/// Matrix that turns the commanded acceleration of the feedback into torques.
pub(super) enum Feedback<const N: usize> {
    /// The model's inertia matrix.
    Model(Box<Dynamics<f64, N>>),
    /// Fixed inertias.
    Fixed(SVector<f64, N>),
}

impl<const N: usize> Feedback<N> {
    /// Feedback matrix of a scene's law with this model.
    pub(super) fn new(file: &SceneFile, model: &Model<f64, N>, spec: &ModelSpec) -> Self {
        if file.control.law.traits().feedback == FeedbackInertia::Model {
            Self::Model(Box::new(Dynamics::new(*model, spec.scene(model))))
        } else {
            Self::Fixed(file.fixed_inertia(model, spec))
        }
    }

    /// The matrix `B`.
    pub(super) fn matrix(&self, turn: &[SinCos<f64>; N], q: &[f64; N], live: &Live<f64, N>) -> SMatrix<f64, N, N> {
        match self {
            Self::Model(dynamics) => mass_matrix(dynamics, turn, q, live),
            Self::Fixed(inertia) => SMatrix::from_diagonal(inertia),
        }
    }
}
