//! Hellos: board and host agree on a robot, and the board begins a session or continues one.

use super::device::{DeviceError, SILENCE};
use super::session::PARTS;
use super::{Operator, Stop};
use crate::chip::ChipError;
use link::{Frame, Hello, Parts, StateCode, Watch};
use robot_compiler::names;

/// Number of hellos sent to a board that does not answer, or whose first tick was missed.
const HELLOS: u32 = 8;

impl Operator {
    /// Sends a hello, so that both sides agree on the same robot. After it the board idles, or goes on holding an arm that it already drives.
    ///
    /// # Errors
    /// A board that is silent, or was built for another robot or scene.
    pub fn begin(&mut self) -> Result<(), Stop> {
        self.agree()?;
        self.found_driven =
            self.is_live() && self.state().is_some_and(|state| state.has_torque() || state == StateCode::Arming);
        // In a new session the arm is not homed, so a homed arm belongs to an earlier one.
        let is_homed = self.status.as_ref().is_some_and(|status| status.homed);
        self.resumed = self.found_driven || self.is_live() && is_homed;
        self.learn_law()?;
        if self.resumed {
            self.continue_session()?;
        } else if self.is_live() {
            self.send_live()?;
        }
        if self.status.as_ref().is_some_and(|status| status.kept) {
            self.say(
                "black-box",
                "the black box of an earlier fault is kept: `dump` reads it, `erase` lets it record again",
            )?;
        }
        Ok(())
    }

    /// Takes over the state that an earlier host left: control law, payload, and limits of the first motion that may still be in force.
    fn continue_session(&mut self) -> Result<(), Stop> {
        let is_known = self.learn_payload()?;
        self.first_motion.limited = self.arm.first_motion.is_some();
        let law = names::name(self.arm.law);
        let held = match (self.arm.payload_is_live, is_known, &self.arm.payload) {
            (false, ..) => String::new(),
            (true, true, payload) => format!(", payload {:.3} kg", payload.as_ref().map_or(0.0, |body| body.mass)),
            (true, false, _) => ", payload unknown: declare it with `payload` before you arm it again".to_owned(),
        };
        let text = format!(
            "the board continues the session of an earlier host: {}; law {law}{held}; a motion stops",
            self.doing()
        );
        self.say("resumed", &text)?;
        self.remind("; the program cannot know whether they were lifted before")
    }

    /// True if an earlier host left the arm driven.
    pub fn found_driven(&self) -> bool {
        self.found_driven
    }

    fn agree(&mut self) -> Result<(), Stop> {
        for attempt in 1..=HELLOS {
            self.greet()?;
            let end = self.device.now() + SILENCE / HELLOS;
            while self.status.is_none() && self.device.now() < end {
                self.pass()?;
            }
            let first = self.status.as_ref().map(|status| status.tick);
            match first {
                // A record can be replayed only if it begins with the first tick.
                Some(1) => return Ok(()),
                Some(_) if !self.device.tap().is_recording() => return Ok(()),
                Some(first) if attempt == HELLOS || self.drives() => {
                    let text = format!(
                        "the first ticks were missed: the record begins at tick {first} and cannot be replayed"
                    );
                    return self.say("record", &text);
                }
                _ => {}
            }
        }
        Err(DeviceError::Silent { what: "answer to a hello", time: SILENCE }.into())
    }

    fn greet(&mut self) -> Result<(), Stop> {
        self.feed.clear();
        self.under_way.clear();
        self.heat.forget();
        (self.status, self.goal, self.past, self.heard) = (None, None, None, self.device.now());
        // The target of a dry run has already agreed.
        self.agreed = !self.is_live();
        self.send(&Frame::Hello(self.arm.hello))?;
        if self.is_live() {
            // Send this right after the hello, so that the board reports its first tick too.
            self.watched = self.needed();
            let parts = self.parts(self.watched);
            self.send(&Frame::Watch(Watch { every: self.watched, parts }))?;
        } else {
            self.send(&Frame::Lines(self.lines))?;
            if self.arm.estimates {
                self.send(&Frame::Watch(Watch { every: 1, parts: PARTS.and(Parts::COST) }))?;
            }
        }
        self.resumed = self.is_live();
        // A live board may hold a payload that this program does not know. So its live inputs follow only after its state is known.
        if self.is_live() { Ok(()) } else { self.send_live() }
    }

    /// Sends the live inputs.
    pub(super) fn send_live(&mut self) -> Result<(), Stop> {
        let live = self.arm.model.live(self.arm.payload).map_err(ChipError::from)?;
        self.send(&Frame::Live(live))
    }

    /// Handles a hello of the board.
    pub(super) fn greeted(&mut self, theirs: Hello) -> Result<(), Stop> {
        let own = self.arm.hello;
        if (Hello { pacing: own.pacing, ..theirs }) != own {
            return Err(ChipError::OtherRobot { expected: own, found: theirs }.into());
        }
        match theirs.pacing == own.pacing {
            true => self.agreed = true,
            // A board sends such a hello only after a start.
            false if self.agreed && self.is_live() => return Err(DeviceError::StartedAnew.into()),
            false => {}
        }
        Ok(())
    }
}
