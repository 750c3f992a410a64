//! The stop key and the command `stop`: a controlled stop, and an emergency stop if it comes twice.

use super::dead_man::DeadMan;
use super::keys::Presses;
use super::rejection::Rejection;
use super::stop_demands::{Moment, StopDemands};
use super::{Operator, Stop, messages};
use crate::session::local::shared::Demanded;
use link::{Request, StateCode};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// A second stop within this time is an emergency stop, s.
const TWICE: f64 = 1.0;

/// Time in which the dead-man key must be held after a command that moves the arm.
const TAB_WAIT: Duration = Duration::from_secs(10);

impl Operator {
    /// Adds a user's stop key, which interrupts whatever the operator waits for.
    #[must_use]
    pub fn with_stop_key(self, stops: Option<Presses>) -> Self {
        let operator = Self { stops, ..self };
        let stops_seen = operator.demands();
        Self { stops_seen, ..operator }
    }

    /// The same operator with a dead-man key: motions begin and go on only while it is held.
    #[must_use]
    pub fn with_dead_man(self, key: Option<DeadMan>) -> Self {
        Self { dead_man: key, ..self }
    }

    /// True if there is a dead-man key, the arm moves, and the key is no longer held.
    pub(super) fn is_let_go(&mut self) -> bool {
        let moves = self.is_moving();
        let held = self.dead_man.as_mut().is_none_or(|key| key.is_held(Instant::now()));
        self.let_go |= moves && !held && !self.deaf;
        self.let_go
    }

    /// Waits until the dead-man key is held, if there is one. Returns false, with a message, if it is not.
    pub(super) fn dead_man_is_held(&mut self, name: &str) -> Result<bool, Stop> {
        let begun = Instant::now();
        let mut told = false;
        while let Some(key) = &mut self.dead_man {
            if key.is_held(Instant::now()) {
                break;
            }
            if begun.elapsed() > TAB_WAIT {
                return self.reject(name, "Tab was not held").map(|()| false);
            }
            if !told {
                told = true;
                self.say(name, &format!("{name}: hold Tab: the arm moves only while it is held"))?;
            }
            self.step()?;
        }
        Ok(true)
    }

    /// True if a stop was demanded, by the key or by another program, and has not been handled yet.
    pub(super) fn stop_pressed(&self) -> bool {
        !self.deaf && self.demands() != self.stops_seen
    }

    /// Number of all demands so far.
    pub(super) fn demands(&self) -> StopDemands {
        StopDemands {
            keys: self.stops.as_ref().map_or(self.stops_seen.keys, |stops| stops.load(Ordering::Relaxed)),
            others: self.shared.as_ref().map_or(self.stops_seen.others, |shared| shared.demanded()),
        }
    }

    fn now(&self) -> Moment {
        match self.is_live() || self.stops.is_some() {
            true => Moment::Wall(Instant::now()),
            false => Moment::Tick(self.status.as_ref().map_or(0, |status| status.tick)),
        }
    }

    fn since(&self, moment: Moment) -> f64 {
        match moment {
            Moment::Wall(then) => then.elapsed().as_secs_f64(),
            Moment::Tick(then) => {
                let now = self.status.as_ref().map_or(then, |status| status.tick);
                f64::from(now.wrapping_sub(then)) * self.arm.period
            }
        }
    }

    /// Stops the arm along its path and holds it there. A second stop within a second is the emergency stop.
    ///
    /// # Errors
    /// The board can no longer be used.
    pub fn stop(&mut self) -> Result<(), Stop> {
        // Read once: what comes later is handled later.
        let (now, seen) = (self.demands(), self.stops_seen);
        self.stops_seen = now;
        let let_go = core::mem::take(&mut self.let_go);
        // The command `stop` counts as a press. To let go of the dead-man key does not, nor does a stop from another program: a second person, or a button
        // that is clicked twice, must not drop the arm.
        let presses = now.keys.wrapping_sub(seen.keys);
        let by_key = presses > 0 || (now == seen && !let_go);
        let twice = presses > 1 || (by_key && self.stopped_at.is_some_and(|moment| self.since(moment) <= TWICE));
        let again = twice || now.others.emergency != seen.others.emergency;
        if by_key {
            self.stopped_at = Some(self.now());
        }
        self.stopped = true;
        self.leave_targets("a stop");
        // An emergency stop is not interrupted by further presses.
        self.deaf = true;
        let done = if again { self.stop_at_once() } else { self.stop_along_the_path() };
        self.deaf = false;
        match done {
            Err(Stop::Pressed) => self.stop(),
            Ok(answered) => {
                self.confirm_to_others(now.others, answered, again);
                Ok(())
            }
            Err(stop) => Err(stop),
        }
    }

    /// Tells other programs that their stops are handled, and whether the arm has stopped.
    fn confirm_to_others(&self, handled: Demanded, answered: bool, at_once: bool) {
        let Some(shared) = &self.shared else { return };
        let state = self.state();
        let moves = matches!(state, None | Some(StateCode::Running | StateCode::Lowering | StateCode::Arming));
        let stopped = answered && !moves && (!at_once || state == Some(StateCode::Fault));
        shared.stopped(handled, stopped.then(|| self.doing()));
    }

    /// Returns true if the board has answered.
    fn stop_along_the_path(&mut self) -> Result<bool, Stop> {
        self.announcement = Some("stop: sent");
        self.deaf = false;
        let rejection = self.request(Request::Hold)?;
        let answered = !matches!(rejection, Some(Rejection::Unconfirmed(_)));
        let text = match rejection {
            // Without a motion to stop, the message is the state.
            Some(Rejection::Denied(_)) => format!("stop: nothing to stop: {}", self.doing()),
            Some(rejection) => {
                self.refused = true;
                format!("stop: {}", messages::rejection(&rejection))
            }
            None => format!("stop: confirmed: {}", self.doing()),
        };
        self.say("stop", &text)?;
        Ok(answered)
    }

    /// Returns true if the board has answered.
    fn stop_at_once(&mut self) -> Result<bool, Stop> {
        self.announcement = Some("emergency stop: sent");
        let rejection = self.request(Request::Stop)?;
        let answered = !matches!(rejection, Some(Rejection::Unconfirmed(_)));
        self.answer("emergency stop", rejection, "")?;
        Ok(answered)
    }
}
