//! Names that several commands take on the command line.

use clap::ValueEnum;
use dynamics_core::control::Law;
use robot_compiler::kernel::functions::Springs;
use robot_compiler::kernel::{Function, Level, Precision};
use robot_compiler::scene::ScalarChoice;

/// Who computes the torques.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// This program.
    Desk,
    /// The firmware, in an emulated STM32F405.
    Qemu,
}

/// Floating-point type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scalar {
    /// Single precision, as on the chip.
    F32,
    /// Double precision.
    F64,
}

/// Floating-point type of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RunScalar {
    /// Single precision, as on the chip.
    F32,
    /// Double precision.
    F64,
}

/// Control law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LawName {
    /// Inverse dynamics of the measured state and a corrected acceleration.
    ComputedTorque,
    /// Spring and damper per joint.
    Pd,
    /// Spring and damper, and the torque that holds the arm.
    PdGravity,
    /// A fixed inertia per joint for what is asked for, and the torque that holds the arm.
    DiagonalInertia,
    /// Spring and damper, and the torque of the reference motion.
    Feedforward,
}

/// How far a kernel's operations may leave those of the recursion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LevelName {
    /// Every result equal.
    Exact,
    /// Fewer operations, other rounding.
    Regrouped,
}

/// What a kernel computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FunctionName {
    /// D qdd + C qd + G - J^T w
    InverseDynamics,
    /// G(q)
    Gravity,
    /// C(q, qd) qd
    Coriolis,
    /// D(q), the upper triangle row by row.
    MassMatrix,
    /// Force and moment at every joint, base first.
    JointWrenches,
    /// Generalised momentum, then what changes it beside the actuators.
    Momentum,
    /// Accelerations from torques, then the pivots.
    ForwardDynamics,
    /// The law, ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q)), with the scene's gains folded in.
    ComputedTorque,
}

impl FunctionName {
    /// The function of this name, with the gains that the law takes.
    #[must_use]
    pub const fn function(self, springs: Springs) -> Function {
        match self {
            Self::InverseDynamics => Function::InverseDynamics,
            Self::Gravity => Function::Gravity,
            Self::Coriolis => Function::Coriolis,
            Self::MassMatrix => Function::MassMatrix,
            Self::JointWrenches => Function::JointWrenches,
            Self::Momentum => Function::Momentum,
            Self::ForwardDynamics => Function::ForwardDynamics,
            Self::ComputedTorque => Function::ComputedTorque(springs),
        }
    }
}

/// Whether an effect counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Presence {
    /// It counts.
    Present,
    /// It is left out.
    Absent,
}

impl From<RunScalar> for ScalarChoice {
    fn from(scalar: RunScalar) -> Self {
        match scalar {
            RunScalar::F32 => Self::F32,
            RunScalar::F64 => Self::F64,
        }
    }
}

impl From<Scalar> for Precision {
    fn from(scalar: Scalar) -> Self {
        match scalar {
            Scalar::F32 => Self::Single,
            Scalar::F64 => Self::Double,
        }
    }
}

impl From<LevelName> for Level {
    fn from(level: LevelName) -> Self {
        match level {
            LevelName::Exact => Self::Exact,
            LevelName::Regrouped => Self::Regrouped,
        }
    }
}

impl From<LawName> for Law {
    fn from(law: LawName) -> Self {
        match law {
            LawName::ComputedTorque => Self::ComputedTorque,
            LawName::Pd => Self::Pd,
            LawName::PdGravity => Self::PdGravity,
            LawName::DiagonalInertia => Self::DiagonalInertia,
            LawName::Feedforward => Self::Feedforward,
        }
    }
}
