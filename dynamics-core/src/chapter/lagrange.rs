//! Lagrange's equations from the Jacobians of the links: `D(q) qdd + C(q, qd) qd + G(q) = tau + J^T w` (eq. 12.214-12.241).
//!
//! There are no finite differences: every derivative below is a cross product. With `k` the axis and `o` the origin of
//! a joint, `r` the mass centre of link `i`, and joints counted from the base, the columns of the Jacobian of link `i`
//! are, for `j <= i`,
//!
//! ```text
//! c_D^(j) = k_j x (r - o_j)   c_R^(j) = k_j       revolute      12.224, 12.225
//! c_D^(j) = k_j               c_R^(j) = 0         prismatic
//! ```
//!
//! and zero for `j > i`. A revolute joint `l` turns everything beyond it about `k_l` as one body, a prismatic one shifts it:
//!
//! ```text
//! dc_D^(j)/dq_l = k_min x c_D^(max)        min, max of j and l; joint min revolute, else 0
//! dc_R^(j)/dq_l = k_l x c_R^(j)            l < j and revolute, else 0
//! dI/dq_l       = [k_l]x I - I [k_l]x      l <= i and revolute, else 0
//! ```
//!
//! The first: let joint `min` move. It carries the axis of joint `max`, its origin and `r` alike, so `c_D^(max)` turns as a
//! whole; and `dc_D^(min)/dq_max` is the same vector, both being the second derivative of `r`. Angular velocity is the
//! derivative of no coordinate, so the second line has no such symmetry: the axis of joint `j` stays where it is when a joint
//! beyond it moves.
//!
//! The last two together: seen from link `i`, which turns with `l`, an axis before `l` turns in the opposite direction and one beyond it
//! stays, and the tensor stays too. So `d(c_R^(j) . I c_R^(k))/dq_l` is `(c_R^(j) x k_l) . I c_R^(k)` for `j < l`, and the
//! same with `j` and `k` exchanged, added.
//!
//! Reflected rotor inertias are not part of a posture. They are constant: to count them, add `rotor[i]` to `D_ii`,
//! `rotor[i] * qdd[i]` to torque `i` and `rotor[i] * qd[i]^2 / 2` to the kinetic energy; no Christoffel symbol changes.
//!
//! This is far more work than [`crate::newton_euler`] for the same torques. It is meant for reading and for comparison. Corrections to the
//! chapter used here: no factor 1/2 on the rotational part of `D` (12.219, 12.229) nor a second one inside 12.226; the sign of
//! `G` (12.221, 12.239); 12.220 (12.238) is a sum over `j` and `k` with the velocities, not a matrix to be multiplied by them;
//! the tensor in 12.222 is in base axes.

use crate::chapter::posture::{LinkPosture, Posture};
use crate::geometry::apply;
use crate::inertia::Wrench;
use crate::joint::JointKind;
pub use crate::kinematics::Jacobian;
use crate::scalar::Scalar;
use nalgebra::{SMatrix, Vector3};

/// Jacobian of every link at its mass centre, base first (eq. 12.223-12.225).
///
/// Base frame; columns of joints beyond the link are zero. O(N^2).
#[must_use]
pub fn link_jacobians<S: Scalar, const N: usize>(posture: &Posture<S, N>) -> [Jacobian<S, N>; N] {
    core::array::from_fn(|i| jacobian(posture, i, &posture.links[i].centre))
}

/// Jacobian of the last link at the tip's origin, base frame (eq. 12.223-12.225). O(N).
#[must_use]
pub fn tip_jacobian<S: Scalar, const N: usize>(posture: &Posture<S, N>) -> Jacobian<S, N> {
    jacobian(posture, N - 1, &posture.tip.translation)
}

/// Jacobian of a point fixed to link `i`.
fn jacobian<S: Scalar, const N: usize>(posture: &Posture<S, N>, i: usize, point: &Vector3<S>) -> Jacobian<S, N> {
    let mut columns = Jacobian { linear: [Vector3::zeros(); N], angular: [Vector3::zeros(); N] };
    for j in 0..=i {
        let link = &posture.links[j];
        columns.linear[j] = match link.kind {
            JointKind::Revolute => link.axis.cross(&(point - link.origin)),
            JointKind::Prismatic => link.axis,
        };
        columns.angular[j] = turning_axis(link);
    }
    columns
}

/// Kinetic energy, J: `K = 1/2 sum_i (m_i v_i . v_i + omega_i . 0I_i omega_i)` (eq. 12.226 without its inner factor 1/2).
///
/// Link by link, without `D`. `qd` in rad/s or m/s. O(N^2).
#[must_use]
pub fn kinetic_energy<S: Scalar, const N: usize>(posture: &Posture<S, N>, qd: &[S; N]) -> S {
    let mut twice = S::zero();
    for (link, jacobian) in posture.links.iter().zip(&link_jacobians(posture)) {
        let (v, omega) = (jacobian.velocity(qd), jacobian.angular_velocity(qd));
        twice += link.mass * v.dot(&v) + omega.dot(&apply(&link.inertia, &omega));
    }
    twice * S::literal(0.5)
}

