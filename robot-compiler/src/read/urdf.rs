//! URDF files: the serial chain of a robot, with what is fixed merged into what moves.
//!
//! `urdf-rs` gives the values; the XML tree beside it gives places, and what the values cannot tell, such as whether an
//! `<inertial>` was there at all.

use crate::describe::diagnostics::{FileError, Source};
use crate::describe::robot::{BuildError, DOF, JointFriction, Robot, RobotJoint};
use dynamics_core::model::{Impossible, Place};
use dynamics_core::{Frame, JointKind, JointSpec, Limits, ModelError, Rotor, Tool};
use nalgebra::Vector3;
use std::path::PathBuf;
use urdf_rs::JointType;

mod chain;
mod markup;
mod merge;

use chain::Chain;
use markup::Markup;

/// `tip` names the link that the chain ends at; `None` takes the only chain there is.
pub(super) fn read(source: &Source, tip: Option<&str>) -> Result<Robot, FileError> {
    let document = markup::parse(source)?;
    let markup = Markup::new(source, &document)?;
    markup.check_numbers()?;
    let urdf = urdf_rs::read_from_string(&markup.essentials()).map_err(|error| {
        markup.error(&markup.robot, "robot", format!("not a URDF: {error}"), "a URDF robot description")
    })?;
    if urdf.links.len() != markup.links.len() || urdf.joints.len() != markup.joints.len() {
        return Err(markup.error(
            &markup.robot,
            "robot",
            "links or joints that cannot be read",
            "a URDF robot description",
        ));
    }
    let chain = Chain::new(&markup, &urdf, tip)?;
    if !DOF.contains(&chain.moving.len()) {
        let names: Vec<&str> = chain.moving.iter().map(|&index| urdf.joints[index].name.as_str()).collect();
        let problem = match names.as_slice() {
            [] => "the chain has no moving joint".to_owned(),
            _ => format!("the chain has {} moving joints: {}", names.len(), names.join(", ")),
        };
        return Err(markup.error(
            &markup.robot,
            "robot",
            problem,
            "a chain of one to six moving joints (name its tip link)",
        ));
    }
    let joints = (0..chain.moving.len()).map(|i| joint(&markup, &urdf, &chain, i)).collect::<Result<Vec<_>, _>>()?;
    let tip = merge::tip_placement(&urdf, &chain);
    let robot = Robot {
        name: if urdf.name.is_empty() { "robot".to_owned() } else { urdf.name.clone() },
        source: describe(&source.file, &urdf, &chain),
        allow_unphysical: None,
        joints,
        tool: Tool { rotation: tip.rotation, translation: tip.translation, ..Tool::default() },
        path: PathBuf::from(&source.file),
    };
    robot.check().map_err(|error| placed(&error, &robot, &markup, &chain))?;
    Ok(robot)
}

/// Which file and chain, and what was held still on the way.
fn describe(file: &str, urdf: &urdf_rs::Robot, chain: &Chain) -> String {
    let mut text = format!("{file}, chain to {}", urdf.links[chain.tip].name);
    if !chain.held.is_empty() {
        let names: Vec<&str> = chain.held.iter().map(|&index| urdf.joints[index].name.as_str()).collect();
        text += &format!("; held at zero: {}", names.join(", "));
    }
    text
}

/// The `i`-th moving joint of the chain, and the link that moves with it.
fn joint(markup: &Markup<'_>, urdf: &urdf_rs::Robot, chain: &Chain, i: usize) -> Result<RobotJoint, FileError> {
    let index = chain.moving[i];
    let joint = &urdf.joints[index];
    let label = Robot::joint_label(i, &joint.name);
    let child = chain.child[index];
    if !markup.has(child, "inertial") {
        let field = format!("link {}.inertial", urdf.links[child].name);
        let problem = format!("missing, but the link moves with {label}");
        return Err(markup.error(&markup.links[child], field, problem, "an <inertial> with mass and inertia"));
    }
    let place = merge::joint_placement(urdf, chain, i);
    let axis = Vector3::from(joint.axis.xyz.0);
    let largest = axis.amax();
    if largest == 0.0 {
        let field = format!("{label}.axis");
        return Err(markup.error_in(
            &markup.joints[index],
            "axis",
            field,
            "the axis has no direction",
            "a vector that is not zero",
        ));
    }
    // Scaled first, so that the square of a tiny or huge axis neither vanishes nor overflows.
    let axis = (axis / largest).normalize();
    Ok(RobotJoint {
        name: joint.name.clone(),
        spec: JointSpec {
            kind: if joint.joint_type == JointType::Prismatic { JointKind::Prismatic } else { JointKind::Revolute },
            frame: Frame::Placement { rotation: place.rotation, translation: place.translation, axis },
            body: merge::body(urdf, chain, i),
            rotor: Rotor::default(),
            limits: limits(markup, joint, index, &label)?,
        },
        friction: friction(markup, joint, index, &label)?,
        encoder: None,
        drive: None,
    })
}

