//! Arming and disarming.
//!
//! Arming: the drives come on, then carry the arm's weight, and only then the brakes open.
//!
//! 1. Every drive is switched on, with engaged brakes, until each has shown that it is on ([`Inputs::on`](super::Inputs::on)).
//! 2. An arm with brakes: with engaged brakes, torque rises at its rate to the torque that gravity needs. Then the brakes open.
//! 3. An arm without brakes: nothing carries it while torque rises. So its first torque is the whole torque that gravity needs, at once.
//!
//! Disarming an arm with brakes: the brakes lose their power, and torque goes on until they have engaged ([`Rules::brake_delay`]). The machine
//! does the same before it raises the fault if the host is gone, a motor is too hot, or lowering has waited for too long. Any other fault
//! removes the torque at once: the data from which the torque is computed, or the drive that gives it, can no longer be trusted.

use super::measured::astray;
use super::memory::{Action, Arming, Decision, MachineMemory, Now};
use super::{Request, Rules, SafeAction, State};
use crate::control::{Fault, Reference};
use crate::scalar::Real;

/// Number of ticks for which the drives carry the whole weight before the brakes open. Some drives show only by their torque that they are
/// on; they have shown it by then.
pub(super) const CARRIED_MIN: u32 = 8;

/// Longest time of arming with torque on engaged brakes, as a multiple of [`Rules::arming_max`]: the torque has to rise at its rate.
const PRELOAD_TIMES: u32 = 4;

impl<S: Real, const N: usize> MachineMemory<S, N> {
    /// One tick of arming, after its request. `judged` is the fault of the readings.
    #[cold]
    #[inline(never)]
    pub(super) fn arming(&mut self, now: &Now<'_, S, N>, judged: Option<Fault>, rules: &Rules<S, N>) -> Decision {
        let Now { inputs, seen, silent, .. } = *now;
        if silent {
            self.state = State::Idle;
            return Decision::safe(None);
        }
        // A joint jumped while another one's reading was missing.
        if !self.homed {
            return self.fail(judged.unwrap_or(Fault::ZeroLost), inputs.request);
        }
        let first = self.arming.ticks == 0;
        let in_time = self.arming.ticks < rules.arming_max;
        self.arming.ticks = self.arming.ticks.saturating_add(1);
        let off = inputs.on.iter().position(|on| !*on).map(|joint| joint as u8);
        if self.arming.preloads {
            // True if the brakes slip.
            let astray = astray(&self.reference, seen, rules, S::one()).map(|joint| Fault::FollowingError { joint });
            if let Some(fault) = off.map(|joint| Fault::DriveOff { joint }).or(judged).or(astray) {
                return self.fail(fault, inputs.request);
            }
            if self.arming.ticks > rules.arming_max.saturating_mul(PRELOAD_TIMES) {
                let restless = seen.fast(rules).map(|joint| Fault::FollowingError { joint });
                return self.fail(restless.unwrap_or(Fault::StaleMeasurement), inputs.request);
            }
            // A missing reading may come from a drive that has just switched off: the brakes open only if no reading is missing.
            let complete = inputs.age_ticks.iter().all(|age| *age == 0);
            if !seen.at_rest(rules) {
                self.arming.carried = 0;
            } else if complete && self.arming.carried >= CARRIED_MIN {
                self.state = State::Armed;
                return Decision::of(Action::Drive);
            }
            return Decision::of(Action::Preload);
        }
        // A drive may miss a reading while it is switched on.
        let hindrance = match judged {
            Some(Fault::StaleMeasurement) => Some(Fault::StaleMeasurement),
            Some(fault) => return self.fail(fault, inputs.request),
            None if !self.sensors.fresh => Some(Fault::StaleMeasurement),
            None => seen.fast(rules).map(|joint| Fault::FollowingError { joint }),
        };
        match off.map(|joint| Fault::DriveNotOn { joint }).or(hindrance) {
            Some(fault) if !in_time => self.fail(fault, inputs.request),
            Some(_) => Decision::of(if first { Action::EnableFirst } else { Action::Enable }),
            None => {
                self.reference = Reference::at_rest(*seen.q);
                if rules.safe_action == SafeAction::Brake {
                    self.arming.preloads = true;
                    return Decision::of(Action::Preload);
                }
                self.state = State::Armed;
                Decision::of(Action::DriveAtOnce)
            }
        }
    }

    /// Begins to disarm an arm at rest. Without brakes, or with brakes that engage at once, the arm is idle immediately.
    #[cold]
    #[inline(never)]
    pub(super) fn disarm(&mut self, rules: &Rules<S, N>) {
        (self.state, self.along, self.ends_in) = (State::Idle, false, None);
        if rules.brake_delay != 0 {
            (self.state, self.arming) = (State::Disarming, Arming::START);
        }
    }

    /// Ends torque because of a fault that leaves readings and drives trustworthy. Returns true if torque ends in this tick: the brakes engage at
    /// once, are already engaged, or do not exist.
    pub(super) fn let_go(&mut self, fault: Fault, rules: &Rules<S, N>) -> bool {
        let arms = self.state == State::Arming;
        self.disarm(rules);
        self.ends_in = Some(fault);
        arms || self.state == State::Idle
    }

    /// Begins to arm.
    pub(super) fn begin_arming(&mut self, q: &[S; N]) {
        (self.state, self.arming) = (State::Arming, Arming::START);
        self.reference = Reference::at_rest(*q);
    }

    /// True if this request ends arming.
    pub(super) const fn ends_arming(request: Request) -> bool {
        matches!(request, Request::Disarm | Request::Hold)
    }
}
