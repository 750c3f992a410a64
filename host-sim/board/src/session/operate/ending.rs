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
use robot_compiler::check::on_stop_distance;
use std::sync::atomic::Ordering;

/// Smallest distance that counts as sinking, rad or m.
const SINK_MIN: f64 = 0.02;

/// Step of the estimate of how far a joint sinks, rad or m, and the most steps.
const STEP: f64 = 0.005;
const STEPS: usize = 4000;

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

/// A joint that sinks when its torque ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sinking {
    joint: usize,
    /// Distance, rad or m.
    distance: f64,
    /// True if only its position limit, or the mechanical stop after it, ends the motion.
    to_limit: bool,
    /// Torque that gravity demands now, and the joint's friction, N m or N.
    gravity: f64,
    friction: f64,
}

/// Returns the joints that sink without torque. Each joint whose gravity torque exceeds its friction moves down in small steps, until friction or a
/// position limit holds it. Dynamics are neglected: a real arm swings past this position.
///
/// `gravity` returns the torque that holds the arm at a position.
fn sinking(q: &[f64], range: &[(f64, f64)], friction: &[f64], gravity: impl Fn(&[f64]) -> Vec<f64>) -> Vec<Sinking> {
    let mut at = q.to_vec();
    let first = gravity(q);
    // A joint outside its limits sinks no farther, and is not lifted either.
    let end = |joint: usize, down: f64| {
        let (low, high) = range.get(joint).copied().unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        if down < 0.0 { low } else { high }
    };
    for _ in 0..STEPS {
        let torque = gravity(&at);
        let mut moved = false;
        for (joint, at) in at.iter_mut().enumerate() {
            let (torque, friction) =
                (torque.get(joint).copied().unwrap_or(0.0), friction.get(joint).copied().unwrap_or(0.0));
            let down = -torque.signum();
            let room = (end(joint, down) - *at) * down;
            if torque.abs() > friction && room > 0.0 {
                *at += down * STEP.min(room);
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    let of = |(joint, (from, to)): (usize, (&f64, &f64))| {
        let distance = (to - from).abs();
        let limit = end(joint, (to - from).signum());
        (distance > SINK_MIN).then(|| Sinking {
            joint,
            distance,
            to_limit: (to - limit).abs() <= STEP,
            gravity: first.get(joint).map_or(0.0, |torque| torque.abs()),
            friction: friction.get(joint).copied().unwrap_or(0.0),
        })
    };
    q.iter().zip(&at).enumerate().filter_map(of).collect()
}

impl Operator {
    /// Joints that sink when the torque ends; none for an arm with brakes, or where no torque acts.
    pub(super) fn sinking(&self) -> Vec<Sinking> {
        let (Some(q), false, true) = (&self.q, self.arm.has_brakes, self.drives()) else { return Vec::new() };
        let still = vec![0.0; q.len()];
        let friction: Vec<f64> = self.arm.friction.iter().map(|(_, coulomb)| *coulomb).collect();
        let mut all = sinking(q, &self.arm.range, &friction, |q| {
            self.arm.model.inverse_dynamics(q, &still, &still, self.arm.payload)
        });
        // A joint that rests on its mechanical stop, as in most rest poses, falls no farther.
        all.retain(|sinking| {
            let joint = self.arm.recorded.robot.joints.get(sinking.joint);
            let near = joint.map_or(0.0, |joint| on_stop_distance(joint.spec.kind));
            !sinking.to_limit || sinking.distance > near
        });
        all
    }

    fn sinking_in_words(&self, all: &[Sinking]) -> String {
        let of = |sinking: &Sinking| {
            let (name, place, force) =
                self.arm.joints.get(sinking.joint).map_or(("", "", ""), |(name, a, b)| (name.as_str(), *a, *b));
            let Sinking { distance, gravity, friction, .. } = *sinking;
            let end = if sinking.to_limit { " to its limit" } else { "" };
            format!(
                "{name} by about {distance:.2} {place}{end} (gravity {gravity:.2} {force}, friction {friction:.2} {force})"
            )
        };
        format!(
            "this arm has no brakes; without torque these joints sink: {}",
            all.iter().map(of).collect::<Vec<_>>().join(", ")
        )
    }

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
        if self.arm.law.is_hand_guided() {
            // Its reference is where the hand leads the arm: it would report a motion and stay.
            self.refused = true;
            return self.say(
                "park",
                "park: rejected: an arm that is guided by hand follows no motion; choose another law (`law computed-torque`), or lead the arm to its rest pose and `disarm`",
            );
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
                    self.refused = true;
                    let text = self.sinking_in_words(&left);
                    self.say(
                        "disarm",
                        &format!("disarm: rejected: even at the rest pose, {text}; `disarm!` disarms anyway"),
                    )?;
                    return Ok(Released::Held);
                }
                self.ask(Request::Disarm)?;
                Ok(if self.drives() { Released::Held } else { Released::Done })
            }
            (Consent::Rule | Consent::Given, false) => {
                self.refused = true;
                let what = "`disarm!` or `quit!` disarms anyway, and a `rest` pose in the scene lets the arm be parked";
                self.say("disarm", &format!("disarm: rejected: {text}; {what}"))?;
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

#[cfg(test)]
mod tests;
