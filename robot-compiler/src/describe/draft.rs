//! Arm as its file states it, before any of it is refused.

use super::diagnostics::{FileError, Source};
use super::robot::{BuildError, Robot};
use crate::with_dof;
use dynamics_core::model::Impossible;
use dynamics_core::{Body, JointKind, JointSpec, Limits, ModelError};
use nalgebra::Vector3;
use std::ops::Range;

/// An arm as its file states it: its bodies may be those of no mass distribution, its limits may be impossible.
///
/// The bodies are those of the file: of a URDF every link by itself, before fixed links are merged. Every number knows its
/// place, so that [`findings`](crate::check::findings) can point at it.
#[derive(Clone, Debug)]
pub struct Draft {
    /// The arm, unchecked; fixed links are merged.
    pub robot: Robot,
    pub(crate) source: Source,
    pub(crate) kind: FileKind,
    pub(crate) bodies: Vec<DraftBody>,
    pub(crate) places: Vec<JointPlaces>,
    /// Remarks of its reader beside the numbers.
    pub(crate) remarks: Vec<Remark>,
    /// Angles beyond a turn, rad, as the file states them.
    pub(crate) angles: Vec<(Place, f64)>,
}

/// Remark of a file's reader beside its numbers.
#[derive(Clone, Debug)]
pub(crate) struct Remark {
    pub(crate) kind: RemarkKind,
    pub(crate) place: Place,
    pub(crate) problem: String,
    pub(crate) advice: String,
}

/// Subject of a remark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RemarkKind {
    /// An element or attribute that is not read.
    Unknown {
        /// True if a word of the format is near.
        misspelt: bool,
    },
    /// A part of a body that is missing.
    Gap,
    /// A joint that is held.
    Held,
    /// A base that may be turned.
    Base,
    /// A line of a robot file that begins with `# ?`.
    Open,
}

/// Format of a robot file: it decides what can be missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileKind {
    Toml,
    Urdf,
}

/// A place in the text that a finding points at.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) span: Range<usize>,
    /// The field, as a path.
    pub(crate) field: String,
    /// True if the field is there; a missing one has the place of what it is missing from.
    pub(crate) given: bool,
}

/// A body of the file.
#[derive(Clone, Debug)]
pub(crate) struct DraftBody {
    /// The joint that moves it, counted from 0.
    pub(crate) joint: usize,
    /// True if it is fixed to the link that the joint moves, and not that link itself.
    pub(crate) fixed: bool,
    /// As stated, in the axes of the file.
    pub(crate) body: Body,
    /// Mass centre in the frame of `points`, m.
    pub(crate) centre: Vector3<f64>,
    /// Origins of the joints on it, its own and those that it carries, in one frame, m; of a slide both ends of its travel.
    pub(crate) points: Vec<Vector3<f64>>,
    pub(crate) mass: Place,
    pub(crate) com: Place,
    pub(crate) inertia: Place,
}

/// Places of a joint's fields.
#[derive(Clone, Debug)]
pub(crate) struct JointPlaces {
    pub(crate) position: Place,
    /// True for a joint whose type says that it turns without an end.
    pub(crate) turns_on: bool,
    pub(crate) velocity: Place,
    pub(crate) torque: Place,
    pub(crate) rotor: Place,
    pub(crate) friction: Place,
    pub(crate) encoder: Place,
    pub(crate) drive_torque: Place,
    pub(crate) drive_position: Place,
    pub(crate) heat: Place,
    /// The arm's rest pose, or where it would stand.
    pub(crate) rest: Place,
}