fn limits(markup: &Markup<'_>, joint: &urdf_rs::Joint, index: usize, label: &str) -> Result<Limits<f64>, FileError> {
    let node = &markup.joints[index];
    let continuous = joint.joint_type == JointType::Continuous;
    let Some(limit) = markup::child(node, "limit") else {
        if continuous {
            return Ok(Limits::none());
        }
        let problem = "missing on a joint with limited travel";
        return Err(markup.error(
            node,
            format!("{label}.limit"),
            problem,
            "a <limit> with lower, upper, effort, velocity",
        ));
    };
    // Version 1.2 made every limit optional; before, urdf-rs reads what is missing as zero.
    for key in ["effort", "velocity"] {
        if limit.attribute(key).is_none() && joint_limit(&joint.limit, key) == 0.0 {
            return Err(markup.error(&limit, format!("{label}.limit.{key}"), "missing", "a limit above zero"));
        }
    }
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    Ok(Limits {
        position: if continuous { free } else { (joint.limit.lower, joint.limit.upper) },
        velocity: joint.limit.velocity,
        torque: joint.limit.effort,
        torque_rate: f64::INFINITY,
    })
}

fn joint_limit(limit: &urdf_rs::JointLimit, key: &str) -> f64 {
    if key == "effort" { limit.effort } else { limit.velocity }
}

fn friction(
    markup: &Markup<'_>,
    joint: &urdf_rs::Joint,
    index: usize,
    label: &str,
) -> Result<Option<JointFriction>, FileError> {
    let Some(dynamics) = &joint.dynamics else {
        return Ok(None);
    };
    for (key, value) in [("damping", dynamics.damping), ("friction", dynamics.friction)] {
        if value < 0.0 {
            let field = format!("{label}.dynamics.{key}");
            let problem = format!("found {value}");
            return Err(markup.error_in(&markup.joints[index], "dynamics", field, problem, "zero or more"));
        }
    }
    let given = dynamics.damping > 0.0 || dynamics.friction > 0.0;
    Ok(given.then_some(JointFriction { viscous: dynamics.damping, coulomb: dynamics.friction }))
}

/// The core's refusal, moved to the element that caused it.
fn placed(error: &BuildError, robot: &Robot, markup: &Markup<'_>, chain: &Chain) -> FileError {
    let (label, problem, expected) = error.describe(robot);
    let (index, what) = match error {
        BuildError::Impossible(ModelError { place: Place::Joint(index), what }) => (*index, Some(what)),
        BuildError::Impossible(ModelError { place: Place::Tool, what }) => (robot.dof() - 1, Some(what)),
        BuildError::TooLarge(index) => (*index, None),
    };
    let joint = chain.moving[index];
    let element = match what {
        Some(Impossible::PositionLimitsReversed(..) | Impossible::LimitNotPositive(..)) => "limit",
        Some(Impossible::NonUnitAxis(_)) => "axis",
        Some(Impossible::NotARotation(_)) => "origin",
        _ => return placed_in_inertial(&label, what, problem, expected, markup, &markup.links[chain.child[joint]]),
    };
    markup.error_in(&markup.joints[joint], element, format!("{label}.{element}"), problem, expected)
}

fn placed_in_inertial(
    label: &str,
    what: Option<&Impossible>,
    problem: String,
    expected: &str,
    markup: &Markup<'_>,
    link: &roxmltree::Node<'_, '_>,
) -> FileError {
    let part = match what {
        Some(Impossible::NegativeMass(_) | Impossible::InertiaWithoutMass(_)) => "mass",
        _ => "inertia",
    };
    let inertial = markup::child(link, "inertial").unwrap_or(*link);
    markup.error_in(&inertial, part, format!("{label}.inertial.{part}"), problem, expected)
}
