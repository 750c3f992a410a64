//! Planar closed loop, as a linkage file describes it.

use crate::names::Named;
use dynamics_core::SinCos;
use dynamics_core::linkage::{
    Branch, CrankRange, FourBar, Linkage, LinkageError, LinkagePosture, PlanarBody, SliderCrank,
};
use nalgebra::Vector2;
use std::path::PathBuf;

pub(crate) const FOUR_BAR: &str = "four-bar";
pub(crate) const SLIDER_CRANK: &str = "slider-crank";

/// A linkage: lengths that close at some crank angle, physically possible bodies, and the gravity at its mounting.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkageFile {
    /// Short name.
    pub name: String,
    /// Source of the numbers.
    pub source: String,
    /// Gravitational acceleration in the linkage's plane, m/s^2: along the ground or the guide, and across it.
    pub gravity: Vector2<f64>,
    /// The loop.
    pub mechanism: Mechanism,
    /// The file from which it was read.
    pub path: PathBuf,
}

impl Named for Branch {
    const NAMES: &'static [(&'static str, &'static str, Self)] = &[
        (
            "open",
            "Joint 2 to the left of the line from the crank pin to the follower's pivot; the slider ahead of the crank pin",
            Self::Open,
        ),
        ("crossed", "The mirror image about that line; the slider behind the crank pin", Self::Crossed),
    ];
}

/// The supported kinds of loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mechanism {
    /// Ground, crank, coupler, follower.
    FourBar(FourBar<f64>),
    /// Crank, rod, slider.
    SliderCrank(SliderCrank<f64>),
}

impl Mechanism {
    /// The name of the kind in a file.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::FourBar(_) => FOUR_BAR,
            Self::SliderCrank(_) => SLIDER_CRANK,
        }
    }

    /// Bodies of crank, coupler (rod) and follower (slider), in this order.
    #[must_use]
    pub const fn bodies(&self) -> &[PlanarBody<f64>; 3] {
        match self {
            Self::FourBar(linkage) => linkage.bodies(),
            Self::SliderCrank(linkage) => linkage.bodies(),
        }
    }
}

impl Linkage<f64> for Mechanism {
    fn posture(&self, crank: &SinCos<f64>, branch: Branch) -> Result<LinkagePosture<f64>, LinkageError<f64>> {
        match self {
            Self::FourBar(linkage) => linkage.posture(crank, branch),
            Self::SliderCrank(linkage) => linkage.posture(crank, branch),
        }
    }

    fn crank_range(&self) -> CrankRange<f64> {
        match self {
            Self::FourBar(linkage) => linkage.crank_range(),
            Self::SliderCrank(linkage) => linkage.crank_range(),
        }
    }

    fn dead_centres(&self, branch: Branch) -> [Option<SinCos<f64>>; 2] {
        match self {
            Self::FourBar(linkage) => linkage.dead_centres(branch),
            Self::SliderCrank(linkage) => linkage.dead_centres(branch),
        }
    }
}
