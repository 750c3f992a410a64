//! An explanation, term by term.

use crate::study::trade::Cost;
use dynamics_core::JointKind;
use robot_compiler::choose::TorqueError;
use robot_compiler::kernel::Operations;
use serde::Serialize;

/// What a scene's model computes, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// The scene's name.
    pub scene: String,
    /// The robot's name.
    pub robot: String,
    /// The control law.
    pub law: &'static str,
    /// Level of the kernel whose operations are counted.
    pub level: &'static str,
    /// Every joint, base first.
    pub joints: Vec<Joint>,
    /// Share of each joint's torque limit that the terms are held against.
    pub tolerance: f64,
    /// Operations of a tick's inverse dynamics and friction feedforward with every term.
    pub operations: Count,
    /// What a tick of the chip takes with every term, where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chip: Option<Cost>,
    /// The closed loop with every term.
    pub tracking: Tracking,
    /// Each term.
    pub terms: Vec<TermReport>,
    /// The fewest terms that keep the tolerance.
    pub fewest: Fewest,
}

/// A joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// `N m` or `N`.
    pub torque_unit: &'static str,
    /// `rad` or `m`.
    pub position_unit: &'static str,
    /// Greatest torque or force; none where there is no limit.
    pub torque_limit: Option<f64>,
}

/// Operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Count {
    /// Multiplications.
    pub mul: i64,
    /// Additions.
    pub add: i64,
    /// Subtractions.
    pub sub: i64,
}

/// What one term is worth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TermReport {
    /// Its name.
    pub term: &'static str,
    /// `absent`, `constant`, `live`, or `given up` by `terms = "auto"`.
    pub state: &'static str,
    /// Where that was said.
    pub why: String,
    /// What dropping it does; none where it is absent.
    pub dropped: Option<Dropped>,
}

/// What dropping terms does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dropped {
    /// Operations less.
    pub operations: Count,
    /// What a tick of the chip takes less; where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chip: Option<ChipSaving>,
    /// Torque that the model then leaves out on the reference motion.
    pub torque_error: Error,
    /// The closed loop with that model, in the same world.
    pub tracking: Tracking,
    /// Whether the torque error keeps the tolerance.
    pub within_tolerance: bool,
    /// Least loop gain along the motion, where the full model has 1.
    pub loop_gain: f64,
    /// The joint that moves most in the mode of that loop gain; none where it is 1.
    pub weakest_joint: Option<usize>,
    /// Whether both allow it to go.
    pub may_go: bool,
}

/// What a tick of the chip takes less without a term.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChipSaving {
    /// Instructions, mean.
    pub instructions: f64,
    /// Cycles, mean: an estimate.
    pub cycles: f64,
    /// Bytes of the tick and all that it reaches.
    pub flash: i64,
}

/// A torque error per joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Error {
    /// Greatest magnitude, N m or N.
    pub max: Vec<f64>,
    /// Root mean square, N m or N.
    pub rms: Vec<f64>,
    /// Greatest magnitude over the torque limit.
    pub of_limit: Vec<Option<f64>>,
}

/// How a closed loop went.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tracking {
    /// Per joint, greatest error, rad or m.
    pub max: Vec<f64>,
    /// Per joint, root mean square of it.
    pub rms: Vec<f64>,
    /// What ended it early, or braked it.
    pub fault: Option<String>,
}

/// The fewest terms that keep the tolerance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fewest {
    /// Whether the scene asks for them: `terms = "auto"`, at this tolerance.
    pub chosen: bool,
    /// What goes.
    pub given_up: Vec<&'static str>,
    /// What that does, all together.
    pub dropped: Dropped,
}

impl Joint {
    pub(super) fn new(joint: &robot_compiler::RobotJoint) -> Self {
        let limit = joint.spec.limits.torque;
        let (torque_unit, position_unit) = match joint.spec.kind {
            JointKind::Revolute => ("N m", "rad"),
            JointKind::Prismatic => ("N", "m"),
        };
        let torque_limit = limit.is_finite().then_some(limit);
        Self { name: joint.name.clone(), torque_unit, position_unit, torque_limit }
    }
}

impl Count {
    pub(super) fn less(more: &Operations, less: &Operations) -> Self {
        let signed = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
        Self {
            mul: signed(more.mul) - signed(less.mul),
            add: signed(more.add) - signed(less.add),
            sub: signed(more.sub) - signed(less.sub),
        }
    }
}

impl From<TorqueError> for Error {
    fn from(TorqueError { max, rms, of_limit }: TorqueError) -> Self {
        Self { max, rms, of_limit }
    }
}

impl Error {
    /// The joint that is worst off, by its share of the limit, or where no joint has one by the torque.
    pub(super) fn worst(&self) -> usize {
        let by = |i: &usize| (self.of_limit[*i].unwrap_or(0.0), self.max[*i]);
        let worse = |a: &usize, b: &usize| by(a).partial_cmp(&by(b)).unwrap_or(core::cmp::Ordering::Equal);
        (0..self.max.len()).max_by(worse).unwrap_or(0)
    }
}
