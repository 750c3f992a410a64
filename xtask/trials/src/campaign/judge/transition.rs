//! Properties of the states: allowed transitions, and the host's part in them.

use super::law::{SafetyProperty, Unsafe, broken};
use super::observation::torque;
use super::{Heard, Judge, TickInputs, TickOutput};
use board::session::states;
use dynamics_core::safety::Rules;
use link::StateCode;
use link::{Request, Status};

impl<const N: usize> Judge<N> {
    /// Checks the transitions between states, including those that need homing.
    pub(super) fn moved(&mut self, told: &TickInputs<N>, heard: &Heard<'_>, status: &Status) -> Result<(), Unsafe> {
        let asked = |request| heard.requests.contains(&request);
        let (before, now) = (self.before.0, status.state);
        if before == StateCode::Fault && now == StateCode::Fault && status.cause != self.before.1 {
            return broken(SafetyProperty::Latched, format!("fault {} became fault {}", self.before.1, status.cause));
        }
        let allowed = states::may_lead(self.before, status, asked);
        if !allowed && before == StateCode::Fault {
            return broken(SafetyProperty::Latched, format!("fault {} was left for state {now}", self.before.1));
        }
        if !allowed {
            return broken(
                SafetyProperty::Transition,
                format!("state {before} to {now}, cause {}, asked for {:?}", status.cause, heard.requests),
            );
        }
        match (before, now) {
            (StateCode::Idle, StateCode::Homing) => self.homed = false,
            (StateCode::Homing, StateCode::Idle) if status.homed => self.homed = asked(Request::Confirm) && told.zeroed,
            _ => {}
        }
        if status.homed && !self.homed {
            return broken(SafetyProperty::Homed, "it takes itself for homed, and is not");
        }
        // If the machine has cancelled its homing, the homing must not come back.
        self.homed = status.homed;
        if heard.exact { self.answered(heard, status) } else { Ok(()) }
    }

    /// Checks the answer: a request is accepted or refused.
    fn answered(&self, heard: &Heard<'_>, status: &Status) -> Result<(), Unsafe> {
        let (before, now) = (self.before.0, status.state);
        let settles = |request: &Request| match request {
            // These requests change nothing that a status shows.
            Request::FullRange => true,
            Request::Stop => now == StateCode::Fault,
            _ => false,
        };
        match (heard.requests.last(), &status.refused) {
            (None, Some(refused)) => broken(SafetyProperty::Answered, format!("nothing was asked for: {refused:?}")),
            (Some(request), None) if before == now && !settles(request) => {
                broken(SafetyProperty::Answered, format!("{request:?} in state {before} did nothing"))
            }
            (Some(request), Some(_))
                if now != before
                    && now != StateCode::Fault
                    && now != StateCode::Holding
                    && !matches!(before, StateCode::Arming | StateCode::Disarming) =>
            {
                broken(SafetyProperty::Answered, format!("{request:?} was refused, and led from {before} to {now}"))
            }
            _ => Ok(()),
        }
    }

    /// Checks that torque continues for exactly as long as the brakes need, after a request and after the loss of the host.
    pub(super) fn disarmed(&mut self, heard: &Heard<'_>, status: &Status) -> Result<(), Unsafe> {
        let (before, now, delay) = (self.before.0, status.state, self.rules.brake_delay);
        let drove = matches!(before, StateCode::Armed | StateCode::Running | StateCode::Holding | StateCode::Lowering);
        let lost = now == StateCode::Fault && matches!(status.cause, 10 | 20);
        let asked =
            matches!(before, StateCode::Armed | StateCode::Holding) && heard.requests.contains(&Request::Disarm);
        if drove && (now == StateCode::Idle || lost) && delay > 0 {
            return broken(
                SafetyProperty::Disarmed,
                format!("state {before} to {now}: the brakes need {delay} ticks to engage"),
            );
        }
        if drove && now == StateCode::Disarming {
            (self.disarms, self.lost) = (0, !asked);
            // An overheated motor also causes disarming.
            let cool = self.rules.heat.is_none();
            if !asked && heard.exact && cool && self.silent <= self.rules.heartbeat_max {
                return broken(SafetyProperty::Disarmed, format!("after {} ticks without the host", self.silent));
            }
        }
        if now == StateCode::Disarming {
            self.disarms += 1;
        }
        if self.disarms > delay && now == StateCode::Disarming {
            return broken(
                SafetyProperty::Disarmed,
                format!("torque for {} ticks, the brakes need {delay}", self.disarms),
            );
        }
        if before == StateCode::Disarming
            && (now == StateCode::Idle || lost)
            && (self.disarms != delay || (lost != self.lost && heard.exact))
        {
            let what = format!("state {now} after {} ticks of {delay}, asked for: {}", self.disarms, !self.lost);
            return broken(SafetyProperty::Disarmed, what);
        }
        Ok(())
    }

    /// Checks the reaction to a silent host.
    pub(super) fn silence(&self, heard: &Heard<'_>, said: &TickOutput<N>) -> Result<(), Unsafe> {
        let Rules { heartbeat_max, hold_max, .. } = self.rules;
        let (state, silent) = (said.status.state, self.silent);
        if silent > heartbeat_max && matches!(state, StateCode::Armed | StateCode::Running) {
            return broken(SafetyProperty::Silence, format!("state {state} after {silent} ticks without the host"));
        }
        // An arm with a rest pose is lowered instead of released. The torque of disarming is checked separately.
        let lowered = (self.rules.rest.is_some() && state == StateCode::Lowering) || state == StateCode::Disarming;
        if silent > heartbeat_max.saturating_add(hold_max) && torque(&said.drives).is_some() && !lowered {
            return broken(SafetyProperty::Silence, format!("torque after {silent} ticks without the host"));
        }
        let lost = self.before.0 != StateCode::Fault && state == StateCode::Fault && said.status.cause == 10;
        if heard.exact && lost && self.before.0 != StateCode::Disarming && silent <= heartbeat_max {
            return broken(SafetyProperty::Silence, format!("fault 10 after {silent} ticks without the host"));
        }
        Ok(())
    }
}
