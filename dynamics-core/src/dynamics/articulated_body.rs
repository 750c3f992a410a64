//! Accelerations from torques without the inertia matrix: articulated bodies (Featherstone 1983), O(N).
//!
//! The first outward pass computes the velocities and the accelerations due to them alone. The inward pass computes the inertia and the
//! wrench that each link presents to its joint when the joints beyond it are free. The second outward pass computes the accelerations.
//! Frames and quantities are those of [`crate::newton_euler`]: accelerations `a` of the origins less gravity, wrenches about the
//! origins.
//!
//! ```text
//! moment = J alpha + H a + n          of the articulated body, J and M symmetric
//! force  = H^T alpha + M a + f
//! ```
//!
//! For six joints this needs more operations than factoring the inertia matrix ([`crate::forward_dynamics`]), traced or
//! not (`docs/performance.md`). The two share only the bodies' frames, so each checks the other. A massless link
//! with a rotor is not a special case: the rotor is part of its pivot.

use crate::forward_dynamics::{Acceleration, Singular};
use crate::geometry::{apply, apply_transposed, compose};
use crate::inertia::{Inertia, Wrench};
use crate::joint::JointKind;
use crate::mass_matrix::{link_placement, symmetric, tensor_out_of_link};
use crate::model::Link;
use crate::newton_euler::{into_link, to_parent};
use crate::scalar::{Field, Real, Scalar};
use crate::scene::{Dynamics, Live};
use crate::trig::SinCos;
use nalgebra::{Matrix3, Vector3};

/// Joint accelerations under the actuator torques `tau`: as [`crate::forward_dynamics::forward_dynamics`], in O(N).
///
/// # Errors
/// [`Singular`]: a joint moves neither mass nor rotor.
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

/// As [`forward_dynamics`], but returns the pivots unchecked, without a branch on data. N divisions.
pub fn acceleration<S: Field, const N: usize>(
    dynamics: &Dynamics<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    tau: &[S; N],
    live: &Live<S, N>,
) -> Acceleration<S, N> {
    let links = dynamics.model().links();
    let rotor = dynamics.scene().rotor.value(&live.rotor);
    let (bodies, mut bias) = outward(dynamics, turn, q, qd, live);

    let zero = SpatialAcceleration { angular: Vector3::zeros(), linear: Vector3::zeros() };
    let mut joints = [Joint { felt: zero, inverse: S::zero(), pivot: S::zero(), rest: S::zero() }; N];
    let mut articulated = Articulated::of(&dynamics.inertia(N - 1, live));
    for i in (0..N).rev() {
        let link = &links[i];
        let felt = articulated.felt(link.kind);
        let along = match link.kind {
            JointKind::Revolute => (felt.angular.z, bias[i].wrench.moment.z),
            JointKind::Prismatic => (felt.linear.z, bias[i].wrench.force.z),
        };
        let pivot = rotor.map_or(along.0, |rotor| along.0 + rotor[i]);
        let inverse = S::one() / pivot;
        joints[i] = Joint { felt, inverse, pivot, rest: tau[i] - along.1 };
        if i > 0 {
            let given_way = articulated.without(link.kind, &felt, inverse, rotor.is_some());
            let push = joints[i].rest * inverse;
            let carried = given_way.wrench(&bias[i].motion)
                + bias[i].wrench
                + Wrench { force: felt.linear * push, moment: felt.angular * push };
            articulated = Articulated::of(&bodies[i - 1]).plus(&given_way.in_parent(link, turn[i], q[i]));
            bias[i - 1].wrench = bias[i - 1].wrench + to_parent(link, turn[i], q[i], &carried);
        }
    }

    let mut qdd = [S::zero(); N];
    let mut motion = zero;
    for i in 0..N {
        motion = if i == 0 { bias[0].motion } else { motion.into_link(&links[i], turn[i], q[i]).plus(&bias[i].motion) };
        let Joint { felt, inverse, rest, .. } = &joints[i];
        qdd[i] = (*rest - felt.angular.dot(&motion.angular) - felt.linear.dot(&motion.linear)) * *inverse;
        match links[i].kind {
            JointKind::Revolute => motion.angular.z += qdd[i],
            JointKind::Prismatic => motion.linear.z += qdd[i],
        }
    }
    Acceleration { qdd, pivot: joints.map(|joint| joint.pivot) }
}

