//! Requests to the board's safety state machine, and frames that were lost on the wire.
//!
//! Any frame may be lost. So each request carries a number, and is sent again every [`REPEAT`] until the board's answer has come. The board acts only
//! once on a number, however often it arrives.

use super::device::{DeviceError, SILENCE};
use super::rejection::Rejection;
use super::{Operator, Stop, messages};
use link::{Denial, Frame, Request, StateCode, Verdict};
use std::time::Duration;

/// Interval at which a request is sent again.
pub(super) const REPEAT: Duration = Duration::from_millis(30);

/// A request without an answer for this long is reported as sent, but not confirmed.
pub(super) const UNCONFIRMED: Duration = Duration::from_millis(250);

/// A request other than a stop is given up after this time, or after the scene's heartbeat limit, whichever is longer: an arm that arms long after
/// the request would surprise the user.
pub(super) const PATIENCE: Duration = Duration::from_millis(500);

/// [`dynamics_core::safety::Refusal::ChangePending`].
const CHANGE_PENDING: u8 = 11;

/// Longest time that arming or disarming may take.
const ARMING_TIME: Duration = Duration::from_secs(10);

impl Operator {
    /// Sends a request until the board has answered it. Returns the reason if the request had no effect.
    pub(super) fn request(&mut self, request: Request) -> Result<Option<Rejection>, Stop> {
        // The status of the tick that judged the request shows the new state.
        self.watch(1)?;
        self.awaited = self.next_number();
        (self.asking, self.verdict) = (true, None);
        self.stopping = matches!(request, Request::Hold | Request::Stop | Request::Disarm);
        let mut judged = self.until_judged(self.awaited, request);
        // A parameter change that waits for the same tick takes effect first, so the request is repeated.
        for _ in 0..ATTEMPTS {
            if !matches!(judged, Ok(Some(Rejection::Denied(Denial { code: CHANGE_PENDING, .. })))) {
                break;
            }
            (self.awaited, self.verdict) = (self.next_number(), None);
            judged = self.until_judged(self.awaited, request);
        }
        let judged = judged.and_then(|rejection| self.until_settled().map(|()| rejection));
        (self.asking, self.stopping) = (false, false);
        let rejection = judged?;
        self.watch_as_needed()?;
        Ok(rejection)
    }

    fn next_number(&mut self) -> u8 {
        self.number = self.number.wrapping_add(1);
        self.number
    }

    fn until_judged(&mut self, number: u8, request: Request) -> Result<Option<Rejection>, Stop> {
        let name = name_of(request);
        let stops = matches!(request, Request::Stop | Request::Hold | Request::Disarm);
        let limit = if stops { SILENCE } else { PATIENCE.max(self.arm.heartbeat) };
        let begin = self.device.now();
        let (mut sent, mut reported) = (None, false);
        let (verdict, before) = loop {
            if let Some(judged) = self.verdict {
                break judged;
            }
            let waited = self.silent_for(begin);
            if waited >= limit {
                return Ok(Some(Rejection::Unconfirmed(waited)));
            }
            if sent.is_none_or(|sent| self.silent_for(sent) >= REPEAT) {
                sent = Some(self.device.now());
                self.send(&Frame::request(number, request))?;
                // The text follows the frame, because a terminal that accepts no text must not delay a stop.
                if let Some(text) = self.announcement.take() {
                    self.report.still();
                    self.say(name, text)?;
                }
            }
            if waited >= UNCONFIRMED && !reported {
                reported = true;
                self.say(name, &format!("{name}: sent, not confirmed by the controller yet; sending it again"))?;
            }
            self.pass()?;
        };
        // The status of the judging tick comes after the answer.
        let end = self.device.now() + SILENCE;
        while self.statuses == before {
            if self.device.now() > end {
                return Err(DeviceError::Silent { what: "status", time: SILENCE }.into());
            }
            self.pass()?;
        }
        Ok(match verdict {
            Verdict::Accepted => None,
            Verdict::Rejected(denial) => Some(Rejection::Denied(denial)),
            Verdict::Superseded => Some(Rejection::Superseded),
        })
    }

    /// Lets time pass until the drives are on and carry the arm's weight, or until the brakes have engaged.
    fn until_settled(&mut self) -> Result<(), Stop> {
        let end = self.device.now() + ARMING_TIME;
        while matches!(self.state(), Some(StateCode::Arming | StateCode::Disarming)) && self.device.now() < end {
            self.pass()?;
        }
        Ok(())
    }

    /// Reports the result of a request as text.
    pub(super) fn answer(&mut self, name: &str, rejection: Option<Rejection>, granted: &str) -> Result<(), Stop> {
        let text = match (rejection, &self.status) {
            (Some(rejection), _) => {
                self.refused = true;
                format!("{name}: {}", messages::rejection(&rejection))
            }
            (None, Some(status)) => {
                let homed = if status.state == StateCode::Idle && status.homed { ", homed" } else { "" };
                format!("{name}: {}{homed}{granted}", self.doing())
            }
            (None, None) => name.to_owned(),
        };
        self.say(name, &text)
    }

    /// Handles a report of frames that did not arrive or were damaged. If points of a running motion may be among them, the motion has a gap, and the
    /// arm is stopped.
    pub(super) fn frames_were_lost(&mut self) -> Result<(), Stop> {
        let sends_points = !self.feed.is_empty() || !self.under_way.is_empty() || self.following.is_some();
        if self.state() != Some(StateCode::Running) || !sends_points || self.urgent.is_some() {
            return Ok(());
        }
        self.refused = true;
        self.feed.clear();
        self.leave_targets("frames were lost on the way to the controller");
        self.hold_without_waiting()?;
        self.say(
            "lost",
            "frames were lost on the way to the controller, perhaps points of the motion: stop sent; check the cable, then repeat the command",
        )
    }

    /// Sends a hold that is repeated until the arm no longer runs. No other request is disturbed.
    pub(super) fn hold_without_waiting(&mut self) -> Result<(), Stop> {
        let number = self.next_number();
        self.urgent = Some((number, self.device.now()));
        self.send(&Frame::request(number, Request::Hold))
    }

    /// Sends an urgent hold again until the arm no longer runs.
    pub(super) fn hold_urgently(&mut self) -> Result<(), Stop> {
        let Some((number, sent)) = self.urgent else { return Ok(()) };
        if self.state() != Some(StateCode::Running) {
            self.urgent = None;
        } else if self.silent_for(sent) >= REPEAT {
            self.urgent = Some((number, self.device.now()));
            self.send(&Frame::request(number, Request::Hold))?;
        }
        Ok(())
    }

    /// Sends a frame that has no answer, until the board has taken it and has not reported a loss meanwhile.
    pub(super) fn send_surely(&mut self, frame: &Frame) -> Result<(), Stop> {
        for _ in 0..ATTEMPTS {
            let (lost, _) = self.device.tap().lost();
            self.send(frame)?;
            self.until_taken()?;
            if self.device.tap().lost().0 == lost {
                break;
            }
        }
        Ok(())
    }
}

/// Most attempts to send a frame that has no answer.
const ATTEMPTS: u32 = 8;

/// Name of a request's command.
pub(super) fn name_of(request: Request) -> &'static str {
    Request::NAMES.iter().find(|(other, _)| *other == request).map_or("request", |(_, name)| *name)
}
