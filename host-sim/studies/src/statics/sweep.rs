//! Holding torques and potential energy over the range of one joint, while the others stay fixed.

use super::still::{Still, wrong};
use super::{StaticsRequest, posture, search};
use crate::posture_search;
use report::{Block, Figure, Page, Series};
use robot_compiler::{Robot, with_dof};
use serde::Serialize;
use sim::failure::Failure;
use sim::run::joint_label::JointLabel;
use sim::run::numbers::engineering;
use sim::table::table;

/// Number of positions of the swept joint: every half degree over one turn.
const POSITIONS: usize = 721;

/// Torques and energy over the range of a joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sweep {
    /// Name of the robot.
    pub robot: String,
    /// Name of the swept joint.
    pub joint: String,
    /// Its positions, rad or m.
    pub positions: Vec<f64>,
    /// Holding torque of every joint at each position, N m or N.
    pub tau: Vec<Vec<f64>>,
    /// Potential energy at each position, J.
    pub potential: Vec<f64>,
    /// Smallest signed value of every curve: each joint's torque, their sum, the potential energy.
    pub least: Vec<LowestValue>,
    #[serde(skip)]
    labels: Vec<JointLabel>,
    #[serde(skip)]
    swept: usize,
}

/// The smallest value of a curve at the evaluated positions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LowestValue {
    /// The joint, `sum` or `potential`.
    pub what: String,
    /// Position of the swept joint, rad or m.
    pub at: f64,
    /// The value, N m, N or J.
    pub value: f64,
}

/// Sweeps one joint (its name or number) from limit to limit, or over one turn if a revolute joint has a longer range.
///
/// # Errors
/// [`Failure::Input`]: those of [`super::answer`], an unknown joint, or a prismatic joint without limits.
pub fn sweep(robot: &Robot, question: &StaticsRequest, joint: &str) -> Result<Sweep, Failure> {
    with_dof!(robot.dof(), N => sweep_for::<N>(robot, question, joint))
}

fn sweep_for<const N: usize>(robot: &Robot, question: &StaticsRequest, joint: &str) -> Result<Sweep, Failure> {
    let still = Still::<N>::new(robot, question)?;
    let limits = robot.model::<N>().map_err(Failure::input)?.links().map(|link| link.limits);
    let q = question.q.as_deref().ok_or_else(|| wrong(format!("--sweep: expected --q with {N} numbers")))?;
    let q = posture::<N>(robot, &limits, q)?;
    let swept = search::joint(robot, "--sweep", joint)?;
    let spec = robot.joints[swept].spec;
    let (low, high) = posture_search::positions(spec.kind, spec.limits.position).ok_or_else(|| {
        wrong(format!("--sweep {joint}: expected position limits in the robot file: it slides without"))
    })?;
    let high =
        if spec.kind == dynamics_core::JointKind::Revolute { high.min(low + std::f64::consts::TAU) } else { high };
    let positions: Vec<f64> = (0..POSITIONS).map(|n| low + (high - low) * n as f64 / (POSITIONS - 1) as f64).collect();
    let at = |position: f64| {
        let mut q = q;
        q[swept] = position;
        q
    };
    let tau: Vec<Vec<f64>> = positions.iter().map(|x| still.torque(&at(*x)).to_vec()).collect();
    let potential: Vec<f64> = positions.iter().map(|x| still.potential(&at(*x))).collect();
    let least = |what: &str, values: Vec<f64>| {
        let all = positions.iter().zip(values).min_by(|a, b| a.1.total_cmp(&b.1));
        all.map(|(at, value)| LowestValue { what: what.to_owned(), at: *at, value })
    };
    let joints = robot.joints.iter().enumerate();
    let each = joints.map(|(i, joint)| least(&joint.name, tau.iter().map(|tau| tau[i]).collect()));
    let sum = least("sum", tau.iter().map(|tau| tau.iter().sum()).collect());
    let least = each.chain([sum, least("potential", potential.clone())]).flatten().collect();
    Ok(Sweep {
        robot: robot.name.clone(),
        joint: robot.joints[swept].name.clone(),
        positions,
        tau,
        potential,
        least,
        labels: robot.joints.iter().map(JointLabel::from).collect(),
        swept,
    })
}

impl Sweep {
    /// The table of the least values for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = table(["least", "value", "at"], 1);
        let unit = self.labels[self.swept].position_unit();
        for (i, LowestValue { what, at, value }) in self.least.iter().enumerate() {
            let of = self.labels.get(i).map_or(if what == "sum" { "N m" } else { "J" }, JointLabel::torque_unit);
            table.add_row([what.clone(), engineering(*value, of), format!("{at:.4} {unit}")]);
        }
        format!("{}: at rest, over {}, {POSITIONS} positions\n{table}\n", self.robot, self.joint)
    }

    /// A figure for every joint, and one for the potential energy.
    #[must_use]
    pub fn page(&self) -> Page {
        let abscissa = format!("position of {} / {}", self.joint, self.labels[self.swept].position_unit());
        let figure = |caption: &str, ordinate: String, values: Vec<f64>| {
            let line = Series::line("at rest", self.positions.iter().copied().zip(values));
            Block::Figure(Figure::new(caption, abscissa.clone(), ordinate).with(line))
        };
        let joints = self.labels.iter().enumerate().map(|(i, label)| {
            let ordinate = format!("{} / ({})", label.effort(), label.torque_unit());
            figure(&label.name, ordinate, self.tau.iter().map(|tau| tau[i]).collect())
        });
        let potential = figure("potential energy", "energy / J".to_owned(), self.potential.clone());
        Page {
            title: format!("{}: held at rest over {}", self.robot, self.joint),
            lead: Vec::new(),
            blocks: joints.chain([potential]).collect(),
        }
    }
}
