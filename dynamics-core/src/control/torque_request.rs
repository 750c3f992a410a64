//! Inputs of a tick inside a machine that observes the joints and holds the torques.

use super::config::ControllerConfig;
use super::limits::{LimitFlags, bound_torques, hold_torques};
use super::{Fault, Reference};
use crate::scalar::Real;

/// Inputs of a law in one tick, from the machine around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueRequest<'a, S, const N: usize> {
    /// Torque acts for the first time, or with engaged brakes: forget the state before.
    pub start: bool,
    /// The rate of the torque is not limited in this tick: the first torque of an arm without brakes.
    pub at_once: bool,
    /// The reference in force: the host's, or that of a stop. The machine has held it to its limits.
    pub reference: &'a Reference<S, N>,
    /// One comparison a rule was enough in this tick, as in nearly every one of a running arm. No controller needs to know.
    pub ordinary: bool,
    /// Share of the torque limit that may act beyond the weight; `None` for all of it. In the first motion after homing, and while a
    /// motor is warm. [`TorqueRequest::of`] and [`TorqueRequest::near_weight`] hold to it.
    pub beyond_weight: Option<S>,
    /// True if the arm runs: a law that follows no reference lets go of it.
    pub is_running: bool,
    /// Joint position that the machine has observed and judged, rad or m.
    pub q: &'a [S; N],
    /// Joint velocity, likewise, rad/s or m/s.
    pub qd: &'a [S; N],
    /// The torque that has acted since the last tick, N m or N; zero at the start.
    pub torque: &'a [S; N],
    /// Limits that acted on it.
    pub limits: &'a [LimitFlags; N],
}

impl<S: Real, const N: usize> TorqueRequest<'_, S, N> {
    /// Hold an answer inside the torque limits and near the torque that acts, as the machine does.
    ///
    /// # Errors
    /// [`Fault::NonFiniteTorque`] for a torque that is NaN or infinite.
    #[inline]
    pub fn hold(
        &self,
        config: &ControllerConfig<S, N>,
        torque: &mut [S; N],
        limits: &mut [LimitFlags; N],
    ) -> Result<(), Fault> {
        if self.at_once {
            return bound_torques(torque, limits, &config.limits);
        }
        let step = &config.torque_step;
        hold_torques(torque, limits, &config.limits, self.torque, step, step)
    }
}
