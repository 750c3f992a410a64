//! Bodies of a moving arm in base axes: their motion, their inertia about a joint's origin, and the loads that accelerate them.

use super::kinematics::{Pose, Solid};
use dynamics_core::{JointKind, Scalar};
use nalgebra::{Matrix3, Vector3};

/// Angular velocity and acceleration of a link, and the acceleration of its joint's origin, at `qdd = 0`.
#[derive(Clone, Copy)]
pub(super) struct Motion<S> {
    pub(super) w: Vector3<S>,
    pub(super) alpha: Vector3<S>,
    pub(super) a: Vector3<S>,
}

impl<S: Scalar> Motion<S> {
    /// Motion of the link beyond the next joint.
    pub(super) fn next(&self, pose: &Pose<S>, qd: S) -> Self {
        let own = pose.axis * qd;
        let across = self.w.cross(&own);
        let a = self.at(&pose.offset);
        match pose.kind {
            JointKind::Revolute => Self { w: self.w + own, alpha: self.alpha + across, a },
            JointKind::Prismatic => Self { a: a + across + across, ..*self },
        }
    }

    /// Acceleration of a point on the link.
    pub(super) fn at(&self, point: &Vector3<S>) -> Vector3<S> {
        self.a + self.alpha.cross(point) + self.w.cross(&self.w.cross(point))
    }
}

/// A body in base axes, about its own mass centre.
pub(super) struct Turned<S> {
    pub(super) mass: S,
    /// From the joint's origin to the mass centre.
    pub(super) centre: Vector3<S>,
    pub(super) inertia: Symmetric<S>,
}

impl<S: Scalar> Turned<S> {
    pub(super) fn new(body: &Solid<S>, rotation: &Matrix3<S>) -> Self {
        Self { mass: body.mass, centre: rotation * body.com, inertia: Symmetric::turned(rotation, &body.inertia) }
    }

    /// `J = I + m (r.r 1 - r r^T)`.
    pub(super) fn about_origin(&self) -> Bodies<S> {
        let first_moment = self.centre * self.mass;
        let along = first_moment.component_mul(&self.centre);
        let across = first_moment.component_mul(&next(&self.centre));
        Bodies { mass: self.mass, first_moment, inertia: self.inertia.moved(&along, &across) }
    }

    pub(super) fn load(&self, motion: &Motion<S>) -> Load<S> {
        let Motion { w, alpha, .. } = motion;
        let force = motion.at(&self.centre) * self.mass;
        let moment = self.inertia.times(alpha) + w.cross(&self.inertia.times(w)) + self.centre.cross(&force);
        Load { force, moment }
    }
}

/// Bodies that move as one, about a joint's origin.
#[derive(Clone, Copy)]
pub(super) struct Bodies<S> {
    pub(super) mass: S,
    pub(super) first_moment: Vector3<S>,
    pub(super) inertia: Symmetric<S>,
}

impl<S: Scalar> Bodies<S> {
    pub(super) fn none() -> Self {
        let inertia = Symmetric { diagonal: Vector3::zeros(), beside: Vector3::zeros() };
        Self { mass: S::zero(), first_moment: Vector3::zeros(), inertia }
    }

    pub(super) fn and(&self, other: &Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            inertia: self.inertia.plus(&other.inertia),
        }
    }

    /// The same bodies about a point displaced by `-d`: `J + 2 (d.h) 1 - d h^T - h d^T + m (d.d 1 - d d^T)`.
    pub(super) fn moved(&self, d: &Vector3<S>) -> Self {
        let h = self.first_moment;
        let moved = h + d * self.mass;
        let along = d.component_mul(&(h + moved));
        let across = d.component_mul(&next(&h)) + moved.component_mul(&next(d));
        Self { mass: self.mass, first_moment: moved, inertia: self.inertia.moved(&along, &across) }
    }

    /// Load that accelerates the bodies when a joint at the origin has a unit acceleration.
    pub(super) fn taken(&self, pose: &Pose<S>) -> Load<S> {
        let (z, h) = (&pose.axis, &self.first_moment);
        match pose.kind {
            JointKind::Revolute => Load { force: z.cross(h), moment: self.inertia.times(z) },
            JointKind::Prismatic => Load { force: z * self.mass, moment: h.cross(z) },
        }
    }
}

/// A symmetric matrix: xx, yy, zz, and xy, yz, zx.
#[derive(Clone, Copy)]
pub(super) struct Symmetric<S> {
    pub(super) diagonal: Vector3<S>,
    pub(super) beside: Vector3<S>,
}

impl<S: Scalar> Symmetric<S> {
    /// `R I R^T`, as the sum of the outer products of the columns of `R I` and `R`.
    pub(super) fn turned(rotation: &Matrix3<S>, inertia: &Matrix3<S>) -> Self {
        let half = rotation * inertia;
        let outer = |k: usize| {
            let (h, r) = (half.column(k).into_owned(), rotation.column(k).into_owned());
            Self { diagonal: h.component_mul(&r), beside: h.component_mul(&next(&r)) }
        };
        outer(0).plus(&outer(1)).plus(&outer(2))
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        Self { diagonal: self.diagonal + other.diagonal, beside: self.beside + other.beside }
    }

    /// The matrix plus `(along.x + along.y + along.z) 1 - diag(along)`, minus `across` off the diagonal.
    pub(super) fn moved(&self, along: &Vector3<S>, across: &Vector3<S>) -> Self {
        let whole = Vector3::repeat(along.x + along.y + along.z);
        Self { diagonal: self.diagonal + (whole - along), beside: self.beside - across }
    }

    pub(super) fn times(&self, v: &Vector3<S>) -> Vector3<S> {
        let back = Vector3::new(self.beside.z, self.beside.x, self.beside.y);
        let before = Vector3::new(v.z, v.x, v.y);
        self.diagonal.component_mul(v) + self.beside.component_mul(&next(v)) + back.component_mul(&before)
    }
}

/// `(y, z, x)`.
pub(super) fn next<S: Scalar>(v: &Vector3<S>) -> Vector3<S> {
    Vector3::new(v.y, v.z, v.x)
}

/// A force, and a moment about a joint's origin.
#[derive(Clone, Copy)]
pub(super) struct Load<S> {
    pub(super) force: Vector3<S>,
    pub(super) moment: Vector3<S>,
}

impl<S: Scalar> Load<S> {
    pub(super) fn none() -> Self {
        Self { force: Vector3::zeros(), moment: Vector3::zeros() }
    }

    pub(super) fn and(&self, other: &Self) -> Self {
        Self { force: self.force + other.force, moment: self.moment + other.moment }
    }

    /// The same load about a point displaced by `-d`.
    pub(super) fn moved(&self, d: &Vector3<S>) -> Self {
        Self { force: self.force, moment: self.moment + d.cross(&self.force) }
    }

    /// Component of the load along or about the joint's axis.
    pub(super) fn along(&self, pose: &Pose<S>) -> S {
        match pose.kind {
            JointKind::Revolute => pose.axis.dot(&self.moment),
            JointKind::Prismatic => pose.axis.dot(&self.force),
        }
    }
}
