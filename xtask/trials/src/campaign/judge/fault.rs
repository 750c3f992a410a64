//! Properties of faults: no torque acts under a fault, each fault is reported with its code, and a fault cannot be cleared while its cause persists.

use super::law::{SafetyProperty, Unsafe, broken};
use super::observation::ReadingFaults;
use super::observation::torque;
use super::{Heard, Judge, TickInputs, TickOutput};
use link::Request;
use link::StateCode;

/// Faults that a board raises in every state, in order of priority.
const BOARD: [u8; 5] = [9, 6, 11, 12, 13];

impl<const N: usize> Judge<N> {
    /// Codes of the board's faults, in order of priority.
    pub(super) fn board(&self, told: &TickInputs<N>) -> Vec<u8> {
        let outside = |value: Option<f32>, (low, high): (f64, f64)| {
            value.map(f64::from).is_some_and(|x| x.is_nan() || x < low || x > high)
        };
        [
            (9, told.emergency_stop),
            (6, told.overrun),
            (11, told.drive_fault.contains(&true)),
            (12, outside(told.supply, self.rules.supply)),
            (13, outside(told.temperature, self.rules.temperature)),
        ]
        .into_iter()
        .filter_map(|(code, wrong)| wrong.then_some(code))
        .collect()
    }

    /// Checks that no torque acts under a fault, that each fault is reported, and that a persisting fault is not cleared.
    pub(super) fn faults(
        &self,
        board: &[u8],
        seen: &ReadingFaults<N>,
        heard: &Heard<'_>,
        said: &TickOutput<N>,
    ) -> Result<(), Unsafe> {
        let status = &said.status;
        let (before, now) = (self.before.0, status.state);
        let drove = matches!(
            before,
            StateCode::Armed | StateCode::Running | StateCode::Holding | StateCode::Lowering | StateCode::Disarming
        );
        let all = || board.iter().chain(&seen.faults);
        if let Some(code) = all().next()
            && (torque(&said.drives).is_some() || (drove && now != StateCode::Fault))
        {
            return broken(SafetyProperty::Fault, format!("state {now} in spite of fault {code}"));
        }
        if let Some(first) = board.first() {
            if now != StateCode::Fault {
                return broken(SafetyProperty::Fault, format!("state {now} in spite of fault {first}"));
            }
            if before != StateCode::Fault && status.cause != *first {
                return broken(SafetyProperty::Named, format!("fault {} in place of {first}", status.cause));
            }
        }
        if before != StateCode::Fault && now == StateCode::Fault {
            let cause = status.cause;
            let there = match cause {
                1 | 3 => seen.faults.contains(&cause),
                9 if heard.requests.contains(&Request::Stop) => true,
                cause => !BOARD.contains(&cause) || board.contains(&cause),
            };
            if !there {
                return broken(SafetyProperty::Named, format!("fault {cause} out of nothing"));
            }
        }
        let starts = (before == StateCode::Idle && matches!(now, StateCode::Arming | StateCode::Armed))
            || (before == StateCode::Homing && now == StateCode::Idle && status.homed);
        let cleared = (before, now) == (StateCode::Fault, StateCode::Idle);
        // Without a known zero a position has no meaning.
        let stands = seen.faults.iter().find(|code| !cleared || **code != 4 || status.homed);
        if (cleared || starts)
            && let Some(code) = stands
        {
            return broken(SafetyProperty::Latched, format!("state {before} to {now} while fault {code} stands"));
        }
        let disarmed =
            heard.requests.contains(&Request::Disarm) && matches!(before, StateCode::Armed | StateCode::Holding);
        let ends = disarmed && matches!(now, StateCode::Idle | StateCode::Disarming);
        if seen.moves && (cleared || starts || ends) {
            return broken(SafetyProperty::Transition, format!("state {before} to {now} in motion"));
        }
        Ok(())
    }
}
