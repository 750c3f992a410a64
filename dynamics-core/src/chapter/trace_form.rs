//! Lagrange's equations from derivatives of the 4x4 transforms (eq. 12.391-12.419).
//!
//! The same terms as [`crate::chapter::lagrange`] and the same torques as [`crate::newton_euler`], by a third method that
//! shares only the model with them: no Jacobian, no angular velocity, no cross product. It exists for
//! comparison. With `0T_r` the pose of link `r` as a 4x4 matrix, the derivative by a joint between base and link inserts a
//! constant operator between the factors (eq. 12.440-12.442):
//!
//! ```text
//! d 0T_r / dq_j          = 0T_j Delta_j jT_r                        j <= r, else 0
//! d2 0T_r / dq_j dq_k    = 0T_j Delta_j jT_k Delta_k kT_r           j <= k <= r
//!
//!           0 -1  0  0                    0  0  0  0
//! Delta_R = 1  0  0  0          Delta_P = 0  0  0  0
//!           0  0  0  0                    0  0  0  1
//!           0  0  0  0                    0  0  0  0
//! ```
//!
//! The chapter puts the operator before the transform of its joint, because there joint `j` acts about the z axis of the frame before.
//! Here the z axis of every frame is the axis of its own joint, so the operator comes after the transform. A body is represented by its
//! pseudo-inertia, the integral of `r r^T dm` over homogeneous positions (eq. 12.401).
//!
//! The sums are evaluated as printed: every trace separately, and every product of 4x4 matrices in full. For six
//! revolute joints that is 59,306 multiplications and 47,081 additions and subtractions. The traces of `D` and `H` need 42,560 of the
//! multiplications, and the derivatives nearly all others. For the same torques [`crate::chapter::lagrange`] needs 7,470 and 7,047, and the
//! recursion 663 and 591 (`dynamics-core/tests/operations.rs` counts and checks these numbers). In double precision one posture
//! uses 10 kB.

mod energies;

use crate::chapter::posture::{CentredBody, Chain};
use crate::joint::JointKind;
use crate::model::Link;
use crate::scalar::Scalar;
use crate::trig::SinCos;
use nalgebra::{Matrix4, SMatrix, Vector3, Vector4};

/// An arm at one posture: its transforms and their first derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transforms<S, const N: usize> {
    bodies: [PseudoInertia<S>; N],
    kinds: [JointKind; N],
    /// `0T_0`, of the first link.
    base: Matrix4<S>,
    /// `[j][r]` is `jT_r`, for `j <= r`.
    between: [[Matrix4<S>; N]; N],
    /// `[r][j]` is `d 0T_r / dq_j`; zero for `j > r` (eq. 12.409).
    first: [[Matrix4<S>; N]; N],
}

/// A body in its link's frame, by moments of homogeneous positions.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PseudoInertia<S> {
    /// Integral of `r r^T dm`: second moments, kg m^2, first moments, kg m, and mass, kg.
    moments: Matrix4<S>,
    mass: S,
    /// Mass centre as a point: fourth entry 1.
    centre: Vector4<S>,
}

impl<S: Scalar, const N: usize> Transforms<S, N> {
    /// All transforms and first derivatives at one posture.
    ///
    /// Inputs as [`crate::InverseDynamics::inverse_dynamics`]; lengths in m.
    #[must_use]
    pub fn new(chain: &Chain<S, N>, turn: &[SinCos<S>; N], q: &[S; N]) -> Self {
        let links = chain.model().links();
        let kinds = links.map(|link| link.kind);
        let one: [Matrix4<S>; N] = core::array::from_fn(|i| transform(&links[i], turn[i], q[i]));
        let mut between = [[Matrix4::identity(); N]; N];
        for j in 0..N {
            for r in j + 1..N {
                between[j][r] = if r == j + 1 { one[r] } else { product(&between[j][r - 1], &one[r]) };
            }
        }
        let pose: [Matrix4<S>; N] = core::array::from_fn(|j| product(&one[0], &between[0][j]));
        let mut first = [[Matrix4::zeros(); N]; N];
        for r in 0..N {
            for j in 0..=r {
                first[r][j] = derived(&pose[j], kinds[j], &between[j][r]);
            }
        }
        Self { bodies: chain.bodies().map(|body| PseudoInertia::of(&body)), kinds, base: one[0], between, first }
    }

    /// `d2 0T_r / dq_j dq_k`, for `j` and `k` up to `r`.
    fn second(&self, r: usize, j: usize, k: usize) -> Matrix4<S> {
        let (inner, outer) = (j.min(k), j.max(k));
        derived(&self.first[outer][inner], self.kinds[outer], &self.between[outer][r])
    }

    /// Inertia matrix: `D_ij = sum_r tr(d0T_r/dq_i Ibar_r d0T_r^T/dq_j)` (eq. 12.393, 12.417).
    ///
    /// The sum begins at the greater of `i` and `j`. Without rotors. kg m^2, kg m, kg. O(N^3).
    #[must_use]
    pub fn mass_matrix(&self) -> SMatrix<S, N, N> {
        let mut d = SMatrix::<S, N, N>::zeros();
        for i in 0..N {
            for j in 0..N {
                for r in i.max(j)..N {
                    d[(i, j)] += trace(&self.first[r][i], &self.bodies[r].moments, &self.first[r][j]);
                }
            }
        }
        d
    }

