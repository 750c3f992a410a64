//! An arm at rest: joint wrenches and holding torques, inward from the tip and outward from the base.
//!
//! With `(F_{i-1}, M_{i-1})` on link `i` at `O_{i-1}`, by the link before, `(F_i, M_i)` by link `i` on what follows at `O_i`, and
//! `d` from `O_{i-1}` to `O_i`:
//!
//! ```text
//! inward    F_{i-1} = F_i - sum F_e,    M_{i-1} = M_i - sum M_e + d x F_i         M_e about O_{i-1}    12.455-12.456, 12.497-12.498
//! outward   F_i = F_{i-1} + sum F_e,    M_i = M_{i-1} + sum M_e - d x F_{i-1}     M_e about O_i        12.471-12.472
//! ```
//!
//! The chapter uses one symbol for the moment of the external loads about these two points and, in 12.459, about the
//! mass centre. It computes the moment of the weight about a fourth point, the base's origin (12.465), which fits none of these
//! equations. Here a load names the reference point of its moment ([`ExternalLoad::about`]), and the moment is moved to the point that the
//! equation needs.
//!
//! | quantity | unit | frame |
//! |---|---|---|
//! | gravity | m/s^2 | base axes |
//! | joint wrench: on link `i` by the link or base before it, about `O_{i-1}`, `links[i - 1].origin` | N, N m | base or link's axes |
//! | tip wrench: of the environment on the arm, about the tip's origin; `-(F_n, M_n)` | N, N m | base or tip axes |

use crate::chapter::posture::{Chain, Posture};
use crate::chapter::reactions::Reaction;
use crate::geometry::apply_transposed;
use crate::inertia::Wrench;
use crate::newton_euler::{into_link, out_of_link};
use crate::scalar::Scalar;
use crate::trig::SinCos;
use nalgebra::Vector3;

/// Reference point of a moment on a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Point {
    /// The link's mass centre `C_i`: the chapter's 12.459-12.461 and 12.470.
    MassCentre,
    /// The origin `O_{i-1}` of the link's own joint: 12.456, 12.498.
    InnerOrigin,
    /// Where the link ends, `O_i`: 12.472.
    OuterOrigin,
    /// The origin of the base frame.
    Base,
}

/// A force and a moment on a link from outside the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExternalLoad<S> {
    /// Force, N.
    pub force: Vector3<S>,
    /// Moment about [`ExternalLoad::about`], N m.
    pub moment: Vector3<S>,
    /// Reference point of the moment.
    pub about: Point,
}

impl<S: Scalar> ExternalLoad<S> {
    /// Weight: `m g` through the mass centre (eq. 12.464; 12.465 corrected).
    #[must_use]
    pub fn weight(mass: S, gravity: &Vector3<S>) -> Self {
        Self { force: gravity * mass, moment: Vector3::zeros(), about: Point::MassCentre }
    }

    /// The same load with its moment about another point: `M_B = M_A + (A - B) x F`.
    #[must_use]
    pub fn moved(&self, to: Point, points: &Points<S>) -> Self {
        let arm = points.at(self.about) - points.at(to);
        Self { moment: self.moment + arm.cross(&self.force), about: to, ..*self }
    }
}

/// A link's points, all in the same frame, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Points<S> {
    /// `C_i`.
    pub mass_centre: Vector3<S>,
    /// `O_{i-1}`.
    pub inner_origin: Vector3<S>,
    /// `O_i`.
    pub outer_origin: Vector3<S>,
    /// Origin of the base frame.
    pub base: Vector3<S>,
}

impl<S: Scalar> Points<S> {
    /// Points of link `i` (counted from 0) in the base frame.
    #[must_use]
    pub fn in_base<const N: usize>(posture: &Posture<S, N>, i: usize) -> Self {
        let link = &posture.links[i];
        Self {
            mass_centre: link.centre,
            inner_origin: link.origin,
            outer_origin: posture.end(i),
            base: Vector3::zeros(),
        }
    }

