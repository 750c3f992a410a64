//! Mass, first moment and inertia of a body about an origin, and wrenches.

use crate::fields::record;
use crate::geometry::{apply, apply_transposed, compose};
use crate::scalar::{Real, Scalar};
use core::ops::{Add, Sub};
use nalgebra::{Matrix3, Vector3};

/// The ten inertial parameters of a rigid body in one frame, about that frame's origin.
///
/// First moment and inertia about the origin, rather than mass centre and central inertia: the recursions then need no
/// division and no shift, two bodies add parameter by parameter, and all ten enter the torques linearly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia<S> {
    /// Mass, kg.
    pub mass: S,
    /// First moment `h = m c`, kg m; `c` is the mass centre.
    pub first_moment: Vector3<S>,
    /// Inertia tensor about the frame's origin, `I_C + m (c.c 1 - c c^T)`, kg m^2. Symmetric.
    pub about_origin: Matrix3<S>,
}

record! {
    /// Bounds on a payload that is set at run time: its mass and its size.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct InertiaBounds<S> {
        /// Greatest mass, kg.
        pub mass: S,
        /// No part of it is farther from the frame's origin than this, m.
        pub radius: S,
    }
}

/// A force and a moment about a stated point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench<S> {
    /// Force, N.
    pub force: Vector3<S>,
    /// Moment about the stated point, N m.
    pub moment: Vector3<S>,
}

impl<S: Scalar> Wrench<S> {
    /// No force and no moment.
    #[must_use]
    pub fn zero() -> Self {
        Self { force: Vector3::zeros(), moment: Vector3::zeros() }
    }

    /// The same wrench about the origin of the parent frame and in its axes.
    ///
    /// `F' = R F`, `M' = R M + p x F'` (eq. 12.161-12.162, with the moment moved to the parent's origin).
    ///
    /// | name | quantity | unit |
    /// |---|---|---|
    /// | `rotation` | `R = parent_from_link` | - |
    /// | `translation` | `p`, origin of this frame in the parent | m |
    #[must_use]
    #[inline]
    pub fn in_parent(&self, rotation: &Matrix3<S>, translation: &Vector3<S>) -> Self {
        let force = apply(rotation, &self.force);
        Self { force, moment: apply(rotation, &self.moment) + translation.cross(&force) }
    }

    /// Moves a wrench about the parent's origin and in its axes to the origin and axes of this frame: the inverse of
    /// [`Wrench::in_parent`].
    ///
    /// `F' = R^T F`, `M' = R^T (M - p x F)` (eq. 12.167-12.168 with `iT_{i+1}^{-1}`, the moment moved to this origin).
    #[must_use]
    pub fn in_child(&self, rotation: &Matrix3<S>, translation: &Vector3<S>) -> Self {
        let moment = apply_transposed(rotation, &(self.moment - translation.cross(&self.force)));
        Self { force: apply_transposed(rotation, &self.force), moment }
    }

    /// Casts each number through the nearest literal.
    #[must_use]
    pub fn cast<T: Scalar>(&self) -> Wrench<T>
    where
        S: Into<f64>,
    {
        Wrench { force: cast_vector(&self.force), moment: cast_vector(&self.moment) }
    }
}

impl<S: Scalar> Add for Wrench<S> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { force: self.force + other.force, moment: self.moment + other.moment }
    }
}

impl<S: Scalar> Sub for Wrench<S> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { force: self.force - other.force, moment: self.moment - other.moment }
    }
}

impl<S: Scalar> Inertia<S> {
    /// No body: no mass.
    #[must_use]
    pub fn zero() -> Self {
        Self { mass: S::zero(), first_moment: Vector3::zeros(), about_origin: Matrix3::zeros() }
    }

    /// From mass (kg), mass centre (m) and the inertia tensor about the mass centre (kg m^2), in the same axes.
    ///
    /// `I_O = I_C + m (c.c 1 - c c^T)` (parallel-axis theorem).
    #[must_use]
    pub fn from_mass_centre(mass: S, com: &Vector3<S>, about_com: &Matrix3<S>) -> Self {
        let first_moment = com * mass;
        Self { mass, first_moment, about_origin: about_com + steiner(&first_moment, com) }
    }

    /// The same body seen from the parent frame.
    ///
    /// With `h' = R h`: mass stays, first moment `h' + m p`, inertia
    /// `R I R^T + 2 (p.h') 1 - p h'^T - h' p^T + m (p.p 1 - p p^T)`.
    #[must_use]
    pub fn in_parent(&self, rotation: &Matrix3<S>, translation: &Vector3<S>) -> Self {
        let p = translation;
        let turned = apply(rotation, &self.first_moment);
        let cross = steiner(&turned, p);
        let about_origin = compose(&compose(rotation, &self.about_origin), &rotation.transpose())
            + cross
            + cross.transpose()
            + steiner(&(p * self.mass), p);
        Self { mass: self.mass, first_moment: turned + p * self.mass, about_origin }
    }

