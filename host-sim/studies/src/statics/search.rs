//! Search for the posture with the least torque or energy.

use super::still::{Still, wrong};
use crate::posture_search::{self, STARTS};
use robot_compiler::Robot;
use serde::Serialize;
use sim::failure::Failure;

/// Result of a search for a posture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Minimised {
    /// The minimised quantity: a joint's name, `total` or `potential`.
    pub what: String,
    /// Its smallest value: torque magnitude (N m or N), sum of squared torques, or potential energy (J).
    pub value: f64,
    /// Number of starting points.
    pub starts: usize,
    /// Number of evaluated postures.
    pub postures: u64,
}

/// Quantity to minimise.
pub(super) enum Target {
    Joint { index: usize, name: String },
    Total,
    Potential,
}

impl Target {
    pub(super) fn named(what: &str, robot: &Robot) -> Result<Self, String> {
        match what {
            "total" => Ok(Self::Total),
            "potential" => Ok(Self::Potential),
            _ => match joint_index(robot, what) {
                Some(index) => Ok(Self::Joint { index, name: robot.joints[index].name.clone() }),
                None => Err(format!("--minimise {what}: expected total, potential or a joint: {}", joint_names(robot))),
            },
        }
    }

    /// Cost function of the search, smooth for the descent.
    fn cost<const N: usize>(&self, still: &Still<N>, q: &[f64; N]) -> f64 {
        match self {
            Self::Joint { index, .. } => still.torque(q)[*index].powi(2),
            Self::Total => still.torque(q).iter().map(|tau| tau * tau).sum(),
            Self::Potential => still.potential(q),
        }
    }
}

/// Finds the posture with the smallest cost.
pub(super) fn search<const N: usize>(
    robot: &Robot,
    still: &Still<N>,
    target: &Target,
    given: Option<[f64; N]>,
    hold: &[String],
) -> Result<([f64; N], Minimised), Failure> {
    let mut held = [false; N];
    for name in hold {
        held[joint(robot, "--hold", name)?] = true;
    }
    let mut bounds = [(0.0, 0.0); N];
    for (i, joint) in robot.joints.iter().enumerate() {
        bounds[i] = match given {
            Some(q) if held[i] => (q[i], q[i]),
            _ => posture_search::positions(joint.spec.kind, joint.spec.limits.position).ok_or_else(|| {
                let help = "expected position limits in the robot file, or --hold with this joint";
                let problem = format!("joint {}, {}, slides without limits: nowhere to search", i + 1, joint.name);
                Failure::Input(miette::miette!(help = help, "{problem}"))
            })?,
        };
    }
    let middle = bounds.map(|(low, high)| low + (high - low) / 2.0);
    // A joint without limits may have any position; the search covers one turn.
    let start = given.map_or(middle, |q| core::array::from_fn(|i| q[i].clamp(bounds[i].0, bounds[i].1)));
    let least = posture_search::minimise(&bounds, &start, |q| target.cost(still, q));
    let (what, value) = match target {
        Target::Joint { name, .. } => (name.clone(), least.value.sqrt()),
        Target::Total => ("total".to_owned(), least.value),
        Target::Potential => ("potential".to_owned(), least.value),
    };
    Ok((least.q, Minimised { what, value, starts: STARTS, postures: least.evaluations }))
}

/// Index of the joint that an option names, by name or by number counted from 1.
pub(super) fn joint(robot: &Robot, option: &str, name: &str) -> Result<usize, Failure> {
    let problem = || wrong(format!("{option} {name}: expected a joint: {}", joint_names(robot)));
    joint_index(robot, name).ok_or_else(problem)
}

fn joint_index(robot: &Robot, name: &str) -> Option<usize> {
    robot.joints.iter().position(|joint| joint.name == name).or_else(|| {
        let number: usize = name.parse().ok()?;
        (1..=robot.dof()).contains(&number).then(|| number - 1)
    })
}

fn joint_names(robot: &Robot) -> String {
    robot.joints.iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>().join(", ")
}
