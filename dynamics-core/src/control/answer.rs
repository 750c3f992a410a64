//! Torques of a controller for a request of the safety state machine.

use super::build::ArmBuild;
use super::limits::LimitFlags;
use super::torque_request::TorqueRequest;
use super::{Command, Controller, Fault, Reference};
use crate::scalar::Real;

impl<S: Real, const N: usize> TorqueRequest<'_, S, N> {
    /// Returns the controller's command for this request. The machine applies the torque limits to it.
    #[inline]
    pub fn of<A: ArmBuild<S, N>>(self, controller: &mut Controller<S, N, A>) -> Command<S, N> {
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

    /// Limits the torques to a band around the weight of the arm: `|tau - tau_0| <= share * limit`.
    ///
    /// `tau_0` is the torque that the same controller gives for an arm at rest here, with no error: the weight, and the live wrench.
    /// Cost: a second torque computation. Out of line, because nearly every tick does without it.
    ///
    /// # Errors
    /// The controller's, for an arm at rest here.
    #[cold]
    #[inline(never)]
    pub fn near_weight<A: ArmBuild<S, N>>(
        &self,
        share: S,
        controller: &Controller<S, N, A>,
        torque: &mut [S; N],
        limits: &mut [LimitFlags; N],
    ) -> Result<(), Fault> {
        let (reference, still) = (Reference::at_rest(*self.q), [S::zero(); N]);
        let at_rest = TorqueRequest { start: true, reference: &reference, is_running: false, qd: &still, ..*self };
        let mut weight = still;
        controller.clone().answer(&at_rest, &mut weight, &mut [LimitFlags::NONE; N])?;
        for i in 0..N {
            let most = share * controller.config().limits[i].torque;
            let near = torque[i].clamp_to(weight[i] - most, weight[i] + most);
            limits[i] |= LimitFlags::TORQUE.when(near != torque[i]);
            // Where the torque limits are applied, a torque that is NaN or infinite is reported.
            if torque[i].is_finite() {
                torque[i] = near;
            }
        }
        Ok(())
    }
}
