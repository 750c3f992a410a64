//! The reference of a tick.

use crate::scalar::Real;

/// Desired joint positions, velocities and accelerations of one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference<S, const N: usize> {
    /// Joint position, rad or m.
    pub q: [S; N],
    /// Joint velocity, rad/s or m/s.
    pub qd: [S; N],
    /// Joint acceleration, rad/s^2 or m/s^2.
    pub qdd: [S; N],
}

impl<S: Real, const N: usize> Reference<S, N> {
    /// At rest at `q`.
    #[must_use]
    pub fn at_rest(q: [S; N]) -> Self {
        Self { q, qd: [S::zero(); N], qdd: [S::zero(); N] }
    }

    /// The same reference in another scalar, each number through [`crate::Scalar::literal`].
    #[must_use]
    pub fn cast<T: Real>(&self) -> Reference<T, N> {
        let cast = |x: [S; N]| x.map(|x| T::literal(x.to_f64()));
        Reference { q: cast(self.q), qd: cast(self.qd), qdd: cast(self.qdd) }
    }
}
