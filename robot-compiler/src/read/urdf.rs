//! URDF files: the serial chain of a robot, with fixed parts merged into moving ones.
//!
//! The XML is parsed once. Each value read from it keeps its element, and so its place, until the robot is checked.

use crate::describe::cut::{Ends, NAMESPACE, UrdfArm};
use crate::describe::diagnostics::{FileError, Source};
use crate::describe::draft::{Draft, FileKind, readable};
use crate::describe::link_shape::LinkShape;
use crate::describe::robot::{BuildError, DOF, JointFriction, JointHeat, Robot, RobotJoint};
use dynamics_core::model::{Impossible, Place};
use dynamics_core::{Body, Frame, JointKind, JointSpec, Limits, ModelError, Tool};
use std::path::PathBuf;

mod chain;
mod description;
mod markup;
mod merge;
mod places;
mod pose;
mod rotor;
mod shapes;

use chain::Chain;
use description::{Description, Joint, Kind};
pub(super) use markup::EXPAND;
use markup::{Markup, child};

/// Reads the arm between two links.
pub(super) fn read(source: &Source, ends: Ends<'_>) -> Result<UrdfArm, FileError> {
    let document = markup::parse(source)?;
    let markup = Markup::new(source, &document)?;
    let (urdf, chain) = cut(&markup, ends)?;
    (0..chain.moving.len()).try_for_each(|i| has_mass(&markup, &urdf, &chain, i))?;
    let robot = stated(source, &markup, &urdf, &chain, ends)?;
    robot.check().map_err(|error| placed(&error, &robot, &markup, &urdf, &chain))?;
    let link = |&index: &usize| urdf.links[index].name.to_owned();
    Ok(UrdfArm {
        robot,
        base: link(&chain.base),
        tip: link(&chain.tip),
        links: (0..chain.moving.len()).map(|i| merge::parts(&chain, i).iter().map(link).collect()).collect(),
        held: chain.held.iter().map(|&index| urdf.joints[index].name.to_owned()).collect(),
    })
}

/// Reads the collision shapes of the arm between two links.
pub(super) fn shapes(source: &Source, ends: Ends<'_>) -> Result<Vec<LinkShape>, FileError> {
    let document = markup::parse(source)?;
    let markup = Markup::new(source, &document)?;
    let (urdf, chain) = cut(&markup, ends)?;
    let robot = stated(source, &markup, &urdf, &chain, ends)?;
    shapes::shapes(&markup, &urdf, &chain, &robot)
}

/// Reads the arm between two links as its file states it.
pub(super) fn draft(source: &Source, ends: Ends<'_>) -> Result<Draft, FileError> {
    let document = markup::parse(source)?;
    let markup = Markup::new(source, &document)?;
    let (urdf, chain) = cut(&markup, ends)?;
    let robot = stated(source, &markup, &urdf, &chain, ends)?;
    readable(&robot).map_err(|error| placed(&error, &robot, &markup, &urdf, &chain))?;
    let all = 0..chain.moving.len();
    Ok(Draft {
        source: source.clone(),
        kind: FileKind::Urdf,
        bodies: all.clone().flat_map(|i| places::bodies(&markup, &urdf, &chain, &robot, i)).collect(),
        places: all.map(|i| places::joint(&markup, &urdf, &chain, i)).collect(),
        robot,
    })
}

/// The tree of links, and the chain between two of them.
fn cut<'a>(markup: &Markup<'a>, ends: Ends<'_>) -> Result<(Description<'a>, Chain), FileError> {
    let urdf = Description::read(markup)?;
    let chain = Chain::new(markup, &urdf, ends)?;
    if DOF.contains(&chain.moving.len()) {
        return Ok((urdf, chain));
    }
    let names: Vec<&str> = chain.moving.iter().map(|&index| urdf.joints[index].name).collect();
    let problem = match names.as_slice() {
        [] => "the chain has no moving joint".to_owned(),
        _ => format!("the chain has {} moving joints: {}", names.len(), names.join(", ")),
    };
    Err(markup.error(&markup.robot, "robot", problem, chain.shorter(&urdf)))
}

/// The arm, unchecked.
fn stated(
    source: &Source,
    markup: &Markup<'_>,
    urdf: &Description<'_>,
    chain: &Chain,
    ends: Ends<'_>,
) -> Result<Robot, FileError> {
    let joints = (0..chain.moving.len()).map(|i| joint(markup, urdf, chain, i)).collect::<Result<Vec<_>, _>>()?;
    let tip = merge::tip_placement(urdf, chain);
    Ok(Robot {
        rest: None,
        name: if urdf.name.is_empty() { "robot".to_owned() } else { urdf.name.to_owned() },
        source: describe(&source.file, urdf, chain, ends.base),
        allow_unphysical: unphysical(markup),
        joints,
        tool: Tool { rotation: tip.rotation, translation: tip.translation, ..Tool::default() },
        path: PathBuf::from(&source.file),
    })
}

/// The reason why bodies that nothing could have are accepted: an attribute of ours, which an export of such a robot file writes.
fn unphysical(markup: &Markup<'_>) -> Option<String> {
    markup.robot.attribute((NAMESPACE, "allow_unphysical")).map(str::to_owned)
}

