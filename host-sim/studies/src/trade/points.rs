//! Choices with their measurements.

use super::chip::{Cost, InterruptCost, Load};
use super::choice::Choice;
use super::drive_step::DriveStep;
use super::measure::OnMotion;
use super::simulator::MethodReport;
use super::test_motions::TestMotionReport;
use serde::Serialize;

/// A choice and its measurements.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TradePoint {
    /// The choice.
    pub choice: Choice,
    /// Command that repeats the measurement of this point.
    pub command: String,
    /// Cost of the controller on the chip.
    pub cost: Cost,
    /// Cost of the whole interrupt on the chip, and its share of the processor.
    pub interrupt: Load,
    /// Errors on each test motion.
    pub courses: Vec<OnMotion>,
    /// Greatest torque error divided by its joint's limit, over all test motions; `None` if the controller braked.
    pub torque_of_limit: Option<f64>,
    /// Greatest tracking error of any joint on any test motion, rad or m; `None` if a loop ended early.
    pub tracking: Option<f64>,
    /// True if on the Pareto front of cycles and torque error: no other point needs fewer cycles with a smaller torque error.
    pub on_torque_front: bool,
    /// True if on the Pareto front of cycles and tracking error: no other point needs fewer cycles with a smaller tracking error.
    pub on_tracking_front: bool,
}

/// Result of a trade-off.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trade {
    /// Name of the scene.
    pub scene: String,
    /// Name of the robot.
    pub robot: String,
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Steps of the drives' frames, joint by joint; empty if the drives do not use frames.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub drives: Vec<DriveStep>,
    /// The test motions.
    pub courses: Vec<TestMotionReport>,
    /// The choice in the scene's own file.
    pub own: Choice,
    /// Cost of the interrupt around the controller, the same for every choice.
    pub surroundings: InterruptCost,
    /// Every choice, sorted by cycles, the fewest first.
    pub points: Vec<TradePoint>,
    /// Integrators of the simulated arm with their steps.
    pub simulator: Vec<MethodReport>,
}
