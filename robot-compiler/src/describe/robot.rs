//! Arm, as a robot file describes it.

use crate::describe::diagnostics::FileError;
use crate::describe::drive::JointDrive;
use crate::describe::friction::JointFriction;
use crate::with_dof;
use dynamics_core::model::{Impossible, Place};
use dynamics_core::safety::heat::HeatRules;
use dynamics_core::{Body, Dh, Frame, JointKind, JointSpec, Limits, Model, ModelError, Rotor, Tool};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;
use std::path::PathBuf;

/// Fewest and most joints of an arm.
pub(crate) const DOF: std::ops::RangeInclusive<usize> = 1..=6;

/// An arm: a serial chain of one to six joints.
///
/// [`Robot::load`] returns only checked robots: [`Robot::model`] with the right `N` then succeeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Short name.
    pub name: String,
    /// Source of the numbers.
    pub source: String,
    /// Reason for accepting bodies that no mass distribution could have; with `None` they are rejected.
    pub allow_unphysical: Option<String>,
    /// Reason why values that the file leaves out are ideal: no rotors, no friction, no limits. `None`: they are missing.
    pub ideal: Option<String>,
    /// The joints and their links, base first.
    pub joints: Vec<RobotJoint>,
    /// The tool on the last link.
    pub tool: Tool,
    /// Pose in which the arm rests without torque, rad or m; `None` if the file gives none.
    pub rest: Option<Vec<f64>>,
    /// Orientation of the base frame in a world whose z axis points up, if the file gives one; `None` is upright.
    pub mounting: Option<Matrix3<f64>>,
    /// The file from which it was read.
    pub path: PathBuf,
}

/// Gravitational acceleration in a world whose z axis points up, m/s^2.
pub(crate) const FLOOR: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// One joint, its link, its motor and its sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotJoint {
    /// Name, unique in the arm.
    pub name: String,
    /// Kinematics, mass properties, rotor and limits.
    pub spec: JointSpec,
    /// Friction at the joint, if known.
    pub friction: Option<JointFriction>,
    /// The encoder, if there is one.
    pub encoder: Option<JointEncoder>,
    /// The drive, if the file gives one: either every joint of an arm has one, or none has.
    pub drive: Option<JointDrive>,
    /// Continuous and peak torque of its motor.
    pub heat: JointHeat,
}

/// Continuous and peak torque of a joint's motor, at the joint, and its thermal time constant. `None`: unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointHeat {
    /// Continuous torque or force, N m or N.
    pub rated: Option<f64>,
    /// Peak torque or force for a short time, N m or N.
    pub peak: Option<f64>,
    /// Thermal time constant of its winding, s.
    pub time_constant: Option<f64>,
}

impl JointHeat {
    /// The heat model of the winding with this time between two updates, s; `None` if one of its numbers is unknown.
    #[must_use]
    pub fn rules(&self, update: f64) -> Option<HeatRules<f64>> {
        Some(HeatRules::new(self.rated?, self.time_constant?, update))
    }
}

impl RobotJoint {
    /// True if the joint's drive has its own loop with a spring and a damper, as [`dynamics_core::control::ControlLaw::Split`] needs.
    #[must_use]
    pub fn has_own_loop(&self) -> bool {
        self.drive.is_some_and(|drive| drive.mit().is_some())
    }

    /// Joint position per count of the encoder, rad or m, if there is one.
    pub(crate) fn per_count(&self) -> Option<f64> {
        let counts = self.encoder?.counts_per_turn;
        Some(match self.spec.kind {
            JointKind::Revolute => TAU / counts,
            JointKind::Prismatic => 1.0 / counts,
        })
    }
}

/// Encoder of a joint, on the joint's side of the gear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointEncoder {
    /// Counts per turn of a revolute joint, per metre of a prismatic one.
    pub counts_per_turn: f64,
}

/// Reason why a description does not give an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BuildError {
    /// The core rejected it.
    Impossible(ModelError),
    /// A number of a link that is too large for single precision, and so for the chip; the joint is counted from 0.
    TooLarge(usize),
}

impl Robot {
    /// Number of joints.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// Gravitational acceleration in the base frame, m/s^2: along -z, unless the base is turned.
    #[must_use]
    pub fn gravity(&self) -> Vector3<f64> {
        self.mounting.map_or(FLOOR, |world_from_base| world_from_base.transpose() * FLOOR)
    }

    /// A sentence about a turned base: its angle, and gravity in its frame. Empty for an upright base.
    #[must_use]
    pub fn mounting_note(&self) -> String {
        let Some(rotation) = self.mounting else { return String::new() };
        let tilt = rotation.m33.clamp(-1.0, 1.0).acos().to_degrees();
        let [x, y, z] = <[f64; 3]>::from(self.gravity()).map(|g| (g * 1e3).round() / 1e3 + 0.0);
        format!(
            "the base is turned: its z axis is {tilt:.1} degrees off upright, gravity is ({x}, {y}, {z}) m/s^2 in its frame"
        )
    }

