//! The end of torque: `disarm`, `quit`, the end of the input and Ctrl-C. An arm without brakes sinks when its torque ends. So the operator first
//! reports which joints sink and how far. Then it asks, parks, or keeps holding.
//!
//! | | a user at a terminal | a script or a pipe |
//! |---|---|---|
//! | no joint sinks, or the arm has brakes | disarms | disarms |
//! | joints sink, and there is a `rest` pose | asks: disarm, park, or keep holding | parks, then disarms |
//! | joints sink, and there is none | asks: disarm, or keep holding | holds until `disarm!`, `quit!` or Ctrl-C |

use super::{Operator, Stop};
use link::Request;
use link::StateCode;
use std::sync::atomic::Ordering;

/// Permission to remove the torque of an arm that then sinks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Consent {
    /// Ask the user.
    Ask,
    /// Follow the rule for scripts: park, or keep holding.
    Rule,
    /// The user has agreed.
    Given,
}

/// Outcome of [`Operator::release`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Released {
    /// No torque acts.
    Done,
    /// The user has been asked; the arm is held.
    Asked,
    /// The arm is held.
    Held,
}

impl Operator {
    /// True if the scene or the robot file gives a rest pose, and the control law follows a motion to it.
    pub(crate) fn can_park(&self) -> bool {
        self.arm.rest.is_some() && !self.arm.law.is_hand_guided()
    }

    /// Moves to the rest pose, waits for the end of the motion, and holds the arm there.
    ///
    /// # Errors
    /// No rest pose; the board can no longer be used; Ctrl-C or the stop key.
    pub(crate) fn park(&mut self) -> Result<(), Stop> {
        let Some(rest) = self.arm.rest.clone() else {
            return Err(Stop::Input(
                "park: the scene and its robot file give no rest pose; add `rest = [..]` to one of them".into(),
            ));
        };
        if !self.follows_motions("park")? {
            return Ok(());
        }
        self.hold_if_running()?;
        self.go_to_named("park", &rest, None)?;
        while self.is_moving() {
            self.step()?;
        }
        // After its motion the arm is still in the state running, in which the board rejects a disarm.
        self.hold_if_running()?;
        self.until_at_rest()
    }

    /// Stops an arm that is in the state running, and waits until it is at rest.
    pub(super) fn hold_if_running(&mut self) -> Result<(), Stop> {
        if self.state() != Some(StateCode::Running) {
            return Ok(());
        }
        let denial = self.request(Request::Hold)?;
        self.answer("hold", denial, "")?;
        self.until_at_rest()
    }

    /// Removes the torque. First holds a running arm (if `stops`, or if a user can be asked) and reports which joints sink. Then asks, parks or keeps
    /// holding, as the consent specifies.
    ///
    /// # Errors
    /// The board can no longer be used; Ctrl-C or the stop key.
    pub(crate) fn release(&mut self, consent: Consent, stops: bool) -> Result<Released, Stop> {
        // An arm that is being lowered is held first, because it may be anywhere on its path.
        let moves = self.state() == Some(StateCode::Running) && (stops || consent == Consent::Ask);
        if moves || self.state() == Some(StateCode::Lowering) {
            self.ask(Request::Hold)?;
        }
        if self.state() == Some(StateCode::Homing) {
            self.ask(Request::Disarm)?;
        }
        if !matches!(self.state(), Some(StateCode::Armed | StateCode::Holding | StateCode::Running)) {
            // The board answers `disarm` in every state. At the end of a session, there is nothing to do.
            if !stops && self.state() != Some(StateCode::Homing) {
                self.ask(Request::Disarm)?;
            }
            return Ok(Released::Done);
        }
        if self.state() != Some(StateCode::Running) && consent != Consent::Given {
            self.until_at_rest()?;
            let sinks = self.sinking();
            if !sinks.is_empty() {
                let text = self.sinking_in_words(&sinks);
                return self.with_consent(consent, &text);
            }
        }
        self.ask(Request::Disarm)?;
        Ok(if self.drives() { Released::Held } else { Released::Done })
    }

    fn with_consent(&mut self, consent: Consent, text: &str) -> Result<Released, Stop> {
        // After a stop, the arm moves only if a person requests it.
        let park = self.can_park() && (!self.stopped || consent == Consent::Ask);
        match (consent, park) {
            (Consent::Ask, true) => {
                self.say("disarm", &format!("{text}\ndisarm? y: yes, p: park first, n: no, keep holding"))?;
                Ok(Released::Asked)
            }
            (Consent::Ask, false) => {
                self.say("disarm", &format!("{text}\ndisarm? y: yes, n: no, keep holding"))?;
                Ok(Released::Asked)
            }
            (Consent::Rule | Consent::Given, true) => {
                self.say("park", &format!("{text}; parking first"))?;
                self.park()?;
                let left = self.sinking();
                if !left.is_empty() {
                    let text = self.sinking_in_words(&left);
                    self.reject("disarm", &format!("even at the rest pose, {text}; `disarm!` disarms anyway"))?;
                    return Ok(Released::Held);
                }
                self.ask(Request::Disarm)?;
                Ok(if self.drives() { Released::Held } else { Released::Done })
            }
            (Consent::Rule | Consent::Given, false) => {
                let what = "`disarm!` or `quit!` disarms anyway, and a `rest` pose in the scene lets the arm be parked";
                self.reject("disarm", &format!("{text}; {what}"))?;
                Ok(Released::Held)
            }
        }
    }

    /// Ends a session by the rule for scripts, at the end of the input or after an error. If Ctrl-C or the stop key is pressed while the arm parks,
    /// the arm stops and stays held.
    ///
    /// # Errors
    /// The board can no longer be used; [`Stop::Interrupted`] after a Ctrl-C.
    pub fn end(&mut self) -> Result<(), Stop> {
        self.interrupted();
        match self.release(Consent::Rule, true) {
            Ok(Released::Done) => Ok(()),
            Ok(Released::Held | Released::Asked) => self.keep_holding(),
            Err(Stop::Pressed) => {
                self.stop()?;
                self.keep_holding()
            }
            // A Ctrl-C while the arm parks stops it, as the stop key does.
            Err(Stop::Interrupted) => {
                self.interrupted();
                self.stop()?;
                // Further presses during the stop do not disarm the arm.
                self.interrupted();
                self.keep_holding().and(Err(Stop::Interrupted))
            }
            Err(stop) => Err(stop),
        }
    }

    /// Keeps a real arm held until Ctrl-C, which disarms it. In a dry run nothing can fall, so the session ends.
    ///
    /// # Errors
    /// The board can no longer be used.
    pub(crate) fn keep_holding(&mut self) -> Result<(), Stop> {
        if !self.is_live() || !self.drives() {
            return Ok(());
        }
        self.say("hold", "the arm stays held: support it, then press Ctrl-C to disarm it")?;
        while self.drives() {
            match self.step() {
                Err(Stop::Interrupted) => break,
                Err(Stop::Pressed) => self.stop()?,
                other => other?,
            }
        }
        self.interrupted();
        self.release(Consent::Given, true).map(|_| ())
    }

    /// Marks the presses of Ctrl-C as handled: only a further press interrupts.
    pub(crate) fn interrupted(&mut self) {
        self.seen = self.presses.load(Ordering::Relaxed);
    }
}
