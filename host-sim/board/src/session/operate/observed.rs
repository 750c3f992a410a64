//! Observations of the arm since homing.

/// Observations of one joint since homing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    /// Lowest and highest position, rad or m.
    pub(super) position: (f64, f64),
    /// Largest speed, averaged over 0.05 s, rad/s or m/s.
    pub(super) speed: f64,
    /// Largest difference of the commanded torque from the model's gravity torque, N m or N.
    pub(super) beyond_gravity: f64,
    /// Largest commanded torque, N m or N.
    pub(super) torque: f64,
    /// Largest distance of the joint from the trajectory, rad or m; `None` if no status held a reference.
    pub(super) error: Option<f64>,
}

/// Observations since homing, and the limit of the first motion.
#[derive(Clone, Debug, Default)]
pub(super) struct FirstMotion {
    /// True from homing to `full-range`, if the board limits the first motion.
    pub(super) limited: bool,
    pub(super) joints: Vec<Range>,
    /// Ticks in which torque acted, as far as they were reported.
    pub(super) ticks: u64,
    /// Tick and positions from which the speed is averaged.
    pub(super) from: Option<(u32, Vec<f64>)>,
}
