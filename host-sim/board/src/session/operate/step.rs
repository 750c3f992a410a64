//! Passing of time for an operator: points are sent, and frames of the board are received, with their effects.

use super::Operator;
use super::device::{DeviceError, SILENCE};
use super::messages;
use super::reason::Stop;
use super::report::StatusView;
use super::samples::{Sample, Samples};
use link::{Actuation, Answer, Frame, Refusal, StateCode, Status, Value};
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

    /// Sends the live inputs again before the board treats them as too old.
    pub(super) fn renew_live(&mut self) -> Result<(), Stop> {
        let Some(every) = self.arm.live_every else { return Ok(()) };
        if !self.agreed || self.resumed || self.silent_for(self.live_sent) < every {
            return Ok(());
        }
        self.live_sent = self.device.now();
        self.send_live()
    }

    /// A view of the last status in the units of the arm.
    pub(super) fn seen_now(&self) -> Option<StatusView<'_>> {
        let status = self.status.as_ref()?;
        let q = self.q.as_deref();
        let external = status.external();
        // In a dry run the drives are simulated here.
        let drive_fault =
            status.drive_fault().or(self.device.drive_fault()).filter(|_| status.state == StateCode::Fault);
        let wrench = q.zip(external).and_then(|(q, external)| self.arm.model.tip_wrench(q, external));
        Some(StatusView {
            status,
            q,
            wrench,
            drive_fault,
            joints: &self.arm.joints,
            period: self.arm.period,
            words: self.arm.words,
            first_motion: self.limit(),
            heat: self.arm.has_heat.iter().enumerate().map(|(joint, _)| self.heat_of(joint)).collect(),
        })
    }

    /// State of the board in words, with the report of a drive's fault.
    pub(super) fn doing(&self) -> String {
        self.seen_now().map(|seen| seen.doing()).unwrap_or_default()
    }

    pub(super) fn take(&mut self, frame: Frame) -> Result<(), Stop> {
        match frame {
            // A status before the hellos agree belongs to the previous session.
            Frame::Status(status) if self.agreed => self.told(status)?,
            Frame::Past(Some(status)) => self.past.get_or_insert_default().push(status),
            Frame::Past(None) => self.past_is_whole(),
            Frame::Value(value) => {
                if self.takes_heat(&value) {
                    return Ok(());
                }
                // The answer to a repeated question may come twice.
                let again = |answer: &Result<Value, Refusal>| answer.is_ok_and(|before| before.index == value.index);
                if let Some(answers) = &mut self.expected
                    && !answers.iter().any(again)
                {
                    answers.push(Ok(value));
                }
            }
            Frame::Answer(Answer { number, verdict }) if number == self.awaited => {
                self.verdict = self.verdict.or(Some((verdict, self.statuses)));
            }
            // The board rejects the hello because it drives the arm in another host's session.
            Frame::Refusal(refusal @ Refusal::Driven) if !self.agreed => {
                return Err(crate::chip::ChipError::Refused(refusal).into());
            }
            Frame::Refusal(Refusal::Lost { .. } | Refusal::Undecodable(_)) => self.frames_were_lost()?,
            // Only older firmware rejects a parameter of this program: the heat of the motors.
            Frame::Refusal(Refusal::NoParameter) if !self.heat.is_expected() => self.heat.unsupported(),
            Frame::Refusal(refusal) => {
                if let Some(answers) = &mut self.expected {
                    answers.push(Err(refusal));
                    return Ok(());
                }
                self.refused = true;
                self.say("refusal", &messages::frame(&refusal))?;
            }
            Frame::Hello(theirs) => self.greeted(theirs)?,
            _ => {}
        }
        Ok(())
    }

    pub(super) fn told(&mut self, status: Status) -> Result<(), Stop> {
        (self.heard, self.reported) = (self.device.now(), self.device.now());
        self.statuses += 1;
        while self.under_way.front().is_some_and(|&sent| has_taken(&status, sent)) {
            self.under_way.pop_front();
        }
        if let Some(sensed) = &status.sensed {
            self.count_stale(&sensed.age_ticks);
        }
        let sensed = status.sensed.as_ref().map(|sensed| &sensed.sensed).or(self.device.reading());
        if let Some(q) = sensed.and_then(|sensed| self.arm.model.positions(sensed)) {
            self.q = Some(q);
        }
        self.sample(&status);
        self.observe(&status);
        let (tick, state) = (status.tick, status.state);
        let doing = |status: &Status| (status.state, status.cause, status.joint);
        let changed = self.status.as_ref().is_some_and(|before| doing(before) != doing(&status));
        let before = self.status.replace(status).map(|before| before.state);
        if changed && before == Some(StateCode::Running) {
            // The board has discarded its trajectory.
            self.feed.clear();
            self.under_way.clear();
            self.goal = None;
            let why = self.doing();
            self.leave_targets(&why);
        }
        self.publish();
        if changed && !self.asking {
            let text = format!("tick {tick}: {}", self.doing());
            self.report.say("change", &text, self.seen_now().as_ref())?;
            // In the first motion a wrong sign or unit is likely. In a later one, what has caused the fault (a hand, a stop, a collision) changes the
            // torques too.
            let explains = matches!(before, Some(StateCode::Armed | StateCode::Holding)) || self.limit().is_some();
            if let (StateCode::Fault, true, Some((text, _))) = (state, explains, self.torque_in_words()) {
                self.say("torque", &text)?;
            }
        }
        let (every, last) = self.print;
        if let Some(seen) = self.seen_now().filter(|_| every > 0)
            && u64::from(seen.status.tick.wrapping_sub(last)) >= every
        {
            let tick = seen.status.tick;
            self.report.say("watch", &seen.line(), Some(&seen))?;
            self.print.1 = tick;
        }
        Ok(())
    }

    /// Counts readings that are older than the joint's youngest one: in their tick, the drive's reply was missing.
    pub(super) fn count_stale(&mut self, ages: &[u16]) {
        self.age_min.resize(ages.len(), u16::MAX);
        self.stale.0.resize(ages.len(), 0);
        self.stale.1 += 1;
        for ((age, min), count) in ages.iter().zip(&mut self.age_min).zip(&mut self.stale.0) {
            *min = (*min).min(*age);
            *count += u64::from(*age > *min);
        }
    }

    /// Frames lost on the host link and replies missing on the drives' buses, in words; empty if there are none.
    pub(super) fn losses(&mut self) -> String {
        let mut text = String::new();
        let (to_board, to_host) = self.device.tap().lost();
        if to_board > 0 || to_host > 0 {
            let least = if self.device.tap().lost_more() { "at least " } else { "" };
            text += &format!(
                "\nhost link: {least}{to_board} frames lost on the way to the controller, {to_host} on the way back"
            );
        }
        let (counts, statuses) = &self.stale;
        if counts.iter().any(|count| *count > 0) {
            let of = |((name, ..), count): (&(String, &str, &str), &u64)| format!("{name} {count}");
            let all: Vec<String> = self.arm.joints.iter().zip(counts).map(of).collect();
            text += &format!("\ndrives without a fresh reply, of {statuses} statuses: {}", all.join(", "));
        }
        text
    }

    /// Stores the arm's positions and commanded torques while torque acts.
    pub(super) fn sample(&mut self, status: &Status) {
        if status.state == StateCode::Armed && !self.drives() {
            (self.judged, self.samples) = (false, Samples::default());
        }
        match (&status.actuation, &self.q) {
            (Some(Actuation::Drive { torque, .. }), Some(q)) => {
                let torque = torque.iter().copied().map(f64::from).collect();
                self.samples.push(Sample { tick: status.tick, q: q.clone(), torque }, self.arm.period);
            }
            _ if status.state != StateCode::Fault => self.samples.clear(),
            _ => {}
        }
    }
}

/// True if the board was past the frame with number `sent` before this status's tick: it had used it, or counted it as lost.
pub(super) fn has_taken(status: &Status, sent: u16) -> bool {
    status.taken.wrapping_sub(sent) < 0x8000
}
