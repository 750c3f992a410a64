//! Properties of the torque and of its report.

use super::law::{SafetyProperty, Unsafe, broken};
use super::observation::{beyond, torque};
use super::{Judge, TickOutput};
use crate::campaign::machine::played;
use dynamics_core::safety::SafeAction;
use link::StateCode;
use link::{Actuation, Pacing, Status};
use session::Drives;

impl<const N: usize> Judge<N> {
    /// Command that acts on the drives, or would act outside a dry run. A dry run drives nothing; its status contains the command.
    ///
    /// # Errors
    /// [`SafetyProperty::SafeAction`] if a dry run drives its actuators.
    pub fn acts(&self, pacing: Pacing, drives: &Drives<N>, status: &Status) -> Result<Drives<N>, Unsafe> {
        match drives {
            drives if pacing == Pacing::Live => Ok(*drives),
            Drives::Safe(action) if *action == self.rules.safe_action => Ok(played(status)),
            drives => Err(Unsafe { law: SafetyProperty::SafeAction, what: format!("{drives:?} in {pacing:?}") }),
        }
    }

    /// Checks that the reported command is the actual one.
    pub(super) fn reported(&self, said: &TickOutput<N>) -> Result<(), Unsafe> {
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
        broken(
            SafetyProperty::Reported,
            format!("the drives do {:?}, reported is {:?}", said.drives, said.status.actuation),
        )
    }

    /// Checks the torque itself.
    pub(super) fn torque(&self, said: &TickOutput<N>) -> Result<(), Unsafe> {
        let state = said.status.state;
        let Some(torque) = torque(&said.drives) else {
            if matches!(
                state,
                StateCode::Armed | StateCode::Running | StateCode::Holding | StateCode::Lowering | StateCode::Disarming
            ) {
                return broken(SafetyProperty::SafeAction, format!("no torque in state {state}"));
            }
            if matches!(said.drives, Drives::Enable(_)) != (state == StateCode::Arming) {
                return broken(SafetyProperty::SafeAction, format!("{:?} in state {state}", said.drives));
            }
            return match said.drives {
                Drives::Safe(action) if action != self.rules.safe_action => {
                    broken(SafetyProperty::SafeAction, format!("{action:?} in place of {:?}", self.rules.safe_action))
                }
                _ => Ok(()),
            };
        };
        let preloads = matches!(said.drives, Drives::Preload(_));
        let engaged = matches!(state, StateCode::Arming | StateCode::Disarming);
        if preloads != engaged
            || !(engaged
                || matches!(state, StateCode::Armed | StateCode::Running | StateCode::Holding | StateCode::Lowering))
        {
            return broken(SafetyProperty::SafeAction, format!("torque in state {state}"));
        }
        if !self.homed {
            return broken(SafetyProperty::Homed, "torque, and the arm is not homed");
        }
        for i in 0..N {
            // Compared without a margin, because the limit is the machine's own f32 number.
            let (tau, limit) = (torque[i], f64::from(self.config.limits[i].torque as f32));
            let (last, step) = (self.torque.map_or(0.0, |torque| torque[i]), self.config.torque_step[i]);
            if !tau.is_finite() {
                return broken(SafetyProperty::Finite, format!("joint {}: torque {tau}", i + 1));
            }
            if tau.abs() > limit {
                return broken(SafetyProperty::Limit, format!("joint {}: torque {tau}, limit {limit}", i + 1));
            }
            if beyond((tau - last).abs(), step) {
                return broken(
                    SafetyProperty::Rate,
                    format!("joint {}: torque {tau} after {last}, step {step}", i + 1),
                );
            }
        }
        Ok(())
    }
}
