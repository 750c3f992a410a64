//! Time and requests of a session: the interval of the board's reports, waiting, arming and disarming.

use super::device::{DeviceError, SILENCE};
use super::rejection::Rejection;
use super::requests::name_of;
use super::step::has_taken;
use super::{Operator, Stop};
use crate::chip::ChipError;
use dynamics_core::safety::HoldCause;
use link::{Denial, Frame, Parts, Request, StateCode, Watch};
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Statuses per second shown to a user when not every tick is needed.
const SHOWN: f64 = 50.0;

/// Time limit for the arm to come to rest before it is disarmed, and the interval of the checks, s.
const REST: f64 = 10.0;
const LOOK: f64 = 0.05;

/// Speed below which an arm counts as at rest before its control law is changed, rad/s or m/s.
const STILL: f64 = 0.05;

/// Parts of a board's report that a replay needs.
pub(super) const PARTS: Parts = Parts::SENSED.and(Parts::TORQUE).and(Parts::EXTERNAL);

/// [`dynamics_core::safety::Refusal::NotAtRest`].
const NOT_AT_REST: u8 = 6;

impl Operator {
    /// Interval of the board's reports that is needed now, in ticks.
    pub(super) fn needed(&mut self) -> u16 {
        if self.device.tap().is_recording() || self.following.is_some() {
            return 1;
        }
        let shown = (1.0 / (SHOWN * self.arm.period)).max(1.0) as u16;
        match u16::try_from(self.print.0) {
            Ok(every @ 1..) => shown.min(every),
            _ => shown,
        }
    }

    /// Sets the interval of the board's reports, in ticks. A dry run reports every tick anyway.
    pub(super) fn watch(&mut self, every: u16) -> Result<(), Stop> {
        if !self.is_live() || self.watched == every {
            return Ok(());
        }
        self.watched = every;
        let parts = self.parts(every);
        self.send(&Frame::Watch(Watch { every, parts }))
    }

    /// Sets the interval that is needed now.
    pub(super) fn watch_as_needed(&mut self) -> Result<(), Stop> {
        let needed = self.needed();
        self.watch(needed)
    }

    /// Parts of the reports at this interval. They include the reference if the link has time for it, and if the board estimates no external torques,
    /// which would take the same field.
    pub(super) fn parts(&mut self, every: u16) -> Parts {
        let has_time = every > 1 && !self.device.tap().is_recording();
        if has_time && !self.arm.estimates { PARTS.and(Parts::REFERENCE) } else { PARTS }
    }

    /// Lets time pass until the board has taken the last frame sent.
    pub(super) fn until_taken(&mut self) -> Result<(), Stop> {
        let sent = self.device.tap().sent();
        let end = self.device.now() + SILENCE;
        while !self.status.as_ref().is_some_and(|status| has_taken(status, sent)) {
            if self.device.now() > end {
                return Err(DeviceError::Silent { what: "answer to a request", time: SILENCE }.into());
            }
            self.pass()?;
        }
        Ok(())
    }

    pub(super) fn ask(&mut self, request: Request) -> Result<(), Stop> {
        let name = name_of(request);
        if matches!(request, Request::Hold | Request::Disarm) {
            // Whatever the link does to the request, no further target is followed.
            self.end_targets("the operator has entered another command");
        }
        if request == Request::Arm && self.is_live() {
            if self.resumed && !self.learn_payload()? {
                return self.reject(
                    name,
                    "the controller does not report the payload that it holds; declare it with `payload`",
                );
            }
            // The live inputs of the hello may have been lost.
            let live = self.arm.model.live(self.arm.payload).map_err(ChipError::from)?;
            self.send_surely(&Frame::Live(live))?;
        }
        let denial = if request == Request::Disarm { self.disarm()? } else { self.request(request)? };
        if request == Request::Hold
            && let (Some(Rejection::Denied(_)), Some(status)) = (denial, &self.status)
            && (status.state == StateCode::Armed || status.hold_cause() == Some(HoldCause::Requested))
        {
            return self.say(name, &format!("hold: the arm is held already: {}", self.doing()));
        }
        let accepted = denial.is_none();
        let armed = request == Request::Arm && accepted;
        self.answer(name, denial, "")?;
        if accepted {
            self.note_accepted(request)?;
        }
        match &self.arm.left_out {
            Some(left_out) if armed => self.say("model", left_out),
            _ => Ok(()),
        }
    }

