//! URDF files: the serial chain of a robot, with fixed parts merged into moving ones.
//!
//! The XML is parsed once. Each value read from it keeps its element, and so its location, until the robot is checked.

use crate::describe::cut::{Ends, JointGaps, NAMESPACE, UrdfArm};
use crate::describe::diagnostics::{FileError, Source};
use crate::describe::draft::{Draft, FileKind, Remark, RemarkKind, readable};
use crate::describe::link_shape::LinkShape;
use crate::describe::robot::{BuildError, DOF, Robot};
use crate::read::shown::short;
use dynamics_core::model::{Impossible, Place};
use dynamics_core::{Body, ModelError, Tool};
use nalgebra::Vector3;
use std::path::PathBuf;

mod chain;
mod description;
mod joint;
mod markup;
mod merge;
mod moving;
mod names;
mod places;
mod pose;
mod remarks;
mod rotor;
mod shapes;

use chain::Chain;
use description::Description;
use joint::{joint, travel};
pub(super) use markup::EXPAND;
use markup::{Markup, child};

/// Reads the arm between two links, and rejects one with missing masses or misspelt names.
pub(super) fn read(source: &Source, ends: Ends<'_>) -> Result<Robot, FileError> {
    let document = markup::parse(source)?;
    let markup = Markup::new(source, &document)?;
    let (mut urdf, chain) = cut(&markup, ends)?;
    (0..chain.moving.len()).try_for_each(|i| has_mass(&markup, &urdf, &chain, i))?;
    for link in (0..chain.moving.len()).flat_map(|i| merge::parts(&chain, i)) {
        if let Some(gap) = urdf.links[link].gap.take() {
            return Err(gap.error);
        }
    }
    let misspelt = |remark: &Remark| remark.kind == RemarkKind::Unknown { misspelt: true };
    if let Some(remark) = remarks::all(&markup, &urdf, &chain).into_iter().find(misspelt) {
        let Remark { place, problem, advice, .. } = remark;
        return Err(source.error(place.span, place.field, problem, advice));
    }
    let robot = stated(source, &markup, &urdf, &chain, ends)?;
    robot.check().map_err(|error| placed(&error, &robot, &markup, &urdf, &chain))?;
    Ok(robot)
}

/// Reads the arm between two links with its gaps.
pub(super) fn arm(source: &Source, ends: Ends<'_>) -> Result<UrdfArm, FileError> {
    let document = markup::parse(source)?;
    let markup = Markup::new(source, &document)?;
    let (urdf, chain) = cut(&markup, ends)?;
    let robot = stated(source, &markup, &urdf, &chain, ends)?;
    readable(&robot).map_err(|error| placed(&error, &robot, &markup, &urdf, &chain))?;
    let link = |&index: &usize| urdf.links[index].name.to_owned();
    let all = 0..chain.moving.len();
    // A gap of a body is listed with its joint.
    let remark =
        |it: Remark| (it.kind != RemarkKind::Gap).then(|| format!("{}: {}; {}", it.place.field, it.problem, it.advice));
    Ok(UrdfArm {
        base: link(&chain.base),
        tip: link(&chain.tip),
        links: all.clone().map(|i| merge::parts(&chain, i).iter().map(link).collect()).collect(),
        held: chain.held.iter().map(|&index| urdf.joints[index].name.to_owned()).collect(),
        gaps: all.map(|i| gaps(&markup, &urdf, &chain, i)).collect(),
        remarks: remarks::all(&markup, &urdf, &chain).into_iter().filter_map(remark).collect(),
        robot,
    })
}