impl Draft {
    /// The arm with its joints and masses as stated, so that it can be put into postures; `None` with a mass below zero.
    ///
    /// Inertia tensors may be impossible, and limits that are impossible are left out.
    #[must_use]
    pub fn arm(&self) -> Option<Robot> {
        let mut arm = self.robot.clone();
        arm.allow_unphysical.get_or_insert_with(|| "looked at, not used".to_owned());
        for joint in &mut arm.joints {
            let (limits, free) = (&mut joint.spec.limits, Limits::none());
            if limits.position.0 >= limits.position.1 {
                limits.position = free.position;
            }
            for limit in [&mut limits.velocity, &mut limits.torque, &mut limits.torque_rate] {
                if *limit <= 0.0 {
                    *limit = f64::INFINITY;
                }
            }
        }
        arm.check().is_ok().then_some(arm)
    }

    /// Length of the stretched arm, m: the distances from joint to joint and to the tip, and the travel of slides.
    #[must_use]
    pub fn length(&self) -> f64 {
        let steps = bones(&skeleton(&self.robot)).into_iter().map(|bone| bone.end.norm());
        let travel = self.robot.joints.iter().flat_map(|joint| own_joint(&joint.spec, Vector3::z()));
        steps.chain(travel.map(|point| point.norm())).sum()
    }

    /// Mass of all that moves, kg.
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.robot.joints.iter().map(|joint| joint.spec.body.mass).sum::<f64>() + self.robot.tool.body.mass
    }

    /// An error at a place of the file.
    pub(crate) fn error(&self, place: &Place, problem: String, expected: String) -> FileError {
        self.source.error(place.span.clone(), place.field.clone(), problem, expected)
    }
}

/// A link in the frame of its joint.
pub(crate) struct Bone {
    /// Mass centre of the link's body, m.
    pub(crate) centre: Vector3<f64>,
    /// Origin of the next joint, or of the tip, m.
    pub(crate) end: Vector3<f64>,
}

/// Joints and ends of all links, base first; of a robot whose [`skeleton`] is possible.
pub(crate) fn bones(skeleton: &Robot) -> Vec<Bone> {
    with_dof!(skeleton.dof(), N => {
        // Lengths that no number holds are refused when the file is read.
        let Ok(model) = skeleton.model::<N>() else { return Vec::new() };
        let links = model.links();
        (0..N).map(|i| Bone {
            centre: links[i].inertia.first_moment,
            end: links.get(i + 1).map_or(model.tip().translation, |next| next.translation),
        }).collect()
    })
}

/// The same joints without limits, with a point of 1 kg at every mass centre.
pub(crate) fn skeleton(robot: &Robot) -> Robot {
    let mut skeleton = robot.clone();
    for joint in &mut skeleton.joints {
        joint.spec.body = Body { mass: 1.0, com: joint.spec.body.com, ..Body::massless() };
        joint.spec.limits = Limits::none();
    }
    skeleton.tool.body = Body::massless();
    skeleton
}

/// Points at which a link meets its own joint, along the axis of a slide, m.
pub(crate) fn own_joint(spec: &JointSpec, axis: Vector3<f64>) -> Vec<Vector3<f64>> {
    let (low, high) = spec.limits.position;
    if spec.kind == JointKind::Prismatic && low.is_finite() && high.is_finite() {
        // The link has moved on by q, so that its joint lies behind it.
        vec![axis * -low, axis * -high]
    } else {
        vec![Vector3::zeros()]
    }
}

/// Refuses an arm that no rule of the check speaks of: it can only be refused, as by [`Robot::load`].
pub(crate) fn readable(robot: &Robot) -> Result<(), BuildError> {
    skeleton(robot).check()?;
    match robot.check() {
        Err(BuildError::Impossible(ModelError { what, .. })) if has_a_rule(&what) => Ok(()),
        checked => checked,
    }
}

fn has_a_rule(what: &Impossible) -> bool {
    matches!(
        what,
        Impossible::NegativeMass(_)
            | Impossible::InertiaWithoutMass(_)
            | Impossible::NegativePrincipalMoment(_)
            | Impossible::TriangleInequality(_)
            | Impossible::PositionLimitsReversed(..)
            | Impossible::LimitNotPositive("velocity" | "torque", _)
    )
}
