//! An explanation of a log by faults.

use super::Fault;
use crate::correction::Correction;
use crate::evidence::Score;
use nalgebra::Vector3;

/// Additional score that a second fault must bring, beyond its own cost, nats.
const SECOND: f64 = 8.0;

/// Largest share of a joint's torque that one fault, and two faults, may leave unexplained. With more, no fault explains the log. For example,
/// stiction in a slow log leaves strongly correlated residuals, and an unlikely fault always lowers them.
const LEFT: [f64; 2] = [0.2, 0.1];

/// One or two faults, and the correction of the log that undoes them.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// The faults.
    pub faults: Vec<Fault>,
    /// Correction of the log: signs, scales, order and delay.
    pub correction: Correction,
    /// Gravity in the base frame, m/s^2.
    pub gravity: Vector3<f64>,
    /// Score of the corrected log.
    pub score: Score,
}

impl Explanation {
    /// True if the unexplained share of every joint's torque is small.
    pub(super) fn explains(&self) -> bool {
        let most = LEFT[usize::from(self.faults.len() > 1)];
        self.score.left.iter().all(|left| *left <= most)
    }

    /// Score minus the cost of the faults, nats.
    #[must_use]
    pub fn worth(&self) -> f64 {
        let more = self.faults.len().saturating_sub(1) as f64;
        self.score.nats - self.faults.iter().map(Fault::cost).sum::<f64>() - SECOND * more
    }
}
