//! The slider-crank: positions of its links.

use super::plane::placed;
use super::{
    Branch, CrankRange, GroundJoint, Linkage, LinkageError, LinkagePosture, Member, PlanarBody, PlanarLink, Projection,
    check_body, check_length, slack,
};
use crate::scalar::Real;
use crate::trig::SinCos;
use nalgebra::Vector2;

/// Distances of a slider-crank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliderCrankLengths<S> {
    /// Joint 0 to joint 1, m.
    pub crank: S,
    /// Joint 1 to joint 2, m.
    pub rod: S,
    /// Height of the guide above joint 0, along y, m; negative below.
    pub offset: S,
}

/// A slider-crank: lengths that can close, and the links' bodies. The guide has no friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliderCrank<S> {
    lengths: SliderCrankLengths<S>,
    bodies: [PlanarBody<S>; 3],
}

impl<S: Real> SliderCrank<S> {
    /// `bodies` are crank, rod and slider, each in its own frame (see [`crate::linkage`]); the slider's moment of
    /// inertia has no effect.
    ///
    /// # Errors
    /// An invalid length or body, or lengths that close at no crank angle.
    pub fn new(lengths: SliderCrankLengths<S>, bodies: [PlanarBody<S>; 3]) -> Result<Self, LinkageError<S>> {
        check_length(lengths.crank, Member::Crank)?;
        check_length(lengths.rod, Member::Rod)?;
        if !lengths.offset.is_finite() {
            return Err(LinkageError::Length(Member::Offset));
        }
        for (body, member) in bodies.iter().zip([Member::Crank, Member::Rod, Member::Slider]) {
            check_body(body, member)?;
        }
        let excess = lengths.offset.abs() - lengths.crank - lengths.rod;
        if excess > lengths.slack() {
            return Err(LinkageError::NeverCloses { longest: Member::Offset, excess });
        }
        Ok(Self { lengths, bodies })
    }

    /// Distances.
    #[must_use]
    pub const fn lengths(&self) -> &SliderCrankLengths<S> {
        &self.lengths
    }

    /// Crank, rod, slider.
    #[must_use]
    pub const fn bodies(&self) -> &[PlanarBody<S>; 3] {
        &self.bodies
    }
}

impl<S: Real> SliderCrankLengths<S> {
    /// Greatest difference, m, at which sums of these lengths count as equal.
    fn slack(&self) -> S {
        slack::<S>() * (self.crank + self.rod + self.offset.abs())
    }
}

impl<S: Real> Linkage<S> for SliderCrank<S> {
    /// The rod reaches from the crank pin to the guide. One division, one square root.
    fn posture(&self, crank: &SinCos<S>, branch: Branch) -> Result<LinkagePosture<S>, LinkageError<S>> {
        let SliderCrankLengths { crank: length, rod, offset } = self.lengths;
        let (zero, origin) = (S::zero(), Vector2::zeros());
        let first = Vector2::new(crank.cos, crank.sin);
        let pin = first * length;
        let rise = offset - pin.y;
        let gap = rise.abs() - rod;
        if gap > self.lengths.slack() {
            return Err(LinkageError::TooFar { gap });
        }
        let square = (rod - rise) * (rod + rise);
        let run = if square > zero { square.sqrt() } else { zero };
        let reach = Vector2::new(branch.signed(run), rise);
        let joint = pin + reach;
        let directions = [first, reach * (S::one() / rod), Vector2::x()];
        let (origins, inner, outer) = ([origin, pin, joint], [origin, pin, joint], [pin, joint, joint]);
        let link = |i: usize| {
            let body: &PlanarBody<S> = &self.bodies[i];
            PlanarLink {
                direction: directions[i],
                inner: inner[i],
                outer: outer[i],
                centre: origins[i] + placed(&directions[i], &body.centre),
                mass: body.mass,
                inertia: body.inertia,
            }
        };
        Ok(LinkagePosture { links: core::array::from_fn(link), ground: GroundJoint::Guide })
    }

    fn crank_range(&self) -> CrankRange<S> {
        let SliderCrankLengths { crank, rod, offset } = self.lengths;
        let slack = self.lengths.slack();
        let low = (offset - rod > slack - crank).then(|| (offset - rod) / crank);
        let high = (offset + rod < crank - slack).then(|| (offset + rod) / crank);
        CrankRange { of: Projection::Sine, low, high }
    }

    fn dead_centres(&self, branch: Branch) -> [Option<SinCos<S>>; 2] {
        let SliderCrankLengths { crank, rod, offset } = self.lengths;
        let at = |reach: S, ahead: S| {
            let sin = offset / reach;
            let square = (S::one() - sin) * (S::one() + sin);
            let lies = reach.abs() > self.lengths.slack() && square >= S::zero();
            // Stretched out, the slider is ahead of the pin if the crank points ahead; folded, if it points back.
            lies.then(|| SinCos { sin, cos: branch.signed(ahead * square.sqrt()) })
        };
        [at(crank + rod, S::one()), at(crank - rod, -S::one())]
    }
}
