//! The recursions that a controller and a simulation of an arm call. The crate re-exports every module under its own name.

pub mod energy;
pub mod forward_dynamics;
pub mod kinematics;
pub mod mass_matrix;
pub mod momentum;
pub mod newton_euler;
pub mod regressor;
pub(crate) mod solve;
