//! An arm at rest with its loads.

use crate::numbers::{finite, finite_entries, wrench};
use crate::options::GravityArgs;
use clap::{Args, ValueEnum};
use dynamics_core::chapter::posture::{Chain, Posture};
use dynamics_core::chapter::reactions::Reaction;
use dynamics_core::chapter::statics::{backward, holding_torque};
use dynamics_core::trig::Libm;
use dynamics_core::{Inertia, Trig, Wrench};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::Robot;
use sim::failure::Failure;

/// Axes of a reported wrench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum WrenchFrame {
    /// Each link's own, z along its joint.
    Link,
    /// The base frame's.
    Base,
}

/// Input of a statics computation.
#[derive(Clone, Debug, Default, PartialEq, Args)]
pub struct StaticsRequest {
    /// Joint positions, rad or m. With --minimise they are the start of the search and may be left out.
    #[arg(
        long,
        value_name = "Q1,Q2,..",
        value_delimiter = ',',
        allow_hyphen_values = true,
        required_unless_present = "minimise"
    )]
    pub q: Option<Vec<f64>>,
    /// Gravity.
    #[command(flatten)]
    pub gravity: GravityArgs,
    /// A point mass at the tip: kg, and its position in the tip frame, m (the origin if left out).
    #[arg(long, value_name = "MASS[,X,Y,Z]", value_delimiter = ',', allow_hyphen_values = true)]
    pub load: Option<Vec<f64>>,
    /// Wrench of the environment on the arm at the tip, in tip axes, N and N m.
    #[arg(long, value_name = "FX,FY,FZ,MX,MY,MZ", value_delimiter = ',', allow_hyphen_values = true)]
    pub tip_wrench: Option<Vec<f64>>,
    /// Find the posture with the least torque of a joint (its name or number), sum of squared torques (total), or potential energy (potential).
    #[arg(long, value_name = "JOINT|total|potential")]
    pub minimise: Option<String>,
    /// Joints (names or numbers) that stay at their --q during the search.
    #[arg(long, value_name = "JOINT,..", value_delimiter = ',', requires_all = ["q", "minimise"])]
    pub hold: Vec<String>,
}

/// An arm with its loads.
pub(super) struct Still<const N: usize> {
    chain: Chain<f64, N>,
    gravity: Vector3<f64>,
    /// Wrench at the tip, in tip axes.
    push: Wrench<f64>,
}

impl<const N: usize> Still<N> {
    pub(super) fn new(robot: &Robot, question: &StaticsRequest) -> Result<Self, Failure> {
        let model = robot.model::<N>().map_err(Failure::input)?;
        let held = load(question.load.as_deref()).map_err(wrong)?;
        Ok(Self {
            chain: Chain::new(&model, &held),
            gravity: finite::<3>("--gravity", &question.gravity.of(robot), "gx, gy, gz").map_err(wrong)?.into(),
            push: wrench("--tip-wrench", question.tip_wrench.as_deref().unwrap_or(&[0.0; 6])).map_err(wrong)?,
        })
    }

    fn posture(&self, q: &[f64; N]) -> Posture<f64, N> {
        self.chain.posture(&Libm.sin_cos_all(q), q)
    }

    /// The tip's wrench in base axes.
    fn push(&self, posture: &Posture<f64, N>) -> Wrench<f64> {
        self.push.in_parent(&posture.tip.rotation, &Vector3::zeros())
    }

    pub(super) fn torque(&self, q: &[f64; N]) -> [f64; N] {
        let posture = self.posture(q);
        holding_torque(&posture, &self.gravity, &self.push(&posture))
    }

    pub(super) fn potential(&self, q: &[f64; N]) -> f64 {
        self.posture(q).links.iter().map(|link| -link.mass * self.gravity.dot(&link.centre)).sum()
    }

    pub(super) fn reactions(&self, q: &[f64; N], axes: WrenchFrame) -> [Reaction<f64>; N] {
        let posture = self.posture(q);
        let joint = backward(&posture, &self.gravity, &[&[]; N], &self.push(&posture));
        core::array::from_fn(|i| {
            let link = &posture.links[i];
            match axes {
                WrenchFrame::Base => Reaction::of(link.kind, &link.axis, &joint[i]),
                WrenchFrame::Link => {
                    let local = joint[i].in_child(&link.rotation, &Vector3::zeros());
                    Reaction::of(link.kind, &Vector3::z(), &local)
                }
            }
        })
    }
}

/// Inertia of a point mass in the tip frame.
fn load(load: Option<&[f64]>) -> Result<Inertia<f64>, String> {
    let Some(load) = load else { return Ok(Inertia::zero()) };
    let (mass, place) = match load {
        [mass] => (mass, Vector3::zeros()),
        [mass, x, y, z] => (mass, Vector3::new(*x, *y, *z)),
        _ => return Err(format!("`--load` has {} numbers; expected 1 or 4: mass, or mass, x, y, z", load.len())),
    };
    finite_entries("--load", load)?;
    if *mass < 0.0 {
        return Err(format!("`--load`: a mass of {mass} kg; expected none below zero"));
    }
    Ok(Inertia::from_mass_centre(*mass, &place, &Matrix3::zeros()))
}

pub(super) fn wrong(problem: String) -> Failure {
    Failure::Input(miette::miette!(help = "see `newtau help model statics`", "{problem}"))
}
