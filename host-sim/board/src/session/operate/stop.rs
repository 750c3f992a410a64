//! The stop key and the command `stop`: a controlled stop, and an emergency stop if it comes twice.

use super::keys::Presses;
use super::moment::Moment;
use super::rejection::Rejection;
use super::{Operator, Stop, messages};
use link::Request;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// A second stop within this time is an emergency stop, s.
const TWICE: f64 = 1.0;

impl Operator {
    /// Adds a user's stop key, which interrupts whatever the operator waits for.
    #[must_use]
    pub fn with_stop_key(self, stops: Option<Presses>) -> Self {
        let stops_seen = stops.as_ref().map_or(0, |stops| stops.load(Ordering::Relaxed));
        Self { stops, stops_seen, ..self }
    }

    /// True if the stop key was pressed and this has not been handled yet.
    pub(super) fn stop_pressed(&self) -> bool {
        !self.deaf && self.presses_of_stop() != self.stops_seen
    }

    fn presses_of_stop(&self) -> u32 {
        self.stops.as_ref().map_or(self.stops_seen, |stops| stops.load(Ordering::Relaxed))
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
        let presses = self.presses_of_stop().wrapping_sub(self.stops_seen);
        self.stops_seen = self.presses_of_stop();
        let again = presses > 1 || self.stopped_at.is_some_and(|moment| self.since(moment) <= TWICE);
        self.stopped_at = Some(self.now());
        self.stopped = true;
        // An emergency stop is not interrupted by further presses.
        self.deaf = true;
        let done = if again { self.stop_at_once() } else { self.stop_along_the_path() };
        self.deaf = false;
        match done {
            Err(Stop::Pressed) => self.stop(),
            other => other,
        }
    }

    fn stop_along_the_path(&mut self) -> Result<(), Stop> {
        self.announcement = Some("stop: sent");
        self.deaf = false;
        let rejection = self.request(Request::Hold)?;
        let text = match rejection {
            // Without a motion to stop, the message is the state.
            Some(Rejection::Denied(_)) => format!("stop: nothing to stop: {}", self.doing()),
            Some(rejection) => {
                self.refused = true;
                format!("stop: {}", messages::rejection(&rejection))
            }
            None => format!("stop: confirmed: {}", self.doing()),
        };
        self.say("stop", &text)
    }

    fn stop_at_once(&mut self) -> Result<(), Stop> {
        self.announcement = Some("emergency stop: sent");
        let rejection = self.request(Request::Stop)?;
        self.answer("emergency stop", rejection, "")
    }
}
