//! Planar closed loops with one degree of freedom: the four-bar linkage of Example 324 and the slider-crank of Exercise 7.
//!
//! An arm's links hang one from the other; here the ground also holds the last one. The crank's angle gives the poses
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
//! pivot, or along the guide; angles count from x towards y. For a linkage that is mounted otherwise, turn the gravity
//! vector instead.
//!
//! | link | its own frame: origin, x |
//! |---|---|
//! | crank | joint 0, to joint 1 |
//! | coupler, rod | joint 1, to joint 2 |
//! | follower | joint 3, to joint 2 |
//! | slider | joint 2, along the guide; it does not turn |
//!
//! No angle is ever computed from a direction: links are unit vectors. Beside the operations of a field only square
//! roots are needed.

use crate::dynamics::solve::rounding;
use crate::scalar::Real;
use crate::trig::SinCos;
use nalgebra::Vector2;

mod crank_form;
mod forces;
mod four_bar;
mod posture;
mod slider_crank;

pub use crank_form::CrankForm;
pub use forces::{LinkageForces, LinkageSystem};
pub use four_bar::{FourBar, FourBarLengths, Grashof};
pub use posture::{Coefficients, GroundJoint, LinkagePosture, PlanarLink, PlanarMotion};
pub use slider_crank::{SliderCrank, SliderCrankLengths};

/// Which of the two ways to close the loop at one crank angle.
///
/// A linkage is assembled in one of them. It changes to the other only through a dead point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Branch {
    /// Four-bar: joint 2 to the left of the line from joint 1 to joint 3; with the crank between 0 and a half turn no two links
    /// cross. Slider-crank: the slider ahead of the crank pin, towards x.
    #[default]
    Open,
    /// The mirror image about that line; the slider behind the crank pin.
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

/// A length or a body of a linkage, in messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Member {
    /// The frame between the two ground pivots.
    Ground,
    /// The driven link.
    Crank,
    /// The link between crank and follower.
    Coupler,
    /// The link that the ground holds at the other end of the loop.
    Follower,
    /// The link between crank and slider.
    Rod,
    /// The link in the guide.
    Slider,
    /// The distance of the guide from the crank's pivot.
    Offset,
}

/// Positions of the links in which the crank does not determine the motion of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeadPoint {
    /// Coupler and follower in line: the crank is at an end of its range.
    CouplerAndFollower,
    /// The rod square to the guide: the crank is at an end of its range.
    RodAcrossGuide,
}

/// Why a linkage, or a question about it, makes no sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinkageError<S> {
    /// A length that is not above zero, or not finite.
    Length(Member),
    /// A mass or inertia below zero, an inertia without mass, or a number that is not finite.
    Body(Member),
    /// It closes at no crank angle: this length exceeds all others together.
    NeverCloses {
        /// The length that is too great.
        longest: Member,
        /// By how much, m.
        excess: S,
    },
    /// At this crank angle the links do not reach each other.
    TooFar {
        /// Distance between them, m.
        gap: S,
    },
    /// At this crank angle the longer of coupler and follower reaches past the end of the shorter.
    TooNear {
        /// By how much, m.
        gap: S,
    },
    /// The loop equations are singular: velocities are undetermined, and no finite moment drives the crank.
    Dead(DeadPoint),
    /// Nothing that moves with the crank has mass.
    NoInertia,
}

/// A loop that its crank's angle determines.
pub trait Linkage<S: Real> {
    /// Where all links are, with the crank at the angle of this sine and cosine.
    ///
    /// At a dead point the links still have a place, and both branches have the same.
    ///
    /// # Errors
    /// [`LinkageError::TooFar`], [`LinkageError::TooNear`]: the loop does not close at this angle, and by how much.
    /// [`LinkageError::Dead`]: the crank pin lies on the follower's pivot, and coupler and follower may point anywhere.
    fn posture(&self, crank: &SinCos<S>, branch: Branch) -> Result<LinkagePosture<S>, LinkageError<S>>;

    /// The crank angles at which the loop closes.
    fn crank_range(&self) -> CrankRange<S>;

    /// The crank angles at which crank and coupler (rod) lie in line, stretched out first, then folded, where there are such.
    ///
    /// There the follower (slider) turns back: it stands still while the crank moves, and could not drive the crank.
    fn dead_centres(&self, branch: Branch) -> [Option<SinCos<S>>; 2];
}

/// Function of the crank's angle that is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Its cosine, the crank's part along x.
    Cosine,
    /// Its sine, the crank's part along y.
    Sine,
}

/// The crank angles at which a loop closes: those whose cosine (sine) lies within bounds.
///
/// One bound leaves one arc. Two leave two arcs, mirrored about the axis, and the crank stays in the one it was put in.
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
    /// True if the crank turns all the way round.
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

/// `a x b`, its part along z.
pub(crate) fn cross<S: Real>(a: &Vector2<S>, b: &Vector2<S>) -> S {
    a.x * b.y - a.y * b.x
}

/// `z x a`: a quarter turn on.
pub(crate) fn quarter_turn<S: Real>(a: &Vector2<S>) -> Vector2<S> {
    Vector2::new(-a.y, a.x)
}

/// Inner product; nalgebra's own goes through a general kernel.
pub(crate) fn dot<S: Real>(a: &Vector2<S>, b: &Vector2<S>) -> S {
    a.x * b.x + a.y * b.y
}

/// A point of a link's frame whose x lies along the unit vector `direction`.
fn placed<S: Real>(direction: &Vector2<S>, point: &Vector2<S>) -> Vector2<S> {
    direction * point.x + quarter_turn(direction) * point.y
}

/// Relative difference that rounding may leave between equal lengths.
fn slack<S: Real>() -> S {
    rounding(16)
}

/// Square of the sine of an angle between links below which it is rounding error only: near a dead point the sine is
/// the square root of a difference of lengths, so half of its digits are gone.
fn dead_sine_squared<S: Real>() -> S {
    rounding(64)
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

impl core::fmt::Display for Member {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Ground => "ground",
            Self::Crank => "crank",
            Self::Coupler => "coupler",
            Self::Follower => "follower",
            Self::Rod => "rod",
            Self::Slider => "slider",
            Self::Offset => "offset",
        })
    }
}

impl core::fmt::Display for DeadPoint {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::CouplerAndFollower => "coupler and follower lie in line",
            Self::RodAcrossGuide => "the rod lies square to the guide",
        })
    }
}

/// A length as a person reads it: without the digits that subtraction left.
fn short<S: Real>(length: S) -> f32 {
    length.to_f64() as f32
}

impl<S: Real> core::fmt::Display for LinkageError<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length(Member::Offset) => write!(f, "the offset is not finite"),
            Self::Length(member) => write!(f, "the length of the {member} is not above zero"),
            Self::Body(member) => write!(f, "no body has the mass and inertia of the {member}"),
            Self::NeverCloses { longest, excess } => {
                let excess = short(*excess);
                write!(f, "the loop never closes: the {longest} is {excess} m longer than all other lengths together")
            }
            Self::TooFar { gap } => write!(f, "the loop does not close: {} m are missing", short(*gap)),
            Self::TooNear { gap } => {
                write!(f, "the loop does not close: one link reaches {} m past the other", short(*gap))
            }
            Self::Dead(point) => write!(f, "dead point: {point}"),
            Self::NoInertia => write!(f, "nothing that moves with the crank has mass"),
        }
    }
}

impl<S: Real> core::error::Error for LinkageError<S> {}