    /// Points of link `i` (counted from 0) in its own frame.
    #[must_use]
    pub fn in_link<const N: usize>(posture: &Posture<S, N>, i: usize) -> Self {
        let (link, points) = (&posture.links[i], Self::in_base(posture, i));
        let seen = |point: Vector3<S>| apply_transposed(&link.rotation, &(point - link.origin));
        Self {
            mass_centre: seen(points.mass_centre),
            inner_origin: Vector3::zeros(),
            outer_origin: seen(points.outer_origin),
            base: seen(points.base),
        }
    }

    /// Position of one of the points.
    #[must_use]
    pub fn at(&self, point: Point) -> Vector3<S> {
        match point {
            Point::MassCentre => self.mass_centre,
            Point::InnerOrigin => self.inner_origin,
            Point::OuterOrigin => self.outer_origin,
            Point::Base => self.base,
        }
    }

    /// `d`, from `O_{i-1}` to `O_i` (eq. 12.457; 12.466 with 0 as its fourth element).
    fn span(&self) -> Vector3<S> {
        self.outer_origin - self.inner_origin
    }

    /// `sum F_e`, `sum M_e` about a point: the weight and all other loads.
    fn sum(&self, weight: &ExternalLoad<S>, loads: &[ExternalLoad<S>], about: Point) -> Wrench<S> {
        loads.iter().chain([weight]).fold(Wrench::zero(), |sum, load| {
            let moved = load.moved(about, self);
            sum + Wrench { force: moved.force, moment: moved.moment }
        })
    }

    /// 12.455-12.456: the wrench at the inner end from the one at the outer end.
    fn inward(&self, outer: &Wrench<S>, external: &Wrench<S>) -> Wrench<S> {
        let carried = *outer - *external;
        Wrench { moment: carried.moment + self.span().cross(&outer.force), ..carried }
    }

    /// 12.471-12.472: the wrench at the outer end from the one at the inner end.
    fn outward(&self, inner: &Wrench<S>, external: &Wrench<S>) -> Wrench<S> {
        let carried = *inner + *external;
        Wrench { moment: carried.moment - self.span().cross(&inner.force), ..carried }
    }
}

/// Joint wrenches of an arm at rest, from the tip to the base, all in base axes (eq. 12.455-12.456).
///
/// | name | quantity |
/// |---|---|
/// | `loads` | of each link, besides its weight, in base axes; `[&[]; N]` for none |
/// | `tip` | tip wrench, in base axes |
/// | return | joint wrenches, base first: the chapter's `(F_0, M_0)` to `(F_{n-1}, M_{n-1})` |
///
/// O(N); no branch on data, no division.
#[must_use]
pub fn backward<S: Scalar, const N: usize>(
    posture: &Posture<S, N>,
    gravity: &Vector3<S>,
    loads: &[&[ExternalLoad<S>]; N],
    tip: &Wrench<S>,
) -> [Wrench<S>; N] {
    let mut joint = [Wrench::zero(); N];
    let mut outer = Wrench::zero() - *tip;
    for i in (0..N).rev() {
        let points = Points::in_base(posture, i);
        let weight = ExternalLoad::weight(posture.links[i].mass, gravity);
        joint[i] = points.inward(&outer, &points.sum(&weight, loads[i], Point::InnerOrigin));
        outer = joint[i];
    }
    joint
}

/// Wrenches at the links' ends of an arm at rest, from the base to the tip, all in base axes (eq. 12.471-12.474).
///
/// | name | quantity |
/// |---|---|
/// | `loads` | as [`backward`] |
/// | `first` | wrench of the first joint, `(F_0, M_0)`: on the first link by the base, about `links[0].origin`, in base axes |
/// | return | `(F_1, M_1)` to `(F_n, M_n)`: by each link on what follows it, about [`Posture::end`] |
///
/// The last is the wrench of the arm on the environment: the negative of a tip wrench.
///
/// Undoes [`backward`]. O(N); no branch on data, no division.
#[must_use]
pub fn forward<S: Scalar, const N: usize>(
    posture: &Posture<S, N>,
    gravity: &Vector3<S>,
    loads: &[&[ExternalLoad<S>]; N],
    first: &Wrench<S>,
) -> [Wrench<S>; N] {
    let mut inner = *first;
    core::array::from_fn(|i| {
        let points = Points::in_base(posture, i);
        let weight = ExternalLoad::weight(posture.links[i].mass, gravity);
        inner = points.outward(&inner, &points.sum(&weight, loads[i], Point::OuterOrigin));
        inner
    })
}

