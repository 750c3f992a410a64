//! Accelerations from torques, by factoring the inertia matrix.

use crate::mass_matrix::mass_matrix;
use crate::newton_euler::InverseDynamics;
use crate::scalar::Real;
use crate::scene::{Dynamics, Live};
use crate::trig::SinCos;
use nalgebra::SMatrix;

/// Joint accelerations under the actuator torques `tau`, or `None` if the inertia matrix is not positive definite.
///
/// `qdd = D(q)^{-1} (tau - C(q, qd) qd - G(q) + J^T w)`    (eq. 12.216 solved for the acceleration)
///
/// | name | quantity | unit | shape |
/// |---|---|---|---|
/// | `turn`, `q`, `qd`, `live` | as [`InverseDynamics::inverse_dynamics`] | | N |
/// | `tau` | actuator torque or force | N m, N | N |
/// | return | joint acceleration | rad/s^2, m/s^2 | N |
///
/// O(N^3), with `N (N + 1) / 2` divisions at most.
pub fn forward_dynamics<S: Real, const N: usize>(
    dynamics: &Dynamics<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    tau: &[S; N],
    live: &Live<S, N>,
) -> Option<[S; N]> {
    let at_rest = dynamics.inverse_dynamics(turn, q, qd, &[S::zero(); N], live);
    let rest = core::array::from_fn(|i| tau[i] - at_rest[i]);
    solve(&mass_matrix(dynamics, turn, q, live), &rest)
}

/// `x` with `A x = b` for a symmetric positive definite `A`, or `None` if a pivot is not above zero.
///
/// `A = L D L^T`, without square roots; only the lower triangle is read.
pub fn solve<S: Real, const N: usize>(a: &SMatrix<S, N, N>, b: &[S; N]) -> Option<[S; N]> {
    let mut l = *a;
    let mut pivot = [S::zero(); N];
    for j in 0..N {
        let mut d = a[(j, j)];
        for k in 0..j {
            d -= l[(j, k)] * l[(j, k)] * pivot[k];
        }
        if d <= S::zero() || !d.is_finite() {
            return None;
        }
        pivot[j] = d;
        for i in j + 1..N {
            let mut x = a[(i, j)];
            for k in 0..j {
                x -= l[(i, k)] * l[(j, k)] * pivot[k];
            }
            l[(i, j)] = x / d;
        }
    }
    let mut x = *b;
    for i in 0..N {
        for k in 0..i {
            x[i] -= l[(i, k)] * x[k];
        }
    }
    for i in 0..N {
        x[i] = x[i] / pivot[i];
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            x[i] -= l[(k, i)] * x[k];
        }
    }
    Some(x)
}
