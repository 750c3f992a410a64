//! Torques that hold an arm at rest, and the posture that needs least.

mod report;
mod search;
mod sweep;

use super::numbers::{finite, finite_entries};
use clap::ValueEnum;
use dynamics_core::chapter::posture::{Chain, Posture};
use dynamics_core::chapter::reactions::Reaction;
use dynamics_core::chapter::statics::{backward, holding_torque};
use dynamics_core::trig::Libm;
use dynamics_core::{Inertia, JointKind, Limits, Trig, Wrench};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::Robot;
use search::{Target, search};
use serde::Serialize;
use sim::failure::Failure;
use sim::run::record::JointLabel;
pub use sweep::{Least, Sweep, sweep};

/// Which axes a wrench is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Axes {
    /// Each link's own, z along its joint.
    Link,
    /// The base frame's.
    Base,
}

/// Input of a statics computation.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// Joint position, rad or m; `None` with [`Question::minimise`] means the middle of the limits.
    pub q: Option<Vec<f64>>,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Vec<f64>,
    /// Mass of a point load at the tip (kg) and, if given, its position in the tip frame (m).
    pub load: Option<Vec<f64>>,
    /// Force (N) and moment (N m) of the environment on the arm at the tip's origin, in tip axes.
    pub tip_wrench: Option<Vec<f64>>,
    /// Quantity to minimise: a joint's name or number, `total` or `potential`.
    pub minimise: Option<String>,
    /// Joints that stay fixed in the search.
    pub hold: Vec<String>,
    /// Axes of the wrenches.
    pub axes: Axes,
}

/// An arm at rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// Name of the robot.
    pub robot: String,
    /// Joint position, rad or m.
    pub q: Vec<f64>,
    /// Torques and forces that hold the arm, `G(q) - J^T w`, N m or N.
    pub tau: Vec<f64>,
    /// Potential energy `-sum m g . r` of arm and load, J.
    pub potential: f64,
    /// `link` or `base`.
    pub axes: &'static str,
    /// Every joint, base first.
    pub joints: Vec<JointAnswer>,
    /// Result of the search for the posture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minimised: Option<Minimised>,
}

/// Load on a joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointAnswer {
    /// Name of the joint.
    pub name: String,
    /// Torque or force of the actuator, N m or N.
    pub actuator: f64,
    /// Limit of the actuator; absent without a limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// Force on the link from the previous link, N.
    pub force: [f64; 3],
    /// Moment on the link about the joint's origin, N m.
    pub moment: [f64; 3],
    /// Bearing force across the axis, N.
    pub radial: f64,
    /// Bearing force along the axis, N; absent if the actuator carries it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axial: Option<f64>,
    /// Bearing moment across the axis, N m.
    pub tilting: f64,
    /// Bearing moment along the axis, N m; absent if the actuator carries it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twisting: Option<f64>,
    #[serde(skip)]
    label: JointLabel,
}

/// Result of a search for a posture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Minimised {
    /// The minimised quantity: a joint's name, `total` or `potential`.
    pub what: String,
    /// Its least value: torque magnitude (N m or N), sum of squares, or potential energy (J).
    pub value: f64,
    /// Number of starting points.
    pub starts: usize,
    /// Number of evaluated postures.
    pub postures: u64,
}

/// Compute the torques that hold the arm, after a search for the posture if requested.
///
/// # Errors
/// [`Failure::Input`]: a list of the wrong length, a posture outside the limits, an unknown joint, a search without
/// bounds.
pub fn answer<const N: usize>(robot: &Robot, question: &Question) -> Result<Answer, Failure> {
    let model = robot.model::<N>().map_err(Failure::input)?;
    let still = Still::<N>::new(robot, question)?;
    let limits = model.links().map(|link| link.limits);
    let given = question.q.as_deref().map(|q| posture::<N>(robot, &limits, q)).transpose()?;
    let (q, minimised) = match (&question.minimise, given) {
        (Some(what), given) => {
            let target = Target::named(what, robot).map_err(wrong)?;
            let (q, found) = search(robot, &still, &target, given, &question.hold)?;
            (q, Some(found))
        }
        (None, Some(q)) => (q, None),
        (None, None) => return Err(wrong(format!("no posture: expected --q with {N} numbers"))),
    };
    let (potential, reactions) = (still.potential(&q), still.reactions(&q, question.axes));
    let joints = robot.joints.iter().zip(&reactions).map(|(joint, reaction)| {
        let load = reaction.bearing_load();
        let turns = joint.spec.kind == JointKind::Revolute;
        JointAnswer {
            name: joint.name.clone(),
            actuator: reaction.actuator,
            limit: Some(joint.spec.limits.torque).filter(|limit| limit.is_finite()),
            force: reaction.wrench.force.into(),
            moment: reaction.wrench.moment.into(),
            radial: load.radial,
            axial: turns.then_some(load.axial),
            tilting: load.tilting,
            twisting: (!turns).then_some(load.twisting),
            label: JointLabel { name: joint.name.clone(), kind: joint.spec.kind },
        }
    });
    let answer = Answer {
        robot: robot.name.clone(),
        q: q.to_vec(),
        tau: reactions.iter().map(|reaction| reaction.actuator).collect(),
        potential,
        axes: match question.axes {
            Axes::Link => "link",
            Axes::Base => "base",
        },
        joints: joints.collect(),
        minimised,
    };
    let all = answer.joints.iter().flat_map(|joint| joint.force.iter().chain(&joint.moment));
    if all.chain([&answer.potential]).any(|x| !x.is_finite()) {
        return Err(wrong("the numbers are too large: a wrench overflows".to_owned()));
    }
    Ok(answer)
}

