//! The four-bar linkage: positions of its links.

use super::plane::{dot, placed, quarter_turn};
use super::{
    Branch, CrankRange, DeadPoint, GroundJoint, Linkage, LinkageError, LinkagePosture, Member, PlanarBody, PlanarLink,
    Projection, check_body, check_length, slack,
};
use crate::scalar::Real;
use crate::trig::SinCos;
use nalgebra::Vector2;

/// Distances between the joints of each link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourBarLengths<S> {
    /// Joint 0 to joint 3, m.
    pub ground: S,
    /// Joint 0 to joint 1, m.
    pub crank: S,
    /// Joint 1 to joint 2, m.
    pub coupler: S,
    /// Joint 3 to joint 2, m.
    pub follower: S,
}

/// Classes of four-bar linkages by Grashof's rule. A link turns fully against all others if and only if it is the shortest, and the sum of the
/// shortest and the longest length is less than the sum of the other two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grashof {
    /// The crank is shortest: it turns fully, the follower rocks.
    CrankRocker,
    /// The ground is shortest: crank and follower turn fully.
    DoubleCrank,
    /// The coupler is shortest: it turns fully, crank and follower rock.
    DoubleRocker,
    /// The follower is shortest: it turns fully, the crank rocks.
    RockerCrank,
    /// Both sums are equal: all links can be in line, where the branches meet.
    ChangePoint,
    /// The sum is greater: no link turns fully.
    TripleRocker,
}

/// A four-bar linkage: lengths that can close, and the links' bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourBar<S> {
    lengths: FourBarLengths<S>,
    bodies: [PlanarBody<S>; 3],
}

impl<S: Real> FourBar<S> {
    /// `bodies` are crank, coupler and follower, each in its own frame (see [`crate::linkage`]).
    ///
    /// # Errors
    /// An invalid length or body, or lengths that close at no crank angle.
    pub fn new(lengths: FourBarLengths<S>, bodies: [PlanarBody<S>; 3]) -> Result<Self, LinkageError<S>> {
        let named = lengths.named();
        for (length, member) in named {
            check_length(length, member)?;
        }
        for (body, (_, member)) in bodies.iter().zip(&named[1..]) {
            check_body(body, *member)?;
        }
        let sorted = lengths.sorted();
        let (longest, member) = sorted[3];
        let excess = longest - (sorted[0].0 + sorted[1].0 + sorted[2].0);
        if excess > lengths.slack() {
            return Err(LinkageError::NeverCloses { longest: member, excess });
        }
        Ok(Self { lengths, bodies })
    }

    /// Distances between the joints.
    #[must_use]
    pub const fn lengths(&self) -> &FourBarLengths<S> {
        &self.lengths
    }

    /// Crank, coupler, follower.
    #[must_use]
    pub const fn bodies(&self) -> &[PlanarBody<S>; 3] {
        &self.bodies
    }

    /// The class of the linkage. Sums that differ only by rounding count as equal.
    #[must_use]
    pub fn class(&self) -> Grashof {
        let sorted = self.lengths.sorted();
        let over = sorted[0].0 + sorted[3].0 - sorted[1].0 - sorted[2].0;
        if over.abs() <= self.lengths.slack() {
            return Grashof::ChangePoint;
        }
        if over > S::zero() {
            return Grashof::TripleRocker;
        }
        match sorted[0].1 {
            Member::Ground => Grashof::DoubleCrank,
            Member::Crank => Grashof::CrankRocker,
            Member::Follower => Grashof::RockerCrank,
            _ => Grashof::DoubleRocker,
        }
    }

    fn link(&self, index: usize, direction: Vector2<S>, origin: Vector2<S>, ends: [Vector2<S>; 2]) -> PlanarLink<S> {
        let body = &self.bodies[index];
        PlanarLink {
            direction,
            inner: ends[0],
            outer: ends[1],
            centre: origin + placed(&direction, &body.centre),
            mass: body.mass,
            inertia: body.inertia,
        }
    }
}

impl<S: Real> FourBarLengths<S> {
    fn named(&self) -> [(S, Member); 4] {
        [
            (self.ground, Member::Ground),
            (self.crank, Member::Crank),
            (self.coupler, Member::Coupler),
            (self.follower, Member::Follower),
        ]
    }

    /// Shortest first; of equal ones the ground, then the crank, comes first.
    fn sorted(&self) -> [(S, Member); 4] {
        let mut named = self.named();
        for end in (1..named.len()).rev() {
            for i in 0..end {
                if named[i].0 > named[i + 1].0 {
                    named.swap(i, i + 1);
                }
            }
        }
        named
    }