/// As [`backward`], each link's wrench computed in that link's axes and then turned into those of the link before
/// (eq. 12.497-12.500).
///
/// `loads` are in their links' axes, `tip` is in tip axes; `[i]` of the return value is in the axes of link `i`, and
/// turns into base axes by [`crate::chapter::posture::LinkPosture::rotation`] (12.501-12.502).
#[must_use]
pub fn backward_in_links<S: Scalar, const N: usize>(
    chain: &Chain<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    gravity: &Vector3<S>,
    loads: &[&[ExternalLoad<S>]; N],
    tip: &Wrench<S>,
) -> [Wrench<S>; N] {
    let posture = chain.posture(turn, q);
    let mut joint = [Wrench::zero(); N];
    let mut outer = Wrench::zero() - tip.in_parent(&chain.model().tip().rotation, &Vector3::zeros());
    for i in (0..N).rev() {
        let (points, weight) = in_link(&posture, i, gravity);
        joint[i] = points.inward(&outer, &points.sum(&weight, loads[i], Point::InnerOrigin));
        let out = |v| out_of_link(&chain.model().links()[i], turn[i], v);
        outer = Wrench { force: out(&joint[i].force), moment: out(&joint[i].moment) };
    }
    joint
}

/// As [`forward`], each link's wrench computed in that link's axes and then turned into those of the next (eq. 12.471-12.472
/// with the turn of 12.180-12.181).
///
/// `loads` are in their links' axes, `first` is in the first link's; `[i]` of the return value is in the axes of link
/// `i`.
#[must_use]
pub fn forward_in_links<S: Scalar, const N: usize>(
    chain: &Chain<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    gravity: &Vector3<S>,
    loads: &[&[ExternalLoad<S>]; N],
    first: &Wrench<S>,
) -> [Wrench<S>; N] {
    let posture = chain.posture(turn, q);
    let mut inner = *first;
    core::array::from_fn(|i| {
        let (points, weight) = in_link(&posture, i, gravity);
        let outer = points.outward(&inner, &points.sum(&weight, loads[i], Point::OuterOrigin));
        if let Some(next) = chain.model().links().get(i + 1) {
            let into = |v| into_link(next, turn[i + 1], v);
            inner = Wrench { force: into(&outer.force), moment: into(&outer.moment) };
        }
        outer
    })
}

/// Torques and forces that hold the arm at rest: `G(q) - J^T w`, N m or N.
///
/// The actuators' shares of [`backward`] (eq. 12.503-12.504 with index `i - 1`); inputs as there, without further loads.
#[must_use]
pub fn holding_torque<S: Scalar, const N: usize>(
    posture: &Posture<S, N>,
    gravity: &Vector3<S>,
    tip: &Wrench<S>,
) -> [S; N] {
    let joint = backward(posture, gravity, &[&[]; N], tip);
    core::array::from_fn(|i| Reaction::of(posture.links[i].kind, &posture.links[i].axis, &joint[i]).actuator)
}

/// A link's points and weight in its own axes.
fn in_link<S: Scalar, const N: usize>(
    posture: &Posture<S, N>,
    i: usize,
    gravity: &Vector3<S>,
) -> (Points<S>, ExternalLoad<S>) {
    let link = &posture.links[i];
    (Points::in_link(posture, i), ExternalLoad::weight(link.mass, &apply_transposed(&link.rotation, gravity)))
}
