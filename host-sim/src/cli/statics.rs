//! `statics`: what holds an arm at rest, and the posture that takes least.

use crate::cli::dynamics::numbers;
use crate::cli::{AxesName, StaticsArgs};
use crate::failure::{self, Failure};
use crate::run::record::JointLabel;
use crate::run::summary::engineering;
use crate::study::posture_search::{self, STARTS};
use comfy_table::{CellAlignment, Table, presets};
use core::f64::consts::{PI, TAU};
use dynamics_core::posture::{Chain, Posture};
use dynamics_core::reactions::Reaction;
use dynamics_core::statics::{backward, holding_torque};
use dynamics_core::trig::Libm;
use dynamics_core::{Inertia, JointKind, Limits, Trig, Wrench};
use nalgebra::{Matrix3, Vector3};
use robot_compiler::{Robot, with_dof};
use serde::Serialize;

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// Joint position, rad or m; `None` with [`Question::minimise`]: the middle of the limits.
    pub q: Option<Vec<f64>>,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Vec<f64>,
    /// Mass of a point held by the tip (kg) and, if given, its place in the tip frame (m).
    pub load: Option<Vec<f64>>,
    /// Force (N) and moment (N m) of the environment on the arm at the tip's origin, in tip axes.
    pub tip_wrench: Option<Vec<f64>>,
    /// Search for the least of this: a joint's name or number, `total` or `potential`.
    pub minimise: Option<String>,
    /// Joints that do not move in the search.
    pub hold: Vec<String>,
    /// Axes of the wrenches.
    pub axes: AxesName,
}

/// An arm at rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// The robot's name.
    pub robot: String,
    /// Joint position, rad or m.
    pub q: Vec<f64>,
    /// Torques and forces that hold it, `G(q) - J^T w`, N m or N.
    pub tau: Vec<f64>,
    /// `-sum m g . r` of arm and load, J.
    pub potential: f64,
    /// `link` or `base`.
    pub axes: &'static str,
    /// Every joint, base first.
    pub joints: Vec<JointAnswer>,
    /// How the posture was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minimised: Option<Minimised>,
}

/// What a joint carries.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointAnswer {
    /// Its name.
    pub name: String,
    /// What the actuator carries, N m or N.
    pub actuator: f64,
    /// The actuator's limit; not there where it has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// Force on the link by the link before, N.
    pub force: [f64; 3],
    /// Moment on it about the joint's origin, N m.
    pub moment: [f64; 3],
    /// Bearing force across the axis, N.
    pub radial: f64,
    /// Bearing force along the axis, N; not there where the actuator carries it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axial: Option<f64>,
    /// Bearing moment across the axis, N m.
    pub tilting: f64,
    /// Bearing moment along the axis, N m; not there where the actuator carries it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twisting: Option<f64>,
    #[serde(skip)]
    label: JointLabel,
}

/// How a posture was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Minimised {
    /// A joint's name, `total` or `potential`.
    pub what: String,
    /// Torque's magnitude (N m or N), sum of squares, or potential energy (J).
    pub value: f64,
    /// Points that the search began from.
    pub starts: usize,
    /// Postures that were looked at.
    pub postures: u64,
}

/// Answer on standard output.
///
/// # Errors
/// [`Failure::Input`] for a robot or an option that is wrong.
pub fn run(args: &StaticsArgs) -> Result<(), Failure> {
    let robot = Robot::load(&args.robot).map_err(Failure::input)?;
    let question = Question {
        q: args.q.clone(),
        gravity: args.gravity.clone(),
        load: args.load.clone(),
        tip_wrench: args.tip_wrench.clone(),
        minimise: args.minimise.clone(),
        hold: args.hold.clone(),
        axes: args.axes,
    };
    let answer = with_dof!(robot.dof(), N => answer::<N>(&robot, &question))?;
    let text = if args.json {
        serde_json::to_string_pretty(&answer).map_err(|error| Failure::Output(error.into()))?
    } else {
        answer.table()
    };
    failure::print(&format!("{text}\n"))
}

