//! Energies and the derivatives of the Lagrangian by traces, term by term as the proof has them (eq. 12.396-12.413).

use super::{Transforms, product, trace};
use crate::scalar::Scalar;
use nalgebra::{Matrix4, Vector3, Vector4};

impl<S: Scalar, const N: usize> Transforms<S, N> {
    /// `0T_r`.
    fn pose(&self, r: usize) -> Matrix4<S> {
        if r == 0 { self.base } else { product(&self.base, &self.between[0][r]) }
    }

    /// Position of a point of link `r` in the base frame, m: `0r_P = 0T_r r_P` (eq. 12.396).
    ///
    /// `point` is in the link's frame, m; links are counted from 0.
    #[must_use]
    pub fn position(&self, r: usize, point: &Vector3<S>) -> Vector3<S> {
        moved(&self.pose(r), &homogeneous(point))
    }

    /// Velocity of a point of link `r` in the base frame, m/s: `sum_j d0T_r/dq_j qd_j r_P` (eq. 12.397).
    #[must_use]
    pub fn velocity(&self, r: usize, point: &Vector3<S>, qd: &[S; N]) -> Vector3<S> {
        let at = homogeneous(point);
        (0..=r).fold(Vector3::zeros(), |sum, j| sum + moved(&self.first[r][j], &at) * qd[j])
    }

    /// Kinetic energy of link `r`, J: `K_r = 1/2 sum_jk tr(d0T_r/dq_j Ibar_r d0T_r^T/dq_k) qd_j qd_k` (eq. 12.402).
    #[must_use]
    pub fn link_kinetic_energy(&self, r: usize, qd: &[S; N]) -> S {
        let mut twice = S::zero();
        for j in 0..=r {
            for k in 0..=r {
                twice += trace(&self.first[r][j], &self.bodies[r].moments, &self.first[r][k]) * qd[j] * qd[k];
            }
        }
        twice * S::literal(0.5)
    }

    /// Kinetic energy of the arm without rotors, J: the sum of the links' (eq. 12.403).
    #[must_use]
    pub fn kinetic_energy(&self, qd: &[S; N]) -> S {
        (0..N).fold(S::zero(), |sum, r| sum + self.link_kinetic_energy(r, qd))
    }

    /// Potential energy, J, zero for masses at the base's origin: `V = -sum_r m_r g^T 0T_r r_r` (eq. 12.405-12.406).
    ///
    /// `g` is the gravitational acceleration in the base frame, m/s^2.
    #[must_use]
    pub fn potential_energy(&self, g: &Vector3<S>) -> S {
        (0..N)
            .fold(S::zero(), |sum, r| sum - self.bodies[r].mass * g.dot(&moved(&self.pose(r), &self.bodies[r].centre)))
    }

    /// The Lagrangian, J: `K - V` (eq. 12.407).
    #[must_use]
    pub fn lagrangian(&self, qd: &[S; N], g: &Vector3<S>) -> S {
        self.kinetic_energy(qd) - self.potential_energy(g)
    }

    /// Generalized momenta, N m s or N s: `dL/dqd_i = sum_r sum_j tr(d0T_r/dq_j Ibar_r d0T_r^T/dq_i) qd_j` (eq. 12.408).
    #[must_use]
    pub fn momenta(&self, qd: &[S; N]) -> [S; N] {
        core::array::from_fn(|i| {
            let mut momentum = S::zero();
            for r in i..N {
                for j in 0..=r {
                    momentum += trace(&self.first[r][j], &self.bodies[r].moments, &self.first[r][i]) * qd[j];
                }
            }
            momentum
        })
    }

    /// Rates of the generalized momenta, N m or N: `d/dt dL/dqd_i`, three sums (eq. 12.411).
    #[must_use]
    pub fn momentum_rates(&self, qd: &[S; N], qdd: &[S; N]) -> [S; N] {
        let (accelerated, moved) = (self.momenta(qdd), self.kinetic_slopes(qd));
        core::array::from_fn(|i| {
            let mut rate = accelerated[i] + moved[i];
            for r in i..N {
                for j in 0..=r {
                    for k in 0..=r {
                        let second = self.second(r, j, k);
                        rate += trace(&second, &self.bodies[r].moments, &self.first[r][i]) * qd[j] * qd[k];
                    }
                }
            }
            rate
        })
    }

    /// Slopes of the Lagrangian over the joint positions, N m or N: `dL/dq_i` (eq. 12.412-12.413).
    #[must_use]
    pub fn lagrangian_slopes(&self, qd: &[S; N], g: &Vector3<S>) -> [S; N] {
        let (moved, weight) = (self.kinetic_slopes(qd), self.gravity(g));
        core::array::from_fn(|i| moved[i] - weight[i])
    }

    /// `sum_r sum_jk tr(d2 0T_r/dq_i dq_j Ibar_r d0T_r^T/dq_k) qd_j qd_k`: third sum of 12.411, first of 12.413.
    fn kinetic_slopes(&self, qd: &[S; N]) -> [S; N] {
        core::array::from_fn(|i| {
            let mut slope = S::zero();
            for r in i..N {
                for j in 0..=r {
                    let second = self.second(r, i, j);
                    for k in 0..=r {
                        slope += trace(&second, &self.bodies[r].moments, &self.first[r][k]) * qd[j] * qd[k];
                    }
                }
            }
            slope
        })
    }
}

/// A point with a one as its fourth entry.
fn homogeneous<S: Scalar>(point: &Vector3<S>) -> Vector4<S> {
    Vector4::new(point.x, point.y, point.z, S::one())
}

/// The first three entries of `A r`.
fn moved<S: Scalar>(a: &Matrix4<S>, r: &Vector4<S>) -> Vector3<S> {
    Vector3::from_fn(|row, _| (0..4).fold(S::zero(), |sum, k| sum + a[(row, k)] * r[k]))
}
