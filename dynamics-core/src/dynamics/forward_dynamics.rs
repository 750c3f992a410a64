//! Accelerations from torques, by factoring the inertia matrix.
//!
//! The factorisation goes from the tip to the base, `D = L^T P L` with a unit lower `L` and a diagonal `P`. That
//! order keeps the zeros of the matrix (a wrist is not coupled to some of the joints before it). Its pivots also have a meaning:
//! `P_i` is the inertia that joint `i` feels when the joints beyond it are free. The index of a pivot that
//! is not above zero names a joint that moves nothing.
//!
//! [`acceleration`] and [`factored`] only compute. They are written on [`Field`] without a branch on data, so they can be
//! traced. [`forward_dynamics`] and [`solve`] also check the pivots, which needs an order.

use crate::mass_matrix::mass_matrix;
use crate::newton_euler::InverseDynamics;
use crate::scalar::{Field, Real};
use crate::scene::{Dynamics, Live};
use crate::trig::SinCos;
use nalgebra::SMatrix;

/// Accelerations, and the pivots of the inertia matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acceleration<S, const N: usize> {
    /// Joint acceleration, rad/s^2 or m/s^2. Without meaning, finite or not, unless every pivot is above zero.
    pub qdd: [S; N],
    /// Inertia that the joint feels with the joints beyond it free, kg m^2 or kg.
    pub pivot: [S; N],
}

/// A joint that moves no inertia: the inertia matrix cannot be inverted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular {
    /// The joint, counted from 0; the joints beyond it have valid pivots.
    pub joint: usize,
}

impl core::fmt::Display for Singular {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "joint {} moves neither mass nor rotor: the inertia matrix is singular", self.joint + 1)
    }
}

impl core::error::Error for Singular {}

impl<S: Real, const N: usize> Acceleration<S, N> {
    /// The accelerations, if every pivot is above zero.
    ///
    /// # Errors
    /// [`Singular`]: names the outermost joint whose pivot is not above zero or not finite.
    pub fn checked(self) -> Result<[S; N], Singular> {
        match self.pivot.iter().rposition(|&pivot| !(pivot > S::zero() && pivot.is_finite())) {
            None => Ok(self.qdd),
            Some(joint) => Err(Singular { joint }),
        }
    }
}

/// Joint accelerations under the actuator torques `tau`.
///
/// `qdd = D(q)^{-1} (tau - C(q, qd) qd - G(q) + J^T w)`    (eq. 12.216 solved for the acceleration)
///
/// | name | quantity | unit | shape |
/// |---|---|---|---|
/// | `turn`, `q`, `qd`, `live` | as [`InverseDynamics::inverse_dynamics`] | | N |
/// | `tau` | actuator torque or force | N m, N | N |
/// | return | joint acceleration | rad/s^2, m/s^2 | N |
///
/// O(N^3), with N divisions. At six joints this still needs fewer operations than the articulated-body algorithm, which is O(N).
///
/// # Errors
/// [`Singular`]: the inertia matrix is not positive definite.
pub fn forward_dynamics<S: Real, const N: usize>(
    dynamics: &Dynamics<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    tau: &[S; N],
    live: &Live<S, N>,
) -> Result<[S; N], Singular> {
    acceleration(dynamics, turn, q, qd, tau, live).checked()
}

/// As [`forward_dynamics`], but returns the pivots unchecked: no branch on data.
pub fn acceleration<S: Field, const N: usize>(
    dynamics: &Dynamics<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    tau: &[S; N],
    live: &Live<S, N>,
) -> Acceleration<S, N> {
    let at_rest = dynamics.inverse_dynamics(turn, q, qd, &[S::zero(); N], live);
    let rest = core::array::from_fn(|i| tau[i] - at_rest[i]);
    factored(&mass_matrix(dynamics, turn, q, live), &rest)
}

/// `x` with `A x = b` for a symmetric positive definite `A`; the lower triangle is read.
///
/// # Errors
/// [`Singular`]: a pivot is not above zero.
pub fn solve<S: Real, const N: usize>(a: &SMatrix<S, N, N>, b: &[S; N]) -> Result<[S; N], Singular> {
    factored(a, b).checked()
}

/// As [`solve`], but returns the pivots unchecked: no branch on data.
///
/// `A = L^T P L` from the last row to the first. One division a pivot: its reciprocal is multiplied from there on
/// (N = 6: 86 multiplications, 65 subtractions, 6 divisions).
pub fn factored<S: Field, const N: usize>(a: &SMatrix<S, N, N>, b: &[S; N]) -> Acceleration<S, N> {
    // Below the diagonal: the rest of A, then L.
    let mut l = *a;
    let mut x = *b;
    let mut inverse = [S::zero(); N];
    for k in (0..N).rev() {
        inverse[k] = S::one() / l[(k, k)];
        for i in (0..k).rev() {
            let ratio = l[(k, i)] * inverse[k];
            for j in 0..=i {
                let taken = ratio * l[(k, j)];
                l[(i, j)] -= taken;
            }
            x[i] -= ratio * x[k];
            l[(k, i)] = ratio;
        }
    }
    for k in 0..N {
        x[k] *= inverse[k];
        for i in 0..k {
            let carried = l[(k, i)] * x[i];
            x[k] -= carried;
        }
    }
    Acceleration { qdd: x, pivot: core::array::from_fn(|i| l[(i, i)]) }
}