    /// The checked model.
    ///
    /// # Errors
    /// `N` is not the robot's number of joints, or a field was changed after loading to something impossible.
    pub fn model<const N: usize>(&self) -> Result<Model<f64, N>, FileError> {
        let specs: Vec<JointSpec> = self.joints.iter().map(|joint| joint.spec).collect();
        let specs: [JointSpec; N] = specs.try_into().map_err(|specs: Vec<_>| {
            let problem = format!("the robot has {} joints", specs.len());
            FileError::whole_file(&self.path, "joint", problem, format!("{N} joints"))
        })?;
        build(&specs, &self.tool, self.allow_unphysical.is_some()).map_err(|error| {
            let (place, problem, expected) = error.describe(self);
            FileError::whole_file(&self.path, place, problem, expected)
        })
    }

    /// Checks that the arm is possible, and reports the reason if it is not.
    pub(crate) fn check(&self) -> Result<(), BuildError> {
        let specs: Vec<JointSpec> = self.joints.iter().map(|joint| joint.spec).collect();
        with_dof!(specs.len(), N => {
            // A count outside 1..=6 has been rejected before, with its location in the file.
            let Ok(specs) = <[JointSpec; N]>::try_from(specs) else { return Ok(()) };
            build(&specs, &self.tool, self.allow_unphysical.is_some()).map(|_| ())
        })
    }

    /// Name of a joint in errors: its number, counted from 1, and its name.
    pub(crate) fn joint_label(index: usize, name: &str) -> String {
        format!("joint {} ({name})", index + 1)
    }
}

impl BuildError {
    /// Returns the part at fault, what was found and what was expected.
    pub(crate) fn describe(&self, robot: &Robot) -> (String, String, &'static str) {
        let label = |index: usize| {
            let name = robot.joints.get(index).map_or("?", |joint| joint.name.as_str());
            Robot::joint_label(index, name)
        };
        match self {
            Self::Impossible(ModelError { place: Place::Joint(index), what }) => {
                (label(*index), what.to_string(), expectation(what))
            }
            Self::Impossible(ModelError { place: Place::Tool, what }) => {
                ("tool".to_owned(), what.to_string(), expectation(what))
            }
            Self::TooLarge(index) => {
                (label(*index), "a mass, length or inertia of the link is too large".to_owned(), SINGLE)
            }
        }
    }
}

const SINGLE: &str = "numbers in SI units that fit single precision, below 3e38";

fn build<const N: usize>(specs: &[JointSpec; N], tool: &Tool, unphysical: bool) -> Result<Model<f64, N>, BuildError> {
    let model = if unphysical { Model::new_unphysical(specs, tool) } else { Model::new(specs, tool) };
    let model = model.map_err(BuildError::Impossible)?;
    let single = model.cast::<f32>();
    for (index, link) in single.links().iter().enumerate() {
        let body = &link.inertia;
        let numbers = [link.rotor, body.mass];
        let all = numbers
            .iter()
            .chain(&link.rotation)
            .chain(&link.translation)
            .chain(&body.first_moment)
            .chain(&body.about_origin);
        if !all.into_iter().all(|x| x.is_finite()) {
            return Err(BuildError::TooLarge(index));
        }
    }
    let tip = single.tip();
    if tip.rotation.iter().chain(&tip.translation).all(|x| x.is_finite()) {
        Ok(model)
    } else {
        Err(BuildError::TooLarge(N - 1))
    }
}

/// Checks that some mass distribution could have this body; the error holds what was found and what was expected.
pub(crate) fn physical_body(body: &Body) -> Result<(), (String, &'static str)> {
    let joint = JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh::default()),
        body: Body::massless(),
        rotor: Rotor::default(),
        limits: Limits::none(),
    };
    let tool = Tool { body: *body, ..Tool::default() };
    build(&[joint], &tool, false).map(|_| ()).map_err(|error| match error {
        BuildError::Impossible(ModelError { what, .. }) => (what.to_string(), expectation(&what)),
        BuildError::TooLarge(_) => ("a mass, length or inertia is too large".to_owned(), SINGLE),
    })
}

/// The expected value, for the error message.
fn expectation(what: &Impossible) -> &'static str {
    match what {
        Impossible::NotFinite(_) => "a finite number",
        Impossible::NegativeMass(_) => "a mass of zero or more, kg",
        Impossible::InertiaWithoutMass(_) => "a mass above zero where an inertia tensor is given",
        Impossible::AsymmetricInertia(_) => "a symmetric inertia tensor",
        Impossible::NegativePrincipalMoment(_) => {
            "an inertia tensor about the centre of mass with no negative principal moment"
        }
        Impossible::TriangleInequality(_) => "principal moments of which any two add up to at least the third",
        Impossible::NonUnitAxis(_) => "an axis of length 1",
        Impossible::NotARotation(_) => "an orthonormal, right-handed rotation",
        Impossible::PositionLimitsReversed(..) => "[lowest, highest] with lowest < highest",
        Impossible::LimitNotPositive(..) => "a limit above zero",
        Impossible::NegativeRotorInertia(_) => "a rotor inertia of zero or more, kg m^2",
    }
}
