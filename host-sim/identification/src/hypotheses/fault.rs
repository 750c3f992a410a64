//! Faults that a log can have.

use crate::correction::Correction;
use nalgebra::Vector3;

/// A fault of a log, or of the description of the arm's mounting. Joints are counted from 0.
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
    /// The torque of a joint is recorded in another unit, or on another side of a gear. Holds the factor that corrects it.
    TorqueScale(usize, f64),
    /// The torques of all joints are recorded in another unit. Holds the factor that corrects them.
    TorqueScales(f64),
    /// All positions are recorded in another unit. Holds the factor that corrects them.
    PositionScales(f64),
    /// Torque columns are in another order. Holds, for each joint, the joint whose column contains its torque.
    TorqueOrder(Vec<usize>),
    /// Position columns are in another order, as in [`Fault::TorqueOrder`].
    PositionOrder(Vec<usize>),
    /// Position and torque columns are both in another order, as in [`Fault::TorqueOrder`].
    Order(Vec<usize>),
    /// Gravity acts in another direction in the base frame, m/s^2: the arm is mounted differently.
    Gravity(Vector3<f64>),
    /// The torques contain no weight: the robot has subtracted gravity before recording.
    NoGravity,
}

impl Fault {
    /// Score that this fault must bring to be accepted, nats. Rare faults need more evidence.
    pub(super) const fn cost(&self) -> f64 {
        match self {
            Self::TorqueSign(_) | Self::TorqueSigns => 2.0,
            Self::PositionSign(_) | Self::PositionSigns | Self::NoGravity => 3.0,
            Self::TorqueScales(_) | Self::TorqueOrder(_) | Self::Order(_) => 4.0,
            Self::TorqueScale(..) | Self::PositionOrder(_) | Self::PositionScales(_) | Self::Gravity(_) => 5.0,
        }
    }

    /// True if the fault concerns the motion or gravity, so that the model's columns change.
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

    /// Adds the correction of this fault.
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