/// What holds the arm.
///
/// # Errors
/// [`Failure::Input`]: a list of the wrong length, a posture outside the limits, a joint that there is not, a search without
/// bounds.
pub fn answer<const N: usize>(robot: &Robot, question: &Question) -> Result<Answer, Failure> {
    let model = robot.model::<N>().map_err(Failure::input)?;
    let held = load(question.load.as_deref()).map_err(wrong)?;
    let still = Still {
        chain: Chain::new(&model, &held),
        gravity: finite::<3>("--gravity", &question.gravity, "gx, gy, gz").map_err(wrong)?.into(),
        push: wrench(question.tip_wrench.as_deref()).map_err(wrong)?,
    };
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
            AxesName::Link => "link",
            AxesName::Base => "base",
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

/// An arm, and what it has to be held against.
struct Still<const N: usize> {
    chain: Chain<f64, N>,
    gravity: Vector3<f64>,
    /// In tip axes.
    push: Wrench<f64>,
}

impl<const N: usize> Still<N> {
    fn posture(&self, q: &[f64; N]) -> Posture<f64, N> {
        self.chain.posture(&Libm.sin_cos_all(q), q)
    }

    /// The push in base axes.
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

    fn reactions(&self, q: &[f64; N], axes: AxesName) -> [Reaction<f64>; N] {
        let posture = self.posture(q);
        let joint = backward(&posture, &self.gravity, &[&[]; N], &self.push(&posture));
        core::array::from_fn(|i| {
            let link = &posture.links[i];
            match axes {
                AxesName::Base => Reaction::of(link.kind, &link.axis, &joint[i]),
                AxesName::Link => {
                    let local = joint[i].in_child(&link.rotation, &Vector3::zeros());
                    Reaction::of(link.kind, &Vector3::z(), &local)
                }
            }
        })
    }
}

/// What a search makes least.
enum Target {
    Joint { index: usize, name: String },
    Total,
    Potential,
}

impl Target {
    fn named(what: &str, robot: &Robot) -> Result<Self, String> {
        match what {
            "total" => Ok(Self::Total),
            "potential" => Ok(Self::Potential),
            _ => match joint_index(robot, what) {
                Some(index) => Ok(Self::Joint { index, name: robot.joints[index].name.clone() }),
                None => Err(format!("--minimise {what}: expected total, potential or a joint: {}", joint_names(robot))),
            },
        }
    }

    /// What is compared: smooth, so that steps lead somewhere.
    fn cost<const N: usize>(&self, still: &Still<N>, q: &[f64; N]) -> f64 {
        match self {
            Self::Joint { index, .. } => still.torque(q)[*index].powi(2),
            Self::Total => still.torque(q).iter().map(|tau| tau * tau).sum(),
            Self::Potential => still.potential(q),
        }
    }
}

/// The posture of the least.
fn search<const N: usize>(
    robot: &Robot,
    still: &Still<N>,
    target: &Target,
    given: Option<[f64; N]>,
    hold: &[String],
) -> Result<([f64; N], Minimised), Failure> {
    let mut held = [false; N];
    for name in hold {
        let index = joint_index(robot, name)
            .ok_or_else(|| wrong(format!("--hold {name}: expected a joint: {}", joint_names(robot))))?;
        held[index] = true;
    }
    let mut bounds = [(0.0, 0.0); N];
    for (i, joint) in robot.joints.iter().enumerate() {
        bounds[i] = match given {
            Some(q) if held[i] => (q[i], q[i]),
            _ => range(joint.spec.kind, &joint.spec.limits).ok_or_else(|| {
                let help = "expected position limits in the robot file, or --hold with this joint";
                let problem = format!("joint {}, {}, slides without limits: nowhere to search", i + 1, joint.name);
                Failure::Input(miette::miette!(help = help, "{problem}"))
            })?,
        };
    }
    let middle = bounds.map(|(low, high)| low + (high - low) / 2.0);
    // A joint without limits may stand anywhere; the search covers one turn.
    let start = given.map_or(middle, |q| core::array::from_fn(|i| q[i].clamp(bounds[i].0, bounds[i].1)));
    let least = posture_search::minimise(&bounds, &start, |q| target.cost(still, q));
    let (what, value) = match target {
        Target::Joint { name, .. } => (name.clone(), least.value.sqrt()),
        Target::Total => ("total".to_owned(), least.value),
        Target::Potential => ("potential".to_owned(), least.value),
    };
    Ok((least.q, Minimised { what, value, starts: STARTS, postures: least.evaluations }))
}

/// Where a joint may be looked for: its limits, one turn where it has none.
fn range(kind: JointKind, limits: &Limits<f64>) -> Option<(f64, f64)> {
    let (low, high) = limits.position;
    match (kind, low.is_finite(), high.is_finite()) {
        (_, true, true) => Some((low, high)),
        (JointKind::Prismatic, ..) => None,
        (_, true, false) => Some((low, low + TAU)),
        (_, false, true) => Some((high - TAU, high)),
        (_, false, false) => Some((-PI, PI)),
    }
}

/// A posture inside the limits.
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

/// A point mass in the tip frame.
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

/// `K` finite numbers.
fn finite<const K: usize>(name: &str, values: &[f64], meaning: &str) -> Result<[f64; K], String> {
    finite_entries(name, values)?;
    numbers::<f64, K>(name, values, meaning)
}

fn finite_entries(name: &str, values: &[f64]) -> Result<(), String> {
    match values.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(i) => Err(format!("entry {} of `{name}` is {}; expected a finite number", i + 1, values[i])),
    }
}