    /// `H_ijk = sum_r tr(d2 0T_r/dq_j dq_k Ibar_r d0T_r^T/dq_i)`, indexed `[i][j][k]` (eq. 12.394, 12.418, 12.450).
    ///
    /// Equal to the Christoffel symbol `Gamma^i_jk` (eq. 12.281) entry by entry. Torque on joint `i` per `qd_j qd_k`. O(N^4).
    #[must_use]
    pub fn coupling(&self) -> [[[S; N]; N]; N] {
        let mut h = [[[S::zero(); N]; N]; N];
        for r in 0..N {
            for j in 0..=r {
                for k in 0..=r {
                    let second = self.second(r, j, k);
                    for i in 0..=r {
                        h[i][j][k] += trace(&second, &self.bodies[r].moments, &self.first[r][i]);
                    }
                }
            }
        }
        h
    }

    /// Torques that hold the arm's weight, N m or N: `G_i = -sum_r m_r g^T d0T_r/dq_i r_r` (eq. 12.395, 12.419).
    ///
    /// `g` is the gravitational acceleration in the base frame, m/s^2: a free vector, whose fourth entry is zero. O(N^2).
    #[must_use]
    pub fn gravity(&self, g: &Vector3<S>) -> [S; N] {
        core::array::from_fn(|i| {
            let mut torque = S::zero();
            for r in i..N {
                let body = &self.bodies[r];
                let moved =
                    |row: usize| (0..4).fold(S::zero(), |sum, k| sum + self.first[r][i][(row, k)] * body.centre[k]);
                torque -= body.mass * (g.x * moved(0) + g.y * moved(1) + g.z * moved(2));
            }
            torque
        })
    }

    /// Actuator torques for a wanted motion: `Q_i = sum_j D_ij qdd_j + sum_jk H_ijk qd_j qd_k + G_i` (eq. 12.416).
    ///
    /// No contact and no rotors. rad/s, rad/s^2, m/s^2 in, N m out (m/s, m/s^2, N for a prismatic joint). O(N^4); no branch on
    /// data, no division.
    #[must_use]
    pub fn inverse_dynamics(&self, qd: &[S; N], qdd: &[S; N], g: &Vector3<S>) -> [S; N] {
        let (d, h, weight) = (self.mass_matrix(), self.coupling(), self.gravity(g));
        core::array::from_fn(|i| {
            let mut tau = weight[i];
            for j in 0..N {
                tau += d[(i, j)] * qdd[j];
                for k in 0..N {
                    tau += h[i][j][k] * qd[j] * qd[k];
                }
            }
            tau
        })
    }
}

impl<S: Scalar> PseudoInertia<S> {
    /// `[I, m c; m c^T, m]` with `I = 1/2 tr(I_C) 1 - I_C + m c c^T` (eq. 12.401).
    fn of(body: &CentredBody<S>) -> Self {
        let (m, c, about_centre) = (body.mass, body.centre, &body.inertia);
        let half_trace = (about_centre.m11 + about_centre.m22 + about_centre.m33) * S::literal(0.5);
        let centre = Vector4::new(c.x, c.y, c.z, S::one());
        let moments = Matrix4::from_fn(|i, j| {
            let spread = match (i, j) {
                (3, _) | (_, 3) => S::zero(),
                _ if i == j => half_trace - about_centre[(i, j)],
                _ => -about_centre[(i, j)],
            };
            spread + m * centre[i] * centre[j]
        });
        Self { moments, mass: m, centre }
    }
}

/// `parent_from_link` at a joint position, as a 4x4 matrix: the link's placement, then its joint's own motion.
fn transform<S: Scalar>(link: &Link<S>, turn: SinCos<S>, q: S) -> Matrix4<S> {
    let (zero, one) = (S::zero(), S::one());
    let placement = Matrix4::from_fn(|i, j| match (i, j) {
        (3, 3) => one,
        (3, _) => zero,
        (_, 3) => link.translation[i],
        _ => link.rotation[(i, j)],
    });
    let mut motion = Matrix4::identity();
    match link.kind {
        JointKind::Revolute => {
            (motion[(0, 0)], motion[(0, 1)]) = (turn.cos, -turn.sin);
            (motion[(1, 0)], motion[(1, 1)]) = (turn.sin, turn.cos);
        }
        JointKind::Prismatic => motion[(2, 3)] = q,
    }
    product(&placement, &motion)
}

/// `Delta_R` or `Delta_P`: the operator that differentiates a turn about z or a slide along z.
fn operator<S: Scalar>(kind: JointKind) -> Matrix4<S> {
    let mut delta = Matrix4::zeros();
    match kind {
        JointKind::Revolute => (delta[(0, 1)], delta[(1, 0)]) = (-S::one(), S::one()),
        JointKind::Prismatic => delta[(2, 3)] = S::one(),
    }
    delta
}

/// `A Delta B`: the derivative of `A B` by the joint whose motion ends `A`.
fn derived<S: Scalar>(a: &Matrix4<S>, kind: JointKind, b: &Matrix4<S>) -> Matrix4<S> {
    product(&product(a, &operator(kind)), b)
}

/// `A B`: 64 multiplications, 48 additions.
fn product<S: Scalar>(a: &Matrix4<S>, b: &Matrix4<S>) -> Matrix4<S> {
    Matrix4::from_fn(|i, j| {
        a[(i, 0)] * b[(0, j)] + a[(i, 1)] * b[(1, j)] + a[(i, 2)] * b[(2, j)] + a[(i, 3)] * b[(3, j)]
    })
}

/// `tr(A I B^T)`: 80 multiplications.
fn trace<S: Scalar>(a: &Matrix4<S>, moments: &Matrix4<S>, b: &Matrix4<S>) -> S {
    let half = product(a, moments);
    half.iter().zip(b.iter()).fold(S::zero(), |sum, (x, y)| sum + *x * *y)
}
