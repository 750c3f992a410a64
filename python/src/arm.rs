//! The class `Arm`: a robot file with gravity and payload, ready to compute.

use dynamics_core::Body;
use pyo3::prelude::*;
use robot_compiler::Robot;

/// A robot arm under gravity. Create one with newtau.load.
#[pyclass(frozen, module = "newtau")]
pub(crate) struct Arm {
    pub(crate) arm: batch_engine::Arm,
    pub(crate) robot: Robot,
    pub(crate) gravity: [f64; 3],
    /// Body held by the tip, in the tip frame.
    pub(crate) payload: Option<Body>,
}
