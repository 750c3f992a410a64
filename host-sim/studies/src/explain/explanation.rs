//! Result of `explain`, term by term.

use crate::trade::chip::{Cost, Load};
use robot_compiler::choose::TorqueError;
use robot_compiler::kernel::Operations;
use serde::Serialize;
use sim::run::joint_label::JointLabel;

/// Terms of a scene's model: their cost and their benefit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// Name of the scene.
    pub scene: String,
    /// Name of the robot.
    pub robot: String,
    /// The control law.
    pub law: &'static str,
    /// Level of the kernel whose operations are counted.
    pub level: &'static str,
    /// Every joint, base first.
    pub joints: Vec<Joint>,
    /// Tolerance of the torque error, as a share of each joint's torque limit.
    pub tolerance: f64,
    /// Operations per tick with every term: inverse dynamics and friction feedforward.
    pub operations: OperationCount,
    /// Cost of a chip's tick with every term, if measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chip: Option<OnChip>,
    /// The closed loop with every term.
    pub tracking: Tracking,
    /// Report on each term.
    pub terms: Vec<TermReport>,
    /// Terms of friction in addition to viscous and Coulomb friction; empty if no joint has any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub friction: Vec<PartReport>,
    /// The smallest set of terms that keeps the tolerance.
    pub fewest: Fewest,
}

/// Cost and benefit of one term of friction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartReport {
    /// Name of the term.
    pub term: &'static str,
    /// Names of the joints that have it.
    pub joints: Vec<String>,
    /// Operations saved without it.
    pub operations: OperationCount,
    /// Cost saved on the chip without it, if measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chip: Option<ChipSaving>,
    /// Torque of the term on the reference motion.
    pub torque: Error,
    /// The closed loop without it, in the same world.
    pub tracking: Tracking,
}

/// A joint of the arm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Joint {
    /// Name of the joint.
    pub name: String,
    /// `N m` or `N`.
    pub torque_unit: &'static str,
    /// `rad` or `m`.
    pub position_unit: &'static str,
    /// Greatest torque or force; `None` without a limit.
    pub torque_limit: Option<f64>,
}

/// Number of operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct OperationCount {
    /// Multiplications.
    pub mul: i64,
    /// Additions.
    pub add: i64,
    /// Subtractions.
    pub sub: i64,
}

/// Cost and benefit of one term.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TermReport {
    /// Name of the term.
    pub term: &'static str,
    /// `absent`, `constant`, `live`, or `given up` by `terms = "auto"`.
    pub state: &'static str,
    /// Source of the state.
    pub why: String,
    /// Effect of dropping the term; `None` if it is absent.
    pub dropped: Option<Dropped>,
}

/// Effect of dropping terms.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dropped {
    /// Operations saved.
    pub operations: OperationCount,
    /// Cost saved on the chip, if measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chip: Option<ChipSaving>,
    /// Torque error of the reduced model on the reference motion.
    pub torque_error: Error,
    /// The closed loop with the reduced model, in the same world.
    pub tracking: Tracking,
    /// True if the torque error keeps the tolerance.
    pub within_tolerance: bool,
    /// Least loop gain along the motion, relative to 1 for the full model.
    pub loop_gain: f64,
    /// Joint that moves most in the mode with this loop gain; `None` if the loop gain is 1.
    pub weakest_joint: Option<usize>,
    /// True if the closed loop tracks well enough with the reduced model. Checked only if a joint has no torque limit, because the torque error
    /// cannot then be compared with the drive's torque.
    pub follows: bool,
    /// True if the torque error, the loop gain and the tracking allow dropping the term.
    pub may_go: bool,
}

/// Cost of a chip's tick with every term.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OnChip {
    /// Cost of the controller.
    pub controller: Cost,
    /// Cost of the whole interrupt, and its share of the processor at `rate`.
    pub interrupt: Load,
    /// Control rate, Hz.
    pub rate: f64,
}

/// Cost of a chip's tick saved by dropping a term.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChipSaving {
    /// Mean number of instructions.
    pub instructions: f64,
    /// Mean number of cycles, estimated.
    pub cycles: f64,
    /// Code size of the tick and of everything it calls, bytes.
    pub flash: i64,
    /// Cost of the whole interrupt without the term, and its share of the processor.
    pub interrupt: Load,
}

/// Torque error per joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Error {
    /// Greatest magnitude, N m or N.
    pub max: Vec<f64>,
    /// Root mean square, N m or N.
    pub rms: Vec<f64>,
    /// Greatest magnitude divided by the torque limit; `None` without a limit.
    pub of_limit: Vec<Option<f64>>,
    /// Greatest magnitude divided by the torque limit, or by the greatest torque along the motion if there is no limit.
    pub share: Vec<f64>,
}

/// Tracking of a closed loop.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tracking {
    /// Greatest error per joint, rad or m.
    pub max: Vec<f64>,
    /// Root mean square error per joint, rad or m.
    pub rms: Vec<f64>,
    /// Reason why the loop ended early or braked.
    pub fault: Option<String>,
}

/// The smallest set of terms that keeps the tolerance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fewest {
    /// True if the scene uses this set: `terms = "auto"`, at this tolerance.
    pub chosen: bool,
    /// Names of the dropped terms.
    pub given_up: Vec<&'static str>,
    /// Effect of dropping all of them together.
    pub dropped: Dropped,
}

impl Joint {
    pub(super) fn new(joint: &robot_compiler::RobotJoint) -> Self {
        let limit = joint.spec.limits.torque;
        let label = JointLabel::from(joint);
        let (torque_unit, position_unit) = (label.torque_unit(), label.position_unit());
        let torque_limit = limit.is_finite().then_some(limit);
        Self { name: label.name, torque_unit, position_unit, torque_limit }
    }
}

impl OperationCount {
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
    fn from(TorqueError { max, rms, of_limit, share }: TorqueError) -> Self {
        Self { max, rms, of_limit, share }
    }
}

impl Error {
    /// The joint with the greatest share.
    pub(super) fn worst(&self) -> usize {
        let by = |i: &usize| (self.share[*i], self.max[*i]);
        let worse = |a: &usize, b: &usize| by(a).partial_cmp(&by(b)).unwrap_or(core::cmp::Ordering::Equal);
        (0..self.max.len()).max_by(worse).unwrap_or(0)
    }
}
