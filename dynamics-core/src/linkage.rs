//! Planar closed loops with one degree of freedom: the four-bar linkage of Example 324 and the slider-crank of Exercise 7.
//!
//! The links of an arm form an open chain; here the ground also holds the last link. The crank's angle gives the poses
//! of all links ([`Linkage::posture`]). The closure of the loop gives their motion ([`LinkagePosture::coefficients`]).
//! Nine equations of Newton and Euler, solved together, give the forces in the joints and the moment of the motor
//! ([`LinkagePosture::forces`]).
//!
//! ```text
//!                  2                                              1
//!     coupler  ___/ \                                            / \___  rod
//!        1 ___/      \  follower                          crank /      \___
//!         /           \                                        /           \  2
//!  crank /             \                                      0  - - - - - [ ] - - -  guide, `offset` above 0
//!       0 ------------- 3   ground
//! ```
//!
//! Everything lies in one plane. Its origin is the crank's ground pivot, joint 0; x points to the follower's ground
//! pivot, or along the guide; angles count from x towards y. For a linkage in another orientation, turn the gravity
//! vector instead.
//!
//! | link | its own frame: origin, x |
//! |---|---|
//! | crank | joint 0, to joint 1 |
//! | coupler, rod | joint 1, to joint 2 |
//! | follower | joint 3, to joint 2 |
//! | slider | joint 2, along the guide; it does not turn |
//!
//! No angle is ever computed from a direction: the directions of links are unit vectors. Besides the operations of a field, only square
//! roots are needed.

use crate::dynamics::solve::rounding;
use crate::scalar::Real;
use crate::trig::SinCos;
use nalgebra::Vector2;

mod crank_form;
mod error;
mod forces;
mod four_bar;
mod plane;
mod posture;
mod slider_crank;

pub use crank_form::CrankForm;
pub use error::{DeadPoint, LinkageError, Member};
pub use forces::{LinkageForces, LinkageSystem};
pub use four_bar::{FourBar, FourBarLengths, Grashof};
pub use posture::{Coefficients, GroundJoint, LinkagePosture, PlanarLink, PlanarMotion};
pub use slider_crank::{SliderCrank, SliderCrankLengths};

/// One of the two ways to close the loop at one crank angle.
///
/// A linkage is assembled in one of them. It changes to the other only through a dead point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Branch {
    /// Four-bar: joint 2 to the left of the line from joint 1 to joint 3; with the crank between 0 and a half turn no two links
    /// cross. Slider-crank: the slider ahead of the crank pin, towards x.
    #[default]
    Open,
    /// Four-bar: the mirror image about that line. Slider-crank: the slider behind the crank pin.
    Crossed,
}

/// A rigid body in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarBody<S> {
    /// Mass, kg.
    pub mass: S,
    /// Mass centre in the link's frame, m.
    pub centre: Vector2<S>,
    /// Moment of inertia about the mass centre, kg m^2.
    pub inertia: S,
}

/// A loop that its crank's angle determines.
pub trait Linkage<S: Real> {
    /// The poses of all links, with the crank at the angle of this sine and cosine.
    ///
    /// At a dead point the links still have poses, and both branches give the same.
    ///
    /// # Errors
    /// [`LinkageError::TooFar`], [`LinkageError::TooNear`]: the loop does not close at this angle, and by how much.
    /// [`LinkageError::Dead`]: the crank pin lies on the follower's pivot, and coupler and follower may point anywhere.
    fn posture(&self, crank: &SinCos<S>, branch: Branch) -> Result<LinkagePosture<S>, LinkageError<S>>;

    /// The crank angles at which the loop closes.
    fn crank_range(&self) -> CrankRange<S>;

    /// The crank angles at which crank and coupler (rod) are in line, stretched out first, then folded; `None` if there is no such angle.
    ///
    /// There the follower (slider) turns back: it does not move while the crank moves, and could not drive the crank.
    fn dead_centres(&self, branch: Branch) -> [Option<SinCos<S>>; 2];
}

/// Function of the crank's angle to which bounds apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Its cosine, the crank's part along x.
    Cosine,
    /// Its sine, the crank's part along y.
    Sine,
}

/// The crank angles at which a loop closes: those whose cosine (or sine) lies within bounds.
///
/// One bound leaves one arc. Two bounds leave two arcs, mirrored about the axis, and the crank stays in the arc in which it was assembled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrankRange<S> {
    /// The bounded function of the crank's angle.
    pub of: Projection,
    /// Its least value; `None` if that bound is never met.
    pub low: Option<S>,
    /// Its greatest value; `None` if that bound is never met.
    pub high: Option<S>,
}

impl<S: Real> CrankRange<S> {
    /// True if the crank can make full turns.
    #[must_use]
    pub fn is_full_turn(&self) -> bool {
        self.low.is_none() && self.high.is_none()
    }

    /// The ends, which are dead points: the two angles of the lower bound, then those of the higher.
    #[must_use]
    pub fn ends(&self) -> [Option<SinCos<S>>; 4] {
        let mirrored = |bound: Option<S>| {
            let Some(bound) = bound else { return [None; 2] };
            let other = ((S::one() - bound) * (S::one() + bound)).sqrt();
            let at = |other| match self.of {
                Projection::Cosine => SinCos { sin: other, cos: bound },
                Projection::Sine => SinCos { sin: bound, cos: other },
            };
            [Some(at(other)), Some(at(-other))]
        };
        let ([a, b], [c, d]) = (mirrored(self.low), mirrored(self.high));
        [a, b, c, d]
    }
}

/// Relative difference that rounding may leave between equal lengths.
fn slack<S: Real>() -> S {
    rounding(16)
}

fn check_length<S: Real>(length: S, member: Member) -> Result<(), LinkageError<S>> {
    if length > S::zero() && length.is_finite() { Ok(()) } else { Err(LinkageError::Length(member)) }
}

fn check_body<S: Real>(body: &PlanarBody<S>, member: Member) -> Result<(), LinkageError<S>> {
    let zero = S::zero();
    let finite = [body.mass, body.centre.x, body.centre.y, body.inertia].iter().all(|x| x.is_finite());
    let massless = body.mass == zero && body.inertia == zero;
    if finite && (massless || body.mass > zero && body.inertia >= zero) {
        Ok(())
    } else {
        Err(LinkageError::Body(member))
    }
}

impl Branch {
    /// `size`, its sign changed on the crossed branch.
    fn signed<S: Real>(self, size: S) -> S {
        match self {
            Self::Open => size,
            Self::Crossed => -size,
        }
    }
}