/// File and chain, and the joints held still.
fn describe(file: &str, urdf: &Description<'_>, chain: &Chain, base: Option<&str>) -> String {
    let from = base.map_or(String::new(), |base| format!(" from {base}"));
    let mut text = format!("{file}, chain{from} to {}", urdf.links[chain.tip].name);
    if !chain.held.is_empty() {
        let names: Vec<&str> = chain.held.iter().map(|&index| urdf.joints[index].name).collect();
        text += &format!("; held at zero: {}", names.join(", "));
    }
    text
}

/// Refuses a moving link without `<inertial>`; it may leave its mass to what is fixed to it.
fn has_mass(markup: &Markup<'_>, urdf: &Description<'_>, chain: &Chain, i: usize) -> Result<(), FileError> {
    let index = chain.moving[i];
    let link = &urdf.links[chain.child[index]];
    if child(&link.node, "inertial").is_some() || merge::body(urdf, chain, i) != Body::massless() {
        return Ok(());
    }
    let label = Robot::joint_label(i, urdf.joints[index].name);
    let field = format!("link {}.inertial", link.name);
    let problem = format!("missing, but the link moves with {label}, and nothing fixed to it has a mass");
    Err(markup.error(&link.node, field, problem, "an <inertial> with mass and inertia"))
}

/// The `i`-th moving joint of the chain, and the link that moves with it.
fn joint(markup: &Markup<'_>, urdf: &Description<'_>, chain: &Chain, i: usize) -> Result<RobotJoint, FileError> {
    let index = chain.moving[i];
    let joint = &urdf.joints[index];
    let label = Robot::joint_label(i, joint.name);
    let body = merge::body(urdf, chain, i);
    let place = merge::joint_placement(urdf, chain, i);
    let largest = joint.axis.amax();
    if largest == 0.0 {
        let (field, problem) = (format!("{label}.axis"), "the axis has no direction");
        return Err(markup.error_in(&joint.node, "axis", field, problem, "a vector that is not zero"));
    }
    // Scaled first, so that the square of a tiny or huge axis neither vanishes nor overflows.
    let axis = (joint.axis / largest).normalize();
    Ok(RobotJoint {
        heat: JointHeat::default(),
        name: joint.name.to_owned(),
        spec: JointSpec {
            kind: if joint.kind == Kind::Prismatic { JointKind::Prismatic } else { JointKind::Revolute },
            frame: Frame::Placement { rotation: place.rotation, translation: place.translation, axis },
            body,
            rotor: rotor::rotor(markup, joint.name, &label)?,
            limits: limits(markup, joint, &label)?,
        },
        friction: friction(markup, joint, &label)?,
        encoder: None,
        drive: None,
    })
}

/// Version 1.2 made every limit optional. Before, a missing travel limit is zero, and the other limits are required.
fn limits(markup: &Markup<'_>, joint: &Joint<'_>, label: &str) -> Result<Limits<f64>, FileError> {
    let optional = markup.version >= (1, 2);
    let continuous = joint.kind == Kind::Continuous;
    let Some(limit) = &joint.limit else {
        if continuous {
            return Ok(Limits::none());
        }
        let (field, problem) = (format!("{label}.limit"), "missing on a joint with limited travel");
        return Err(markup.error(&joint.node, field, problem, "a <limit> with lower, upper, effort, velocity"));
    };
    let must_be = |key: &str, value: Option<f64>| match value {
        Some(value) => Ok(value),
        None if optional => Ok(f64::INFINITY),
        None => {
            Err(markup.error_in(&joint.node, "limit", format!("{label}.limit.{key}"), "missing", "a limit above zero"))
        }
    };
    let (torque, velocity) = (must_be("effort", limit.effort)?, must_be("velocity", limit.velocity)?);
    let end = |value: Option<f64>, free: f64| value.unwrap_or(if optional { free } else { 0.0 });
    let (lowest, highest) = (f64::NEG_INFINITY, f64::INFINITY);
    Ok(Limits {
        position: if continuous { (lowest, highest) } else { (end(limit.lower, lowest), end(limit.upper, highest)) },
        velocity,
        torque,
        torque_rate: f64::INFINITY,
    })
}

fn friction(markup: &Markup<'_>, joint: &Joint<'_>, label: &str) -> Result<Option<JointFriction>, FileError> {
    for (key, value) in [("damping", joint.damping), ("friction", joint.friction)] {
        if value < 0.0 {
            let (field, problem) = (format!("{label}.dynamics.{key}"), format!("found {value}"));
            return Err(markup.error_in(&joint.node, "dynamics", field, problem, "zero or more"));
        }
    }
    let given = joint.damping > 0.0 || joint.friction > 0.0;
    Ok(given.then_some(JointFriction { viscous: joint.damping, coulomb: joint.friction }))
}

/// The core's refusal, reported at the element that caused it.
fn placed(error: &BuildError, robot: &Robot, markup: &Markup<'_>, urdf: &Description<'_>, chain: &Chain) -> FileError {
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
        _ => return placed_in_inertial(&label, what, problem, expected, markup, &urdf.links[chain.child[joint]].node),
    };
    markup.error_in(&urdf.joints[joint].node, element, format!("{label}.{element}"), problem, expected)
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
    let inertial = child(link, "inertial").unwrap_or(*link);
    markup.error_in(&inertial, part, format!("{label}.inertial.{part}"), problem, expected)
}
