//! Reasons why a linkage, or a question about it, is impossible.

use crate::scalar::Real;

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

/// Reason why a linkage, or a question about it, is impossible.
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

/// A length for messages: in single precision, without the digits that a subtraction left.
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