    /// Removes the torque as soon as the arm is at rest.
    fn disarm(&mut self) -> Result<Option<Rejection>, Stop> {
        let mut left = REST;
        loop {
            match self.request(Request::Disarm)? {
                Some(Rejection::Denied(Denial { code: NOT_AT_REST, .. }))
                    if left > 0.0 && self.state() != Some(StateCode::Running) =>
                {
                    self.wait(LOOK)?;
                }
                other => return Ok(other),
            }
            left -= LOOK;
        }
    }

    /// Waits until an arm in the state holding is at rest, so that another control law starts from a constant position.
    pub(super) fn until_at_rest(&mut self) -> Result<(), Stop> {
        let mut left = REST;
        let mut last = self.q.clone();
        while left > 0.0 {
            self.wait(LOOK)?;
            left -= LOOK;
            let moved = match (&last, &self.q) {
                (Some(a), Some(b)) => a.iter().zip(b).any(|(a, b)| (a - b).abs() > STILL * LOOK),
                _ => false,
            };
            if !moved {
                break;
            }
            last.clone_from(&self.q);
        }
        Ok(())
    }

    /// Waits for a time of the board's clock, s.
    pub(super) fn wait(&mut self, seconds: f64) -> Result<(), Stop> {
        let tick = |operator: &Self| operator.status.as_ref().map_or(0, |status| status.tick);
        let (begin, ticks) = (tick(self), (seconds / self.arm.period).round());
        // A simulated board goes on while its cable is cut and no status arrives.
        let end = self.device.now() + Duration::from_secs_f64(seconds - 0.5 * self.arm.period);
        while f64::from(tick(self).wrapping_sub(begin)) < ticks
            && !(self.device.is_simulated() && self.device.now() > end)
        {
            self.step()?;
        }
        Ok(())
    }

    /// Waits until the motion has ended, for whatever reason.
    pub(super) fn wait_for_the_end(&mut self) -> Result<(), Stop> {
        while self.is_moving() {
            self.step()?;
        }
        let text = match (&self.goal, &self.q) {
            (Some(goal), Some(q)) => {
                let off =
                    q.iter().zip(goal).map(|(q, goal)| (q - goal).abs()).enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
                let (joint, off) = off.unwrap_or((0, 0.0));
                let (name, unit, _) = self.arm.joint(joint);
                format!("wait: arrived; furthest off: {name}, by {off:.2e} {unit}")
            }
            _ => format!("wait: {}", self.doing()),
        };
        self.say("wait", &text)
    }

    /// Lets time pass without a request.
    ///
    /// # Errors
    /// As [`Operator::step`].
    pub fn idle(&mut self) -> Result<(), Stop> {
        let moved = self.is_moving();
        self.step()?;
        if moved && !self.is_moving() {
            self.report.still();
            return self.wait_for_the_end();
        }
        Ok(())
    }

    /// Check for Ctrl-C without letting time pass.
    ///
    /// # Errors
    /// [`Stop::Interrupted`].
    pub fn unless_interrupted(&self) -> Result<(), Stop> {
        if self.stop_pressed() {
            return Err(Stop::Pressed);
        }
        if self.presses.load(Ordering::Relaxed) > self.seen { Err(Stop::Interrupted) } else { Ok(()) }
    }

    /// Reports an unknown or impossible input.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn complain(&self, problem: &str) -> Result<(), Stop> {
        self.say("input", problem)
    }
}