/// Angular and linear acceleration, in a link's frame.
#[derive(Clone, Copy)]
struct SpatialAcceleration<S> {
    angular: Vector3<S>,
    linear: Vector3<S>,
}

/// Effect of the velocities, gravity and the contact on a link.
#[derive(Clone, Copy)]
struct Bias<S> {
    /// Acceleration beyond the parts due to the parent's acceleration and the joint's own.
    motion: SpatialAcceleration<S>,
    /// Wrench beyond the part due to its acceleration.
    wrench: Wrench<S>,
}

/// A joint between the inward and the outward pass.
#[derive(Clone, Copy)]
struct Joint<S> {
    /// Moment and force at the joint per unit of its acceleration.
    felt: SpatialAcceleration<S>,
    inverse: S,
    pivot: S,
    /// Torque that is left for acceleration.
    rest: S,
}

/// The bodies, with their motion and loads at `qdd = 0`.
fn outward<S: Scalar, const N: usize>(
    dynamics: &Dynamics<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    live: &Live<S, N>,
) -> ([Inertia<S>; N], [Bias<S>; N]) {
    let links = dynamics.model().links();
    let scene = dynamics.scene();
    let bodies = core::array::from_fn(|i| dynamics.inertia(i, live));
    let zero = SpatialAcceleration { angular: Vector3::zeros(), linear: Vector3::zeros() };
    let mut bias = [Bias { motion: zero, wrench: Wrench::zero() }; N];
    if let Some(gravity) = scene.gravity.value(&live.gravity) {
        bias[0].motion.linear = into_link(&links[0], turn[0], &-gravity);
    }
    if let Some(qd) = scene.coriolis.value(qd) {
        let mut omega = Vector3::zeros();
        for i in 0..N {
            let link = &links[i];
            if i > 0 {
                let origin = link_origin(link, turn[i], q[i]);
                bias[i].motion.linear = into_link(link, turn[i], &omega.cross(&omega.cross(&origin)));
                omega = into_link(link, turn[i], &omega);
                let across = Vector3::new(omega.y * qd[i], -(omega.x * qd[i]), S::zero());
                match link.kind {
                    JointKind::Revolute => bias[i].motion.angular = across,
                    JointKind::Prismatic => bias[i].motion.linear += across + across,
                }
            }
            if link.kind == JointKind::Revolute {
                omega.z += qd[i];
            }
            let Inertia { first_moment, about_origin, .. } = &bodies[i];
            bias[i].wrench = Wrench {
                force: omega.cross(&omega.cross(first_moment)),
                moment: omega.cross(&apply(about_origin, &omega)),
            };
        }
    }
    if let Some(contact) = scene.tip_wrench.value(&live.tip_wrench) {
        let tip = dynamics.model().tip();
        bias[N - 1].wrench = bias[N - 1].wrench - contact.in_parent(&tip.rotation, &tip.translation);
    }
    (bodies, bias)
}

fn link_origin<S: Scalar>(link: &Link<S>, turn: SinCos<S>, q: S) -> Vector3<S> {
    link_placement(link, turn, q).1
}

impl<S: Scalar> SpatialAcceleration<S> {
    fn plus(&self, other: &Self) -> Self {
        Self { angular: self.angular + other.angular, linear: self.linear + other.linear }
    }

    /// The parent's motion expressed in the link's frame: `R^T alpha`, `R^T (a + alpha x p)`.
    fn into_link(self, link: &Link<S>, turn: SinCos<S>, q: S) -> Self {
        let origin = link_origin(link, turn, q);
        Self {
            angular: into_link(link, turn, &self.angular),
            linear: into_link(link, turn, &(self.linear + self.angular.cross(&origin))),
        }
    }
}

/// Inertia of a body with its outer joints free.
struct Articulated<S> {
    /// `J`, symmetric.
    turning: Matrix3<S>,
    /// `H`, moment per linear acceleration.
    coupling: Matrix3<S>,
    /// `M`, symmetric.
    mass: Matrix3<S>,
}

