//! Passing of time for an operator: points are sent, and frames of the board are received.

use super::Operator;
use super::device::{DeviceError, SILENCE};
use super::reason::Stop;
use link::Frame;
use std::time::Duration;

impl Operator {
    /// Lets time pass: sends points, and receives frames of the board.
    ///
    /// # Errors
    /// The board can no longer be used; Ctrl-C.
    pub fn step(&mut self) -> Result<(), Stop> {
        self.unless_interrupted()?;
        self.pass()
    }

    /// As [`Operator::step`], but ignores Ctrl-C. The stop key still acts.
    pub(super) fn pass(&mut self) -> Result<(), Stop> {
        if self.stop_pressed() || (!self.stopping && self.is_let_go()) {
            return Err(Stop::Pressed);
        }
        self.heed_targets()?;
        self.fill()?;
        self.renew_live()?;
        self.ask_for_heat()?;
        for frame in self.device.pass()? {
            self.take(frame)?;
        }
        self.hold_urgently()?;
        if self.silent_for(self.heard) > SILENCE && !self.device.is_cut() {
            return Err(DeviceError::Silent { what: "status", time: SILENCE }.into());
        }
        match self.seen_now().as_ref().filter(|_| self.is_moving()) {
            Some(seen) => self.report.live(seen),
            None => self.report.still(),
        }
        Ok(())
    }

    /// Time since a moment of the device's clock.
    pub(super) fn silent_for(&self, since: Duration) -> Duration {
        self.device.now().saturating_sub(since)
    }

    pub(super) fn say(&self, about: &str, text: &str) -> Result<(), Stop> {
        Ok(self.report.say(about, text, self.seen_now().as_ref())?)
    }

    /// Reports that a command is rejected, and why.
    pub(super) fn reject(&mut self, name: &str, why: &str) -> Result<(), Stop> {
        self.refused = true;
        self.say(name, &format!("{name}: rejected: {why}"))
    }

    pub(super) fn send(&mut self, frame: &Frame) -> Result<(), Stop> {
        Ok(self.device.send(frame)?)
    }
}
