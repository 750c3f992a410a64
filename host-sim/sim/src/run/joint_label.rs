//! Names, kinds and units of joints.

use dynamics_core::JointKind;
use robot_compiler::RobotJoint;

/// Name and kind of a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct JointLabel {
    /// Its name in the robot file.
    pub name: String,
    /// Revolute or prismatic; decides the units.
    pub kind: JointKind,
}

impl From<&RobotJoint> for JointLabel {
    fn from(joint: &RobotJoint) -> Self {
        Self { name: joint.name.clone(), kind: joint.spec.kind }
    }
}

impl JointLabel {
    /// Unit of the joint's position.
    #[must_use]
    pub fn position_unit(&self) -> &'static str {
        match self.kind {
            JointKind::Revolute => "rad",
            JointKind::Prismatic => "m",
        }
    }

    /// Unit of the joint's velocity.
    #[must_use]
    pub fn velocity_unit(&self) -> &'static str {
        match self.kind {
            JointKind::Revolute => "rad/s",
            JointKind::Prismatic => "m/s",
        }
    }

    /// Name of the actuator's output: torque or force.
    #[must_use]
    pub fn effort(&self) -> &'static str {
        match self.kind {
            JointKind::Revolute => "torque",
            JointKind::Prismatic => "force",
        }
    }

    /// Unit of the joint's torque or force.
    #[must_use]
    pub fn torque_unit(&self) -> &'static str {
        match self.kind {
            JointKind::Revolute => "N m",
            JointKind::Prismatic => "N",
        }
    }
}
