//! Torques that hold an arm at rest, and the posture that needs the smallest ones.

mod report;
mod search;
mod still;
mod sweep;

use super::numbers::finite;
use dynamics_core::{JointKind, Limits};
use robot_compiler::{Robot, with_dof};
pub use search::Minimised;
use search::{Target, search};
use serde::Serialize;
use sim::failure::Failure;
use sim::run::joint_label::JointLabel;
pub use still::{StaticsRequest, WrenchFrame};
use still::{Still, wrong};
pub use sweep::{LowestValue, Sweep, sweep};

/// An arm at rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StaticLoads {
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
    pub joints: Vec<JointLoad>,
    /// Result of the search for the posture, if one was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minimised: Option<Minimised>,
}

/// Load on a joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointLoad {
    /// Name of the joint.
    pub name: String,
    /// Torque or force of the actuator, N m or N.
    pub actuator: f64,
    /// Limit of the actuator, N m or N; `None` without a limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// Force on the link from the previous link, N.
    pub force: [f64; 3],
    /// Moment on the link about the joint's origin, N m.
    pub moment: [f64; 3],
    /// Bearing force across the axis, N.
    pub radial: f64,
    /// Bearing force along the axis, N; `None` if the actuator carries it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axial: Option<f64>,
    /// Bearing moment across the axis, N m.
    pub tilting: f64,
    /// Bearing moment along the axis, N m; `None` if the actuator carries it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twisting: Option<f64>,
    #[serde(skip)]
    label: JointLabel,
}

/// Computes the torques that hold the arm, after a search for the posture if requested. Wrenches are in these axes.
///
/// # Errors
/// [`Failure::Input`]: a list of the wrong length, a posture outside the limits, an unknown joint, a search without
/// bounds.
pub fn answer(robot: &Robot, question: &StaticsRequest, axes: WrenchFrame) -> Result<StaticLoads, Failure> {
    with_dof!(robot.dof(), N => answer_for::<N>(robot, question, axes))
}

fn answer_for<const N: usize>(
    robot: &Robot,
    question: &StaticsRequest,
    axes: WrenchFrame,
) -> Result<StaticLoads, Failure> {
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
    let (potential, reactions) = (still.potential(&q), still.reactions(&q, axes));
    let joints = robot.joints.iter().zip(&reactions).map(|(joint, reaction)| {
        let load = reaction.bearing_load();
        let turns = joint.spec.kind == JointKind::Revolute;
        JointLoad {
            name: joint.name.clone(),
            actuator: reaction.actuator,
            limit: Some(joint.spec.limits.torque).filter(|limit| limit.is_finite()),
            force: reaction.wrench.force.into(),
            moment: reaction.wrench.moment.into(),
            radial: load.radial,
            axial: turns.then_some(load.axial),
            tilting: load.tilting,
            twisting: (!turns).then_some(load.twisting),
            label: JointLabel::from(joint),
        }
    });
    let answer = StaticLoads {
        robot: robot.name.clone(),
        q: q.to_vec(),
        tau: reactions.iter().map(|reaction| reaction.actuator).collect(),
        potential,
        axes: match axes {
            WrenchFrame::Link => "link",
            WrenchFrame::Base => "base",
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

/// Checks that a posture is within the limits.
fn posture<const N: usize>(robot: &Robot, limits: &[Limits<f64>; N], q: &[f64]) -> Result<[f64; N], Failure> {
    let q = finite::<N>("--q", q, "one for each joint").map_err(wrong)?;
    for (i, joint) in robot.joints.iter().enumerate() {
        let (low, high) = limits[i].position;
        if !(low..=high).contains(&q[i]) {
            let unit = JointLabel::from(joint).position_unit();
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
