//! Laws of the faults: no torque acts under a fault, each fault is named, and a standing fault cannot be cleared.

use super::law::{Law, Unsafe, broken};
use super::observation::Seen;
use super::observation::torque;
use super::{Heard, Judge, Said, Told};
use board::session::states::{ARMED, ARMING, DISARMING, FAULT, HOLDING, HOMING, IDLE, LOWERING, RUNNING};
use link::Request;

/// Faults that a board raises in every state, in order of priority.
const BOARD: [u8; 5] = [9, 6, 11, 12, 13];

impl<const N: usize> Judge<N> {
    /// Codes of the board's faults, in order of priority.
    pub(super) fn board(&self, told: &Told<N>) -> Vec<u8> {
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

    /// Check that no torque acts under a fault, that each fault is named, and that a standing fault is not cleared.
    pub(super) fn faults(&self, board: &[u8], seen: &Seen<N>, heard: &Heard<'_>, said: &Said<N>) -> Result<(), Unsafe> {
        let status = &said.status;
        let (before, now) = (self.before.0, status.state);
        let drove = matches!(before, ARMED | RUNNING | HOLDING | LOWERING | DISARMING);
        let all = || board.iter().chain(&seen.faults);
        if let Some(code) = all().next()
            && (torque(&said.drives).is_some() || (drove && now != FAULT))
        {
            return broken(Law::Fault, format!("state {now} in spite of fault {code}"));
        }
        if let Some(first) = board.first() {
            if now != FAULT {
                return broken(Law::Fault, format!("state {now} in spite of fault {first}"));
            }
            if before != FAULT && status.cause != *first {
                return broken(Law::Named, format!("fault {} in place of {first}", status.cause));
            }
        }
        if before != FAULT && now == FAULT {
            let cause = status.cause;
            let there = match cause {
                1 | 3 => seen.faults.contains(&cause),
                9 if heard.requests.contains(&Request::Stop) => true,
                cause => !BOARD.contains(&cause) || board.contains(&cause),
            };
            if !there {
                return broken(Law::Named, format!("fault {cause} out of nothing"));
            }
        }
        let starts =
            (before == IDLE && matches!(now, ARMING | ARMED)) || (before == HOMING && now == IDLE && status.homed);
        let cleared = (before, now) == (FAULT, IDLE);
        // Without a known zero a position has no meaning.
        let stands = seen.faults.iter().find(|code| !cleared || **code != 4 || status.homed);
        if (cleared || starts)
            && let Some(code) = stands
        {
            return broken(Law::Latched, format!("state {before} to {now} while fault {code} stands"));
        }
        let disarmed = heard.requests.contains(&Request::Disarm) && matches!(before, ARMED | HOLDING);
        let ends = disarmed && matches!(now, IDLE | DISARMING);
        if seen.moves && (cleared || starts || ends) {
            return broken(Law::Transition, format!("state {before} to {now} in motion"));
        }
        Ok(())
    }
}
