//! An arm as stated in its file, before anything is rejected.

use super::diagnostics::{FileError, Source};
use super::robot::{BuildError, Robot};
use crate::with_dof;
use dynamics_core::model::Impossible;
use dynamics_core::{Body, JointKind, JointSpec, Limits, ModelError};
use nalgebra::Vector3;
use std::ops::Range;

/// An arm as stated in its file: no mass distribution may have its bodies, and its limits may be impossible.
///
/// The bodies are those of the file. For a URDF that is every link separately, before fixed links are merged. Every number has its
/// location, so that [`findings`](crate::check::findings) can refer to it.
#[derive(Clone, Debug)]
pub struct Draft {
    /// The arm, unchecked; fixed links are merged.
    pub robot: Robot,
    pub(crate) source: Source,
    pub(crate) kind: FileKind,
    pub(crate) bodies: Vec<DraftBody>,
    pub(crate) places: Vec<JointPlaces>,
    /// Remarks of its reader in addition to the numbers.
    pub(crate) remarks: Vec<Remark>,
    /// Angles beyond a turn, rad, as stated in the file.
    pub(crate) angles: Vec<(Place, f64)>,
}

/// Remark of a file's reader in addition to its numbers.
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
        /// True if a known word of the format is similar.
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

/// Format of a robot file. Which values can be missing depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileKind {
    Toml,
    Urdf,
}

/// A location in the text to which a finding refers.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) span: Range<usize>,
    /// The field, as a path.
    pub(crate) field: String,
    /// True if the field is present; a missing field has the location of the part in which it is missing.
    pub(crate) given: bool,
}

/// A body of the file.
#[derive(Clone, Debug)]
pub(crate) struct DraftBody {
    /// The joint that moves it, counted from 0.
    pub(crate) joint: usize,
    /// True for a body that is fixed to the moved link, false for the link itself.
    pub(crate) fixed: bool,
    /// Body as stated, in the axes of the file.
    pub(crate) body: Body,
    /// Mass centre in the frame of `points`, m.
    pub(crate) centre: Vector3<f64>,
    /// Origins of the joints on it, its own and those that it carries, in one frame, m; for a slide, both ends of its travel.
    pub(crate) points: Vec<Vector3<f64>>,
    pub(crate) mass: Place,
    pub(crate) com: Place,
    pub(crate) inertia: Place,
}

/// Locations of a joint's fields.
#[derive(Clone, Debug)]
pub(crate) struct JointPlaces {
    pub(crate) position: Place,
    /// True if the joint's type declares that it turns without an end.
    pub(crate) turns_on: bool,
    pub(crate) velocity: Place,
    pub(crate) torque: Place,
    pub(crate) rotor: Place,
    pub(crate) friction: Place,
    pub(crate) encoder: Place,
    pub(crate) drive_torque: Place,
    pub(crate) drive_position: Place,
    pub(crate) heat: Place,
    /// Location of the arm's rest pose, or where it would be.
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

    /// Total mass of all moving links, kg.
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.robot.joints.iter().map(|joint| joint.spec.body.mass).sum::<f64>() + self.robot.tool.body.mass
    }

    /// An error at a location of the file.
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

/// Joints and ends of all links, base first, for a robot with a valid [`skeleton`].
pub(crate) fn bones(skeleton: &Robot) -> Vec<Bone> {
    with_dof!(skeleton.dof(), N => {
        // Lengths that a number cannot hold are rejected when the file is read.
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
        // The link has moved by q, so the joint is at -q in the link's frame.
        vec![axis * -low, axis * -high]
    } else {
        vec![Vector3::zeros()]
    }
}

/// Rejects an arm with an error for which no rule of the check exists, as [`Robot::load`] does.
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