impl<S: Scalar> Articulated<S> {
    /// A rigid body: `H` is the cross product with its first moment.
    fn of(body: &Inertia<S>) -> Self {
        Self {
            turning: body.about_origin,
            coupling: cross_matrix(&body.first_moment),
            mass: Matrix3::from_diagonal(&Vector3::new(body.mass, body.mass, body.mass)),
        }
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            turning: self.turning + other.turning,
            coupling: self.coupling + other.coupling,
            mass: self.mass + other.mass,
        }
    }

    /// Moment and force per unit of the joint's acceleration.
    fn felt(&self, kind: JointKind) -> SpatialAcceleration<S> {
        let column = |m: &Matrix3<S>| m.column(2).into_owned();
        match kind {
            JointKind::Revolute => {
                SpatialAcceleration { angular: column(&self.turning), linear: self.coupling.row(2).transpose() }
            }
            JointKind::Prismatic => SpatialAcceleration { angular: column(&self.coupling), linear: column(&self.mass) },
        }
    }

    /// `I - U U^T / pivot`: frees this joint too. Without a rotor, the inertia left along the joint is zero by construction.
    fn without(&self, kind: JointKind, felt: &SpatialAcceleration<S>, inverse: S, rotor: bool) -> Self {
        let SpatialAcceleration { angular: u, linear: v } = felt;
        let (scaled_u, scaled_v) = (u * inverse, v * inverse);
        let less = |m: &Matrix3<S>, a: &Vector3<S>, b: &Vector3<S>| {
            let entry = |i: usize, k: usize| m[(i, k)] - a[i] * b[k];
            symmetric(entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2))
        };
        let mut left = Self {
            turning: less(&self.turning, u, &scaled_u),
            coupling: self.coupling - scaled_u * v.transpose(),
            mass: less(&self.mass, v, &scaled_v),
        };
        if !rotor {
            match kind {
                JointKind::Revolute => {
                    left.turning = without_z(&left.turning);
                    left.coupling.set_row(2, &Vector3::zeros().transpose());
                }
                JointKind::Prismatic => {
                    left.mass = without_z(&left.mass);
                    left.coupling.set_column(2, &Vector3::zeros());
                }
            }
        }
        left
    }

    fn wrench(&self, motion: &SpatialAcceleration<S>) -> Wrench<S> {
        Wrench {
            force: apply_transposed(&self.coupling, &motion.angular) + apply(&self.mass, &motion.linear),
            moment: apply(&self.turning, &motion.angular) + apply(&self.coupling, &motion.linear),
        }
    }

    /// About the parent's origin and in its axes: `M' = M`, `H' = H + [p] M`, `J' = J - H [p] + [p] H'^T`.
    fn in_parent(&self, link: &Link<S>, turn: SinCos<S>, q: S) -> Self {
        let (rotation, p) = link_placement(link, turn, q);
        let mass = tensor_out_of_link(link, turn, &self.mass);
        let turning = tensor_out_of_link(link, turn, &self.turning);
        let coupling = compose(&compose(&rotation, &self.coupling), &rotation.transpose());
        let moved = coupling + crossed(&p, &mass);
        // J' = J + (H [p]^T) + (H' [p]^T)^T: one triangle is enough.
        let (near, far) = (crossed(&p, &coupling.transpose()), crossed(&p, &moved.transpose()));
        let entry = |i: usize, k: usize| turning[(i, k)] + near[(k, i)] + far[(i, k)];
        let turning = symmetric(entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2));
        Self { turning, coupling: moved, mass }
    }
}

fn cross_matrix<S: Scalar>(v: &Vector3<S>) -> Matrix3<S> {
    let zero = S::zero();
    Matrix3::new(zero, -v.z, v.y, v.z, zero, -v.x, -v.y, v.x, zero)
}

/// `[p] M`, column by column.
fn crossed<S: Scalar>(p: &Vector3<S>, m: &Matrix3<S>) -> Matrix3<S> {
    let column = |k: usize| p.cross(&m.column(k).into_owned());
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}

/// The same with its last row and column zero.
fn without_z<S: Scalar>(m: &Matrix3<S>) -> Matrix3<S> {
    let zero = S::zero();
    symmetric(m.m11, m.m12, zero, m.m22, zero, zero)
}
