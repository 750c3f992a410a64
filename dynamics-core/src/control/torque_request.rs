//! Inputs of a tick inside the safety state machine, which observes the joints and limits the torques.

use super::config::ControllerConfig;
use super::limits::{LimitFlags, bound_torques, hold_torques};
use super::{Fault, Reference};
use crate::scalar::Real;

/// Inputs of a control law in one tick, from the safety state machine around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueRequest<'a, S, const N: usize> {
    /// True if torque acts for the first time, or with engaged brakes: the controller clears its memory first.
    pub start: bool,
    /// The rate of the torque is not limited in this tick: the first torque of an arm without brakes.
    pub at_once: bool,
    /// The reference in force: the host's, or that of a stop. The machine has applied its limits.
    pub reference: &'a Reference<S, N>,
    /// True if the tick was ordinary: one comparison a rule was enough, as in nearly every tick of a running arm. No controller depends on it.
    pub ordinary: bool,
    /// Share of the torque limit that may act beyond the weight; `None` for all of it. Set in the first motion after homing, and while a
    /// motor is warm. [`TorqueRequest::of`] and [`TorqueRequest::near_weight`] apply it.
    pub beyond_weight: Option<S>,
    /// True if the arm runs: a law that follows no reference frees the joints then.
    pub is_running: bool,
    /// Joint position that the machine has observed and judged, rad or m.
    pub q: &'a [S; N],
    /// Joint velocity that the machine has observed and judged, rad/s or m/s.
    pub qd: &'a [S; N],
    /// The torque that has acted since the last tick, N m or N; zero at the start.
    pub torque: &'a [S; N],
    /// Limits that acted on that torque.
    pub limits: &'a [LimitFlags; N],
}

impl<S: Real, const N: usize> TorqueRequest<'_, S, N> {
    /// Limits a torque to the torque limits and to the allowed change from the torque that acts, as the machine does.
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
