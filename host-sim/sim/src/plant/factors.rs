//! Solution of the equations of motion by a square-root-free Cholesky factorisation, with all joints free or some of them held.
//!
//! The source is generic in its scalar and has no data-dependent branch, so it can be traced. A held joint is one whose inverse pivot is set to zero.
//! Its column then takes part in no elimination, and its acceleration is zero.

use dynamics_core::Field;
use nalgebra::SMatrix;

/// Accelerations, and the pivots of their solution. The accelerations are meaningful only if all pivots are above zero.
#[derive(Clone, Copy, Debug)]
pub struct Solution<S, const N: usize> {
    /// Joint acceleration, rad/s^2 or m/s^2.
    pub qdd: [S; N],
    /// Inertia that the joint feels while the joints before it are free, kg m^2 or kg.
    pub pivot: [S; N],
}

/// As [`Solution`], for an arm with held joints.
#[derive(Clone, Copy, Debug)]
pub struct HeldSolution<S, const N: usize> {
    /// Joint acceleration, rad/s^2 or m/s^2; zero for a held joint.
    pub qdd: [S; N],
    /// Inertia that the joint feels while the free joints before it are free, kg m^2 or kg.
    pub pivot: [S; N],
    /// For a held joint: the torque that its holder must bear, N m or N. For a free joint: the right-hand side after elimination, which accelerates
    /// its pivot.
    pub load: [S; N],
}

/// Factors of a symmetric matrix `A = L P L^T`, and a right-hand side after elimination.
struct Factors<S, const N: usize> {
    /// Below the diagonal, `L`.
    ratio: SMatrix<S, N, N>,
    /// On and below the diagonal, `L P`.
    whole: SMatrix<S, N, N>,
    /// Inverse of each pivot; zero for a held joint.
    inverse: [S; N],
    x: [S; N],
}

impl<S: Field, const N: usize> Factors<S, N> {
    /// Factorises `a`, of which only the lower triangle is read, and eliminates `b`. `free` is one for a joint that takes part, zero for a held one.
    fn new(a: &SMatrix<S, N, N>, b: &[S; N], free: &[S; N]) -> Self {
        let (mut ratio, mut whole) = (*a, *a);
        let mut inverse = [S::zero(); N];
        let mut x = *b;
        for j in 0..N {
            for k in 0..j {
                let mut rest = whole[(j, k)];
                for m in 0..k {
                    rest -= whole[(j, m)] * ratio[(k, m)];
                }
                whole[(j, k)] = rest;
            }
            let mut pivot = whole[(j, j)];
            for k in 0..j {
                let own = whole[(j, k)] * inverse[k];
                pivot -= own * whole[(j, k)];
                x[j] -= own * x[k];
                ratio[(j, k)] = own;
            }
            whole[(j, j)] = pivot;
            inverse[j] = free[j] / pivot;
        }
        Self { ratio, whole, inverse, x }
    }

    fn pivots(&self) -> [S; N] {
        core::array::from_fn(|i| self.whole[(i, i)])
    }
}

/// Solution `x` of `A x = b`; reads the lower triangle.
pub(super) fn solve<S: Field, const N: usize>(a: &SMatrix<S, N, N>, b: &[S; N]) -> Solution<S, N> {
    let factors = Factors::new(a, b, &[S::one(); N]);
    let mut x = factors.x;
    for j in (0..N).rev() {
        x[j] *= factors.inverse[j];
        for k in j + 1..N {
            let carried = factors.ratio[(k, j)] * x[k];
            x[j] -= carried;
        }
    }
    Solution { qdd: x, pivot: factors.pivots() }
}

/// Solves the rows of `A x = b` for which `free` is one, with `x` zero in the others. For those, also returns the residual `b - A x`.
pub(super) fn solve_held<S: Field, const N: usize>(
    a: &SMatrix<S, N, N>,
    b: &[S; N],
    free: &[S; N],
) -> HeldSolution<S, N> {
    let factors = Factors::new(a, b, free);
    let (mut load, mut x) = (factors.x, [S::zero(); N]);
    for j in (0..N).rev() {
        for k in j + 1..N {
            let carried = factors.whole[(k, j)] * x[k];
            load[j] -= carried;
        }
        x[j] = load[j] * factors.inverse[j];
    }
    HeldSolution { qdd: x, pivot: factors.pivots(), load }
}

#[cfg(test)]
mod tests {
    use super::{solve, solve_held};
    use nalgebra::SMatrix;
    use proptest::prelude::*;

    /// A positive definite matrix.
    fn matrix(entries: [f64; 16]) -> SMatrix<f64, 4, 4> {
        let a = SMatrix::<f64, 4, 4>::from_row_slice(&entries);
        a * a.transpose() + SMatrix::identity() * 0.1
    }

    proptest! {
        #[test]
        fn held_rows_bear_what_the_free_ones_leave(
            entries in prop::array::uniform16(-1.0..1.0),
            b in prop::array::uniform4(-5.0..5.0),
            held in prop::array::uniform4(any::<bool>()),
        ) {
            let a = matrix(entries);
            let free = held.map(|held| if held { 0.0 } else { 1.0 });
            let found = solve_held(&a, &b, &free);
            let left = SMatrix::<f64, 4, 1>::from(b) - a * SMatrix::<f64, 4, 1>::from(found.qdd);
            for i in 0..4 {
                if held[i] {
                    prop_assert_eq!(found.qdd[i].abs().to_bits(), 0);
                    prop_assert!((left[i] - found.load[i]).abs() < 1e-9, "{} and {}", left[i], found.load[i]);
                } else {
                    prop_assert!(left[i].abs() < 1e-9, "row {}: {}", i, left[i]);
                }
            }
            prop_assert!(found.pivot.iter().all(|pivot| *pivot > 0.0));
            let all = solve_held(&a, &b, &[1.0; 4]);
            for (held, plain) in all.qdd.into_iter().zip(solve(&a, &b).qdd) {
                prop_assert!((held - plain).abs() < 1e-9 * (1.0 + plain.abs()));
            }
        }
    }
}