/// An arm with its loads.
struct Still<const N: usize> {
    chain: Chain<f64, N>,
    gravity: Vector3<f64>,
    /// Wrench at the tip, in tip axes.
    push: Wrench<f64>,
}

impl<const N: usize> Still<N> {
    fn new(robot: &Robot, question: &Question) -> Result<Self, Failure> {
        let model = robot.model::<N>().map_err(Failure::input)?;
        let held = load(question.load.as_deref()).map_err(wrong)?;
        Ok(Self {
            chain: Chain::new(&model, &held),
            gravity: finite::<3>("--gravity", &question.gravity, "gx, gy, gz").map_err(wrong)?.into(),
            push: wrench(question.tip_wrench.as_deref()).map_err(wrong)?,
        })
    }

    fn posture(&self, q: &[f64; N]) -> Posture<f64, N> {
        self.chain.posture(&Libm.sin_cos_all(q), q)
    }

    /// The tip's wrench in base axes.
    fn push(&self, posture: &Posture<f64, N>) -> Wrench<f64> {
        self.push.in_parent(&posture.tip.rotation, &Vector3::zeros())
    }

    fn torque(&self, q: &[f64; N]) -> [f64; N] {
        let posture = self.posture(q);
        holding_torque(&posture, &self.gravity, &self.push(&posture))
    }

    fn potential(&self, q: &[f64; N]) -> f64 {
        self.posture(q).links.iter().map(|link| -link.mass * self.gravity.dot(&link.centre)).sum()
    }

    fn reactions(&self, q: &[f64; N], axes: Axes) -> [Reaction<f64>; N] {
        let posture = self.posture(q);
        let joint = backward(&posture, &self.gravity, &[&[]; N], &self.push(&posture));
        core::array::from_fn(|i| {
            let link = &posture.links[i];
            match axes {
                Axes::Base => Reaction::of(link.kind, &link.axis, &joint[i]),
                Axes::Link => {
                    let local = joint[i].in_child(&link.rotation, &Vector3::zeros());
                    Reaction::of(link.kind, &Vector3::z(), &local)
                }
            }
        })
    }
}

/// Check that a posture is inside the limits.
fn posture<const N: usize>(robot: &Robot, limits: &[Limits<f64>; N], q: &[f64]) -> Result<[f64; N], Failure> {
    let q = finite::<N>("--q", q, "one for each joint").map_err(wrong)?;
    for (i, joint) in robot.joints.iter().enumerate() {
        let (low, high) = limits[i].position;
        if !(low..=high).contains(&q[i]) {
            let unit = JointLabel { name: joint.name.clone(), kind: joint.spec.kind }.position_unit();
            let help = format!("expected a position from {low} to {high} {unit}");
            let at = format!("joint {}, {}, at {} {unit}", i + 1, joint.name, q[i]);
            let (side, limit) = if q[i] < low { ("below", low) } else { ("above", high) };
            return Err(Failure::Input(miette::miette!(
                help = help,
                "--q: {at} is {side} its limit of {limit} {unit}"
            )));
        }
    }
    Ok(q)
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

fn wrench(values: Option<&[f64]>) -> Result<Wrench<f64>, String> {
    let [fx, fy, fz, mx, my, mz] = finite::<6>("--tip-wrench", values.unwrap_or(&[0.0; 6]), "fx, fy, fz, mx, my, mz")?;
    Ok(Wrench { force: Vector3::new(fx, fy, fz), moment: Vector3::new(mx, my, mz) })
}

fn wrong(problem: String) -> Failure {
    Failure::Input(miette::miette!(help = "see `newtau help model statics`", "{problem}"))
}
