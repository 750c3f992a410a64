//! Faults of a log that have an explanation.

use crate::correction::Correction;
use nalgebra::Vector3;

/// A way in which a log, or the description of the arm's mounting, can be wrong. Joints are counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// The torque of a joint has the opposite sign.
    TorqueSign(usize),
    /// All torques have the opposite sign.
    TorqueSigns,
    /// The position of a joint has the opposite sign.
    PositionSign(usize),
    /// All positions have the opposite sign.
    PositionSigns,
    /// The torque of a joint is recorded in another unit, or on another side of a gear: the factor that mends it.
    TorqueScale(usize, f64),
    /// The same for all joints.
    TorqueScales(f64),
    /// All positions are recorded in another unit: the factor that mends it.
    PositionScales(f64),
    /// The torques are those of other joints: of each joint, the joint whose columns hold its torque.
    TorqueOrder(Vec<usize>),
    /// The positions are those of other joints.
    PositionOrder(Vec<usize>),
    /// Positions and torques are those of other joints.
    Order(Vec<usize>),
    /// Gravity acts in another direction in the base frame, m/s^2: the arm is mounted otherwise.
    Gravity(Vector3<f64>),
    /// The torques hold no weight: the robot has removed it before it recorded them.
    NoGravity,
}

impl Fault {
    /// Nats by which an explanation with this fault must be better than one without: rare ones must show more.
    pub(super) const fn cost(&self) -> f64 {
        match self {
            Self::TorqueSign(_) | Self::TorqueSigns => 2.0,
            Self::PositionSign(_) | Self::PositionSigns | Self::NoGravity => 3.0,
            Self::TorqueScales(_) | Self::TorqueOrder(_) | Self::Order(_) => 4.0,
            Self::TorqueScale(..) | Self::PositionOrder(_) | Self::PositionScales(_) | Self::Gravity(_) => 5.0,
        }
    }

    /// True if the fault concerns the motion or gravity: the columns of the model change.
    pub(super) const fn is_of_motion(&self) -> bool {
        !matches!(
            self,
            Self::TorqueSign(_)
                | Self::TorqueSigns
                | Self::TorqueScale(..)
                | Self::TorqueScales(_)
                | Self::TorqueOrder(_)
        )
    }

    /// Adds what mends this fault.
    pub(super) fn mend(&self, correction: &mut Correction, gravity: &mut Vector3<f64>) {
        let sort = |from: &mut Vec<usize>, factor: &mut Vec<f64>, order: &[usize]| {
            *from = order.iter().map(|k| from[*k]).collect();
            *factor = order.iter().map(|k| factor[*k]).collect();
        };
        let all = |factors: &mut Vec<f64>, by: f64| factors.iter_mut().for_each(|factor| *factor *= by);
        match self {
            Self::TorqueSign(joint) => correction.torque[*joint] *= -1.0,
            Self::TorqueSigns => all(&mut correction.torque, -1.0),
            Self::PositionSign(joint) => correction.position[*joint] *= -1.0,
            Self::PositionSigns => all(&mut correction.position, -1.0),
            Self::TorqueScale(joint, by) => correction.torque[*joint] *= by,
            Self::TorqueScales(by) => all(&mut correction.torque, *by),
            Self::PositionScales(by) => all(&mut correction.position, *by),
            Self::TorqueOrder(order) => sort(&mut correction.torques_from, &mut correction.torque, order),
            Self::PositionOrder(order) => sort(&mut correction.positions_from, &mut correction.position, order),
            Self::Order(order) => {
                sort(&mut correction.torques_from, &mut correction.torque, order);
                sort(&mut correction.positions_from, &mut correction.position, order);
            }
            Self::Gravity(direction) => *gravity = *direction,
            Self::NoGravity => *gravity = Vector3::zeros(),
        }
    }
}
