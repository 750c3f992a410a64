//! Laws of the torque and of its report.

use super::law::{Law, Unsafe, broken};
use super::observation::{beyond, torque};
use super::{Judge, Said};
use crate::campaign::machine::played;
use board::session::states::{ARMED, ARMING, DISARMING, HOLDING, LOWERING, RUNNING};
use dynamics_core::safety::SafeAction;
use link::{Actuation, Pacing, Status};
use session::Drives;

impl<const N: usize> Judge<N> {
    /// Command that acts on the drives, or would act outside a drill. A drill drives nothing; its status holds the
    /// command.
    ///
    /// # Errors
    /// [`Law::SafeAction`] if a drill drives its actuators.
    pub fn acts(&self, pacing: Pacing, drives: &Drives<N>, status: &Status) -> Result<Drives<N>, Unsafe> {
        match drives {
            drives if pacing == Pacing::Live => Ok(*drives),
            Drives::Safe(action) if *action == self.rules.safe_action => Ok(played(status)),
            drives => Err(Unsafe { law: Law::SafeAction, what: format!("{drives:?} in {pacing:?}") }),
        }
    }

    /// Check that the reported command is the actual one.
    pub(super) fn reported(&self, said: &Said<N>) -> Result<(), Unsafe> {
        let same = match (&said.drives, &said.status.actuation) {
            (Drives::Drive(torque), Some(Actuation::Drive { torque: reported, .. }))
            | (Drives::Preload(torque), Some(Actuation::Preload { torque: reported, .. })) => {
                reported.len() == N && torque.iter().zip(reported).all(|(a, b)| a.to_bits() == b.to_bits())
            }
            (Drives::Safe(SafeAction::Brake), Some(Actuation::Brake))
            | (Drives::Safe(SafeAction::DampedStop), Some(Actuation::DampedStop))
            | (Drives::Safe(SafeAction::Off), Some(Actuation::Off))
            | (Drives::Enable(_), Some(Actuation::Enable)) => true,
            _ => false,
        };
        if same {
            return Ok(());
        }
        broken(Law::Reported, format!("the drives do {:?}, reported is {:?}", said.drives, said.status.actuation))
    }

    /// Check the torque itself.
    pub(super) fn torque(&self, said: &Said<N>) -> Result<(), Unsafe> {
        let state = said.status.state;
        let Some(torque) = torque(&said.drives) else {
            if matches!(state, ARMED | RUNNING | HOLDING | LOWERING | DISARMING) {
                return broken(Law::SafeAction, format!("no torque in state {state}"));
            }
            if matches!(said.drives, Drives::Enable(_)) != (state == ARMING) {
                return broken(Law::SafeAction, format!("{:?} in state {state}", said.drives));
            }
            return match said.drives {
                Drives::Safe(action) if action != self.rules.safe_action => {
                    broken(Law::SafeAction, format!("{action:?} in place of {:?}", self.rules.safe_action))
                }
                _ => Ok(()),
            };
        };
        let preloads = matches!(said.drives, Drives::Preload(_));
        let engaged = matches!(state, ARMING | DISARMING);
        if preloads != engaged || !(engaged || matches!(state, ARMED | RUNNING | HOLDING | LOWERING)) {
            return broken(Law::SafeAction, format!("torque in state {state}"));
        }
        if !self.homed {
            return broken(Law::Homed, "torque, and the arm is not homed");
        }
        for i in 0..N {
            // Compared bit by bit: the limit is the machine's own number.
            let (tau, limit) = (torque[i], f64::from(self.config.limits[i].torque as f32));
            let (last, step) = (self.torque.map_or(0.0, |torque| torque[i]), self.config.torque_step[i]);
            if !tau.is_finite() {
                return broken(Law::Finite, format!("joint {}: torque {tau}", i + 1));
            }
            if tau.abs() > limit {
                return broken(Law::Limit, format!("joint {}: torque {tau}, limit {limit}", i + 1));
            }
            if beyond((tau - last).abs(), step) {
                return broken(Law::Rate, format!("joint {}: torque {tau} after {last}, step {step}", i + 1));
            }
        }
        Ok(())
    }
}