    /// Greatest difference, m, at which sums of these lengths count as equal.
    fn slack(&self) -> S {
        slack::<S>() * (self.ground + self.crank + self.coupler + self.follower)
    }
}

impl<S: Real> Linkage<S> for FourBar<S> {
    /// Joint 2 is at an intersection of the circles about joint 1 (coupler) and joint 3 (follower). Four divisions, two square roots.
    fn posture(&self, crank: &SinCos<S>, branch: Branch) -> Result<LinkagePosture<S>, LinkageError<S>> {
        let FourBarLengths { ground, crank: length, coupler, follower } = self.lengths;
        let (zero, slack) = (S::zero(), self.lengths.slack());
        let origin = Vector2::zeros();
        let first = Vector2::new(crank.cos, crank.sin);
        let pin = first * length;
        let pivot = Vector2::new(ground, zero);
        let across = pivot - pin;
        let distance = dot(&across, &across).sqrt();
        let (sum, difference) = (coupler + follower, coupler - follower);
        let (missing, past) = (distance - sum, difference.abs() - distance);
        if missing > slack {
            return Err(LinkageError::TooFar { gap: missing });
        }
        if past > slack {
            return Err(LinkageError::TooNear { gap: past });
        }
        // Both ends of the diagonal coincide: the triangle above it has no direction.
        if distance <= slack {
            return Err(LinkageError::Dead(DeadPoint::CouplerAndFollower));
        }
        let half = S::one() / (distance + distance);
        // Products of differences of lengths, as in Heron's formula: the height keeps its digits if the triangle is flat.
        let along = (distance * distance + sum * difference) * half;
        let height_squared = -missing * (sum + distance) * (distance + difference) * (distance - difference);
        // Within the slack of a dead point the product may come out below zero.
        let height = if height_squared > zero { height_squared.sqrt() * half } else { zero };
        let diagonal = across * (half + half);
        let rise = diagonal * along + quarter_turn(&diagonal) * branch.signed(height);
        let joint = pin + rise;
        let (second, third) = (rise * (S::one() / coupler), (joint - pivot) * (S::one() / follower));
        Ok(LinkagePosture {
            links: [
                self.link(0, first, origin, [origin, pin]),
                self.link(1, second, pin, [pin, joint]),
                self.link(2, third, pivot, [joint, pivot]),
            ],
            ground: GroundJoint::Pin,
        })
    }

    fn crank_range(&self) -> CrankRange<S> {
        let FourBarLengths { ground, crank, coupler, follower } = self.lengths;
        let slack = self.lengths.slack();
        // The diagonal between the pins, by the law of cosines, must lie between |coupler - follower| and coupler + follower.
        let cosine = |diagonal: S| {
            let twice = ground * crank;
            (ground * ground + crank * crank - diagonal * diagonal) / (twice + twice)
        };
        let (longest, shortest) = (coupler + follower, (coupler - follower).abs());
        let low = (ground + crank > longest + slack).then(|| cosine(longest));
        let high = ((ground - crank).abs() + slack < shortest).then(|| cosine(shortest));
        CrankRange { of: Projection::Cosine, low, high }
    }

    fn dead_centres(&self, branch: Branch) -> [Option<SinCos<S>>; 2] {
        let FourBarLengths { ground, crank, coupler, follower } = self.lengths;
        // Joint 2 is at `reach` along the crank, on the other side of joint 0 if that is below zero.
        let at = |reach: S, left: S| {
            let twice = reach * ground;
            let cos = (reach * reach + ground * ground - follower * follower) / (twice + twice);
            let square = (S::one() - cos) * (S::one() + cos);
            let lies = reach.abs() > self.lengths.slack() && square >= S::zero();
            // Stretched out, joint 2 is left of the diagonal if the crank points up; folded, if it points down.
            lies.then(|| SinCos { sin: branch.signed(left * square.sqrt()), cos })
        };
        [at(crank + coupler, S::one()), at(crank - coupler, -S::one())]
    }
}

impl core::fmt::Display for Grashof {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::CrankRocker => "crank-rocker: the crank turns fully, the follower rocks",
            Self::DoubleCrank => "double crank: crank and follower turn fully",
            Self::DoubleRocker => "double rocker: the coupler turns fully, crank and follower rock",
            Self::RockerCrank => "rocker-crank: the follower turns fully, the crank rocks",
            Self::ChangePoint => "change point: all links can come to lie in line",
            Self::TripleRocker => "triple rocker: no link turns fully",
        })
    }
}