    /// The same body with the entries of its tensor above the diagonal copied below it.
    ///
    /// Rounding after a rotation leaves the two halves different in their last bits. A peer that receives six entries
    /// instead of nine would then compute different torques.
    #[must_use]
    pub fn symmetric(&self) -> Self {
        let i = &self.about_origin;
        let about_origin = Matrix3::new(i.m11, i.m12, i.m13, i.m12, i.m22, i.m23, i.m13, i.m23, i.m33);
        Self { about_origin, ..*self }
    }

    /// Casts each number through the nearest literal.
    #[must_use]
    pub fn cast<T: Scalar>(&self) -> Inertia<T>
    where
        S: Into<f64>,
    {
        Inertia {
            mass: T::literal(self.mass.into()),
            first_moment: cast_vector(&self.first_moment),
            about_origin: cast_matrix(&self.about_origin),
        }
    }
}

impl<S: Real> Inertia<S> {
    /// True if some distribution of mass inside a ball around the origin has these ten parameters, and is not too heavy.
    ///
    /// With `c = h / m` and the second moment `Sigma = tr(I) / 2 1 - I`: `0 <= m <= m_max`, `tr(Sigma) <= m R^2` and
    /// `Sigma / m - c c^T` positive semidefinite, which are necessary and sufficient (Wensing, Kim and Slotine, "Linear matrix
    /// inequalities for physically consistent inertial parameter identification", 2018). Without mass, all ten numbers must be zero.
    ///
    /// Semidefinite to within 1e-5 of `R^2`, a margin for the rounding of an f32. False if a number is not finite.
    /// About 60 operations, 6 divisions; no root, no loop.
    #[must_use]
    pub fn is_within(&self, bounds: &InertiaBounds<S>) -> bool {
        let (zero, one) = (S::zero(), S::one());
        let (m, h, i) = (self.mass, &self.first_moment, &self.about_origin);
        if m == zero {
            return h.iter().chain(i.iter()).all(|x| *x == zero);
        }
        let (per_mass, per_square) = (one / m, one / (bounds.radius * bounds.radius));
        let c = h * (per_mass / bounds.radius);
        let i = i * per_mass * per_square;
        // Everything from here on is in units of the body's mass and of the radius: between -1 and 1 in a possible
        // body.
        let trace = (i.m11 + i.m22 + i.m33) * S::literal(0.5);
        let slack = S::literal(1e-5);
        let diagonal = |moment: S, c: S| trace - moment - c * c + slack;
        let beside = |product: S, c: S, d: S| -product - c * d;
        // Gauss's elimination: positive definite if every pivot is above zero.
        let first = diagonal(i.m11, c.x);
        let (a12, a13) = (beside(i.m12, c.x, c.y), beside(i.m13, c.x, c.z));
        let (f2, f3) = (a12 / first, a13 / first);
        let second = diagonal(i.m22, c.y) - f2 * a12;
        let a23 = beside(i.m23, c.y, c.z) - f2 * a13;
        let third = diagonal(i.m33, c.z) - f3 * a13 - a23 / second * a23;
        let heavy = m < zero || m > bounds.mass;
        !heavy && trace <= one + slack && first > zero && second > zero && third > zero
    }
}

impl<S: Scalar> Add for Inertia<S> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            about_origin: self.about_origin + other.about_origin,
        }
    }
}

/// `(u.v) 1 - u v^T`: the contribution of a first moment `u` at `v` to an inertia tensor.
fn steiner<S: Scalar>(u: &Vector3<S>, v: &Vector3<S>) -> Matrix3<S> {
    let (xx, yy, zz) = (u.x * v.x, u.y * v.y, u.z * v.z);
    Matrix3::new(
        yy + zz,
        -(u.x * v.y),
        -(u.x * v.z),
        -(u.y * v.x),
        xx + zz,
        -(u.y * v.z),
        -(u.z * v.x),
        -(u.z * v.y),
        xx + yy,
    )
}

/// Element by element through the nearest literal.
#[must_use]
pub fn cast_vector<S: Scalar + Into<f64>, T: Scalar>(v: &Vector3<S>) -> Vector3<T> {
    v.map(|x| T::literal(x.into()))
}

/// Element by element through the nearest literal.
#[must_use]
pub fn cast_matrix<S: Scalar + Into<f64>, T: Scalar>(m: &Matrix3<S>) -> Matrix3<T> {
    m.map(|x| T::literal(x.into()))
}
