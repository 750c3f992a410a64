//! A tick inside a machine that observes the joints and holds the torques.

use super::collision::Protection;
use super::config::{Configuration, ControllerConfig};
use super::limits::{LimitFlags, bound_torques, hold_torques};
use super::{Command, Controller, Fault, Reference};
use crate::newton_euler::InverseDynamics;
use crate::scalar::Real;
use crate::trig::Trig;

/// Inputs of a law in one tick, from the machine around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ask<'a, S, const N: usize> {
    /// Torque acts for the first time, or with engaged brakes: forget the state before.
    pub start: bool,
    /// The rate of the torque is not limited in this tick: the first torque of an arm without brakes.
    pub at_once: bool,
    /// The reference in force: the host's, or that of a stop. The machine has held it to its limits.
    pub reference: &'a Reference<S, N>,
    /// One comparison a rule was enough in this tick, as in nearly every one of a running arm. No controller needs to know.
    pub ordinary: bool,
    /// Share of the torque limit that may act beyond the weight; `None` for all of it. In the first motion after homing, and while a
    /// motor is warm. [`Ask::of`] and [`Ask::near_weight`] hold to it.
    pub beyond_weight: Option<S>,
    /// True if the arm runs: a law that follows no reference lets go of it.
    pub runs: bool,
    /// Joint position that the machine has observed and judged, rad or m.
    pub q: &'a [S; N],
    /// Joint velocity, likewise, rad/s or m/s.
    pub qd: &'a [S; N],
    /// The torque that has acted since the last tick, N m or N; zero at the start.
    pub torque: &'a [S; N],
    /// Limits that acted on it.
    pub limits: &'a [LimitFlags; N],
}

impl<S: Real, const N: usize> Ask<'_, S, N> {
    /// The answer of a controller; its torques are held by the machine.
    #[inline]
    pub fn of<D, T, C, P>(self, controller: &mut Controller<S, N, D, T, C, P>) -> Command<S, N>
    where
        D: InverseDynamics<S, N> + Clone,
        T: Trig<S> + Clone,
        C: Configuration<S, N> + Clone,
        P: Protection<S, N> + Clone,
    {
        let (mut torque, mut limits) = ([S::zero(); N], [LimitFlags::NONE; N]);
        let mut answer = controller.answer(&self, &mut torque, &mut limits);
        if let Some(share) = self.beyond_weight {
            answer = answer.and_then(|()| self.near_weight(share, controller, &mut torque, &mut limits));
        }
        match answer {
            Ok(()) => Command::Drive { torque, limits },
            Err(fault) => Command::Brake(fault),
        }
    }

    /// Hold an answer near the weight of the arm: `|tau - tau_0| <= share * limit`.
    ///
    /// `tau_0` is the torque that the same controller gives for an arm at rest here, with no error: the weight, and the live wrench.
    /// Cost: a second answer. Out of line: nearly every tick does without.
    ///
    /// # Errors
    /// The controller's, for an arm at rest here.
    #[cold]
    #[inline(never)]
    pub fn near_weight<D, T, C, P>(
        &self,
        share: S,
        controller: &Controller<S, N, D, T, C, P>,
        torque: &mut [S; N],
        limits: &mut [LimitFlags; N],
    ) -> Result<(), Fault>
    where
        D: InverseDynamics<S, N> + Clone,
        T: Trig<S> + Clone,
        C: Configuration<S, N> + Clone,
        P: Protection<S, N> + Clone,
    {
        let (reference, still) = (Reference::at_rest(*self.q), [S::zero(); N]);
        let at_rest = Ask { start: true, reference: &reference, runs: false, qd: &still, ..*self };
        let mut weight = still;
        controller.clone().answer(&at_rest, &mut weight, &mut [LimitFlags::NONE; N])?;
        for i in 0..N {
            let most = share * controller.config().limits[i].torque;
            let near = torque[i].clamp_to(weight[i] - most, weight[i] + most);
            limits[i] |= LimitFlags::TORQUE.when(near != torque[i]);
            // A torque that is no number is named where torques are held.
            if torque[i].is_finite() {
                torque[i] = near;
            }
        }
        Ok(())
    }

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