/// Gaps of the file for the `i`-th moving joint and its link.
fn gaps(markup: &Markup<'_>, urdf: &Description<'_>, chain: &Chain, i: usize) -> JointGaps {
    let joint = &urdf.joints[chain.moving[i]];
    let own = chain.child[chain.moving[i]];
    let mut body: Vec<String> = merge::parts(chain, i)
        .into_iter()
        .filter_map(|link| Some(urdf.links[link].gap.as_ref()?.reason.clone()))
        .collect();
    if child(&urdf.links[own].node, "inertial").is_none() && merge::body(urdf, chain, i) == Body::massless() {
        body.push(format!("the link {} has no <inertial>", urdf.links[own].name));
    }
    let bound = |get: fn(&description::Limit) -> Option<f64>, key: &str| match joint.limit.as_ref().map(get) {
        None => Some("no <limit>".to_owned()),
        Some(None) => Some(format!("no {key}")),
        Some(Some(0.0)) => Some(format!("{key} is 0, a placeholder")),
        Some(Some(_)) => None,
    };
    JointGaps {
        body: (!body.is_empty()).then(|| body.join("; ")),
        position: travel(markup, joint).1,
        velocity: bound(|limit| limit.velocity, "velocity"),
        torque: bound(|limit| limit.effort, "effort"),
        gear: rotor::reduction(markup, joint.name),
    }
}

/// Reads the collision shapes of the arm between two links.
pub(super) fn shapes(source: &Source, ends: Ends<'_>) -> Result<Vec<LinkShape>, FileError> {
    let document = markup::parse(source)?;
    let markup = Markup::new(source, &document)?;
    let (urdf, chain) = cut(&markup, ends)?;
    let robot = stated(source, &markup, &urdf, &chain, ends)?;
    shapes::shapes(&markup, &urdf, &chain, &robot)
}

/// Reads the arm between two links as stated in its file.
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
        angles: places::angles(&urdf, &chain),
        remarks: remarks::all(&markup, &urdf, &chain),
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
    let tip = merge::tip_placement(chain);
    let mounting = merge::mounting(chain);
    // A turn about the vertical keeps it upright.
    let upright = (mounting.row(2) - Vector3::z().transpose()).amax() < 1e-9;
    Ok(Robot {
        rest: None,
        mounting: (!upright).then_some(mounting),
        name: if urdf.name.is_empty() { "robot".to_owned() } else { urdf.name.to_owned() },
        source: describe(&source.file, urdf, chain, ends.base),
        allow_unphysical: unphysical(markup),
        ideal: None,
        joints,
        tool: Tool { rotation: tip.rotation, translation: tip.translation, ..Tool::default() },
        path: PathBuf::from(&source.file),
    })
}

/// The reason why impossible bodies are accepted: an attribute in our namespace, which the export of such a robot file writes.
fn unphysical(markup: &Markup<'_>) -> Option<String> {
    markup.robot.attribute((NAMESPACE, "allow_unphysical")).map(str::to_owned)
}

/// Describes file and chain, and the held joints.
fn describe(file: &str, urdf: &Description<'_>, chain: &Chain, base: Option<&str>) -> String {
    let from = base.map_or(String::new(), |base| format!(" from {base}"));
    let mut text = format!("{file}, chain{from} to {}", urdf.links[chain.tip].name);
    if !chain.held.is_empty() {
        let name = |index: &usize| urdf.joints[*index].name.to_owned();
        let (zero, moved): (Vec<&usize>, Vec<&usize>) =
            chain.held.iter().partition(|&&index| chain.position[index] == 0.0);
        if !zero.is_empty() {
            text += &format!("; held at zero: {}", zero.into_iter().map(name).collect::<Vec<_>>().join(", "));
        }
        let at = |index: &usize| format!("{} at {}", name(index), short(chain.position[*index]));
        if !moved.is_empty() {
            text += &format!("; held: {}", moved.into_iter().map(at).collect::<Vec<_>>().join(", "));
        }
    }
    text
}

/// Rejects a moving link without `<inertial>`, unless parts fixed to it have the mass.
fn has_mass(markup: &Markup<'_>, urdf: &Description<'_>, chain: &Chain, i: usize) -> Result<(), FileError> {
    let index = chain.moving[i];
    let link = &urdf.links[chain.child[index]];
    if child(&link.node, "inertial").is_some() || merge::body(urdf, chain, i) != Body::massless() {
        return Ok(());
    }
    let label = Robot::joint_label(i, urdf.joints[index].name);
    let field = format!("link {}.inertial", link.name);
    let problem = format!("missing, but the link moves with {label}, and nothing fixed to it has a mass");
    Err(markup.error(
        &link.node,
        field,
        problem,
        "an <inertial> with mass and inertia; `newtau import` writes a robot file in which the gap is marked",
    ))
}

/// The core's error, reported at the element that caused it.
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