fn wrong(problem: String) -> Failure {
    Failure::Input(miette::miette!(help = "see `host-sim statics --help`", "{problem}"))
}

/// By name, or by number counted from 1.
fn joint_index(robot: &Robot, name: &str) -> Option<usize> {
    robot.joints.iter().position(|joint| joint.name == name).or_else(|| {
        let number: usize = name.parse().ok()?;
        (1..=robot.dof()).contains(&number).then(|| number - 1)
    })
}

fn joint_names(robot: &Robot) -> String {
    robot.joints.iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>().join(", ")
}

impl Answer {
    /// The table and the lines around it, as a person reads them.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = Table::new();
        table.load_style(presets::UTF8_FULL_CONDENSED);
        table.set_header([
            "joint".to_owned(),
            "position".to_owned(),
            "actuator".to_owned(),
            "of limit".to_owned(),
            "radial".to_owned(),
            "axial".to_owned(),
            "tilting".to_owned(),
            "twisting".to_owned(),
            format!("force / N ({} axes)", self.axes),
            format!("moment / N m ({} axes)", self.axes),
        ]);
        for column in table.column_iter_mut().skip(1) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        let three = |v: &[f64; 3]| v.map(|x| format!("{:.3}", x + 0.0)).join(" ");
        for (joint, q) in self.joints.iter().zip(&self.q) {
            let optional = |x: Option<f64>, unit| x.map_or("-".to_owned(), |x| engineering(x, unit));
            table.add_row([
                joint.name.clone(),
                format!("{q:.4} {}", joint.label.position_unit()),
                engineering(joint.actuator, joint.label.torque_unit()),
                joint.limit.map_or("-".to_owned(), |limit| format!("{:.0} %", 100.0 * joint.actuator.abs() / limit)),
                engineering(joint.radial, "N"),
                optional(joint.axial, "N"),
                engineering(joint.tilting, "N m"),
                optional(joint.twisting, "N m"),
                three(&joint.force),
                three(&joint.moment),
            ]);
        }
        let mut text =
            format!("{}: at rest\n{table}\n{:<20}{}", self.robot, "potential energy", engineering(self.potential, "J"));
        if let Some(Minimised { what, value, starts, postures }) = &self.minimised {
            text += &format!("\n{:<20}{what}: {value:.6e}, of {postures} postures from {starts} starts", "least");
        }
        text
    }
}