/// Potential energy, J: `V = -sum_i m_i g . r_i`, zero for masses at the base origin (eq. 12.230-12.231).
///
/// `g` is the gravitational acceleration in the base frame, m/s^2. O(N).
#[must_use]
pub fn potential_energy<S: Scalar, const N: usize>(posture: &Posture<S, N>, g: &Vector3<S>) -> S {
    posture.links.iter().fold(S::zero(), |v, link| v - link.mass * g.dot(&link.centre))
}

/// The Lagrangian, J: `L = K - V` (eq. 12.214, 12.232).
#[must_use]
pub fn lagrangian<S: Scalar, const N: usize>(posture: &Posture<S, N>, qd: &[S; N], g: &Vector3<S>) -> S {
    kinetic_energy(posture, qd) - potential_energy(posture, g)
}

/// Inertia matrix of the arm: `D = sum_i (J_Di^T m_i J_Di + J_Ri^T 0I_i J_Ri)` (eq. 12.219, 12.229 without the factor 1/2).
///
/// | return | quantity | unit | shape |
/// |---|---|---|---|
/// | `[(i, j)]` | torque on joint `i` per acceleration of joint `j`, no rotors | kg m^2, kg m, kg | N x N, symmetric |
///
/// O(N^3). [`crate::mass_matrix::mass_matrix`] is O(N^2).
#[must_use]
pub fn mass_matrix<S: Scalar, const N: usize>(posture: &Posture<S, N>) -> SMatrix<S, N, N> {
    let mut d = SMatrix::<S, N, N>::zeros();
    for (link, jacobian) in posture.links.iter().zip(&link_jacobians(posture)) {
        for j in 0..N {
            let force = jacobian.linear[j] * link.mass;
            let moment = apply(&link.inertia, &jacobian.angular[j]);
            for i in 0..N {
                d[(i, j)] += jacobian.linear[i].dot(&force) + jacobian.angular[i].dot(&moment);
            }
        }
    }
    d
}

/// Derivatives of the inertia matrix by the posture, `[i][j][k] = dD_ij/dq_k`, as at this module's head.
///
/// `dD_ij/dq_k = sum_r m_r (dc_Di/dq_k . c_Dj + c_Di . dc_Dj/dq_k) + d(c_Ri . I_r c_Rj)/dq_k`
///
/// Unit of `D_ij` per rad or m. Symmetric in `i` and `j`. O(N^4).
#[must_use]
pub fn mass_matrix_slopes<S: Scalar, const N: usize>(posture: &Posture<S, N>) -> [[[S; N]; N]; N] {
    let mut slopes = [[[S::zero(); N]; N]; N];
    for (r, jacobian) in link_jacobians(posture).iter().enumerate() {
        let link = &posture.links[r];
        let force = jacobian.linear.map(|c| c * link.mass);
        let moment = jacobian.angular.map(|c| apply(&link.inertia, &c));
        for k in 0..=r {
            for i in 0..=r {
                let moved = linear_slope(posture, jacobian, i, k);
                let turned = angular_slope(posture, jacobian, i, k);
                // The derivative of one factor. The derivative of the other factor is this one with i and j exchanged.
                for j in 0..=r {
                    let change = moved.dot(&force[j]) + turned.dot(&moment[j]);
                    slopes[i][j][k] += change;
                    slopes[j][i][k] += change;
                }
            }
        }
    }
    slopes
}

/// `dc_D^(j)/dq_l`, the second derivative of a point by the two joints; `jacobian` belongs to a link that both joints move.
fn linear_slope<S: Scalar, const N: usize>(
    posture: &Posture<S, N>,
    jacobian: &Jacobian<S, N>,
    j: usize,
    l: usize,
) -> Vector3<S> {
    turning_axis(&posture.links[j.min(l)]).cross(&jacobian.linear[j.max(l)])
}

/// Change of `c_R^(j)` with joint `l`, as seen from a link that both move.
fn angular_slope<S: Scalar, const N: usize>(
    posture: &Posture<S, N>,
    jacobian: &Jacobian<S, N>,
    j: usize,
    l: usize,
) -> Vector3<S> {
    if j < l { jacobian.angular[j].cross(&turning_axis(&posture.links[l])) } else { Vector3::zeros() }
}

/// Christoffel symbols of the first kind, `[i][j][k]` = `Gamma^i_jk` (eq. 12.281).
///
/// `Gamma^i_jk = 1/2 (dD_ij/dq_k + dD_ik/dq_j - dD_jk/dq_i)`: torque on joint `i` per `qd_j qd_k`. Symmetric in `j` and `k`.
/// kg m^2 if all three joints turn, otherwise times 1/m for each that slides. O(N^4).
#[must_use]
pub fn christoffel<S: Scalar, const N: usize>(posture: &Posture<S, N>) -> [[[S; N]; N]; N] {
    let d = mass_matrix_slopes(posture);
    let half = S::literal(0.5);
    let symbol = |i: usize, j: usize, k: usize| (d[i][j][k] + d[i][k][j] - d[j][k][i]) * half;
    core::array::from_fn(|i| core::array::from_fn(|j| core::array::from_fn(|k| symbol(i, j, k))))
}

