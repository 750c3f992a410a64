//! The answer of a controller to what a machine asks.

use super::ask::Ask;
use super::collision::Protection;
use super::config::Configuration;
use super::limits::LimitFlags;
use super::{Command, Controller, Fault, Reference};
use crate::newton_euler::InverseDynamics;
use crate::scalar::Real;
use crate::trig::Trig;

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
}