/// `C(q, qd)` of eq. 12.217: `C_ij = sum_k Gamma^i_jk qd_k`, the choice that makes `dD/dt - 2 C` skew-symmetric.
///
/// `C qd` is the velocity coupling vector. kg m^2/s if both joints turn. O(N^4).
#[must_use]
pub fn coriolis_matrix<S: Scalar, const N: usize>(posture: &Posture<S, N>, qd: &[S; N]) -> SMatrix<S, N, N> {
    let symbols = christoffel(posture);
    let mut c = SMatrix::<S, N, N>::zeros();
    for i in 0..N {
        for j in 0..N {
            c[(i, j)] = dot(&symbols[i][j], qd);
        }
    }
    c
}

/// Velocity coupling vector `H(q, qd) = C qd` (eq. 12.238, 12.241), N m or N.
///
/// `H_i = sum_jk (dD_ij/dq_k - 1/2 dD_jk/dq_i) qd_j qd_k`: the terms in the form in which Lagrange's equation gives them (eq. 12.233,
/// 12.235), before they are made symmetric. O(N^4).
#[must_use]
pub fn velocity_coupling<S: Scalar, const N: usize>(posture: &Posture<S, N>, qd: &[S; N]) -> [S; N] {
    let d = mass_matrix_slopes(posture);
    let half = S::literal(0.5);
    core::array::from_fn(|i| {
        let mut h = S::zero();
        for j in 0..N {
            for k in 0..N {
                h += (d[i][j][k] - d[j][k][i] * half) * qd[j] * qd[k];
            }
        }
        h
    })
}

/// Torques that hold the arm's weight, N m or N: `G_i = -sum_j m_j g . c_Dj^(i)` (eq. 12.239 with its sign corrected).
///
/// `g` is the gravitational acceleration in the base frame, m/s^2. O(N^2).
#[must_use]
pub fn gravity<S: Scalar, const N: usize>(posture: &Posture<S, N>, g: &Vector3<S>) -> [S; N] {
    let mut torque = [S::zero(); N];
    for (link, jacobian) in posture.links.iter().zip(&link_jacobians(posture)) {
        let weight = g * link.mass;
        for i in 0..N {
            torque[i] -= jacobian.linear[i].dot(&weight);
        }
    }
    torque
}

/// Generalized forces, N m or N: `Q_i = tau_i + (J^T w)_i` (eq. 12.236).
///
/// | name | quantity | unit | frame |
/// |---|---|---|---|
/// | `tau` | actuator torque or force | N m, N | |
/// | `tip_wrench` | of the environment on the arm at the tip's origin: the chapter's `F_e` | N, N m | base |
///
/// O(N).
#[must_use]
pub fn generalized_force<S: Scalar, const N: usize>(
    posture: &Posture<S, N>,
    tau: &[S; N],
    tip_wrench: &Wrench<S>,
) -> [S; N] {
    let contact = tip_jacobian(posture).transposed(tip_wrench);
    core::array::from_fn(|i| tau[i] + contact[i])
}

/// Actuator torques for a wanted motion, by the matrices (eq. 12.217 solved for the actuators by 12.236).
///
/// `tau = D(q) qdd + C(q, qd) qd + G(q) - J^T w`
///
/// | name | quantity | unit | shape |
/// |---|---|---|---|
/// | `posture` | the arm at `q` | | |
/// | `qd`, `qdd` | joint velocity and acceleration | rad/s, rad/s^2 (m/s, m/s^2) | N |
/// | `g` | gravitational acceleration, base frame | m/s^2 | 3 |
/// | `tip_wrench` | of the environment on the arm at the tip's origin, base axes | N, N m | |
/// | return | actuator torque or force, without the rotors' | N m, N | N |
///
/// O(N^4); no branch on data, no division.
#[must_use]
pub fn inverse_dynamics<S: Scalar, const N: usize>(
    posture: &Posture<S, N>,
    qd: &[S; N],
    qdd: &[S; N],
    g: &Vector3<S>,
    tip_wrench: &Wrench<S>,
) -> [S; N] {
    let (d, c) = (mass_matrix(posture), coriolis_matrix(posture, qd));
    let (weight, contact) = (gravity(posture, g), tip_jacobian(posture).transposed(tip_wrench));
    core::array::from_fn(|i| {
        let mut tau = weight[i] - contact[i];
        for j in 0..N {
            tau += d[(i, j)] * qdd[j] + c[(i, j)] * qd[j];
        }
        tau
    })
}

/// Angular velocity of everything beyond a joint, per joint velocity.
fn turning_axis<S: Scalar>(link: &LinkPosture<S>) -> Vector3<S> {
    match link.kind {
        JointKind::Revolute => link.axis,
        JointKind::Prismatic => Vector3::zeros(),
    }
}

fn dot<S: Scalar, const N: usize>(a: &[S; N], b: &[S; N]) -> S {
    a.iter().zip(b).fold(S::zero(), |sum, (a, b)| sum + *a * *b)
}
