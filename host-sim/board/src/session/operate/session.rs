//! Communication with a board except motions: hellos, requests, the interval of its reports, and the end of a session.

use super::command::{Command, HELP};
use super::device::{Cut, DeviceError, SILENCE};
use super::rejection::Rejection;
use super::requests::name_of;
use super::{Operator, Stop, has_taken, table};
use crate::chip::ChipError;
use crate::session::frame_log::recorder::Recorder;
use crate::session::states::{ARMING, RUNNING};
use link::{Denial, Frame, Hello, Parts, Request, Watch};
use robot_compiler::names;
use sim::output::Output;
use std::io;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Statuses per second shown to a user when not every tick is needed.
const SHOWN: f64 = 50.0;

/// Number of hellos sent to a board that does not answer, or whose first tick was missed.
const HELLOS: u32 = 8;

/// Age from which a report is old: a board that is heard reports at least every 20 ms.
const OLD: Duration = Duration::from_millis(200);

/// Time limit for the arm to come to rest before it is disarmed, s, and the interval of the checks, s.
const REST: f64 = 10.0;
const LOOK: f64 = 0.05;

/// Speed below which an arm counts as still before its law is changed, rad/s or m/s.
const STILL: f64 = 0.05;

/// Contents of a board's reports: all that a replay needs.
const PARTS: Parts = Parts::SENSED.and(Parts::TORQUE).and(Parts::EXTERNAL);

/// [`dynamics_core::safety::Refusal::NotAtRest`].
const NOT_AT_REST: u8 = 6;

impl Operator {
    /// Send a hello: both sides agree on the same robot. Then the board idles, or goes on holding an arm that it drives.
    ///
    /// # Errors
    /// A board that is silent, or was built for another robot or scene.
    pub fn begin(&mut self) -> Result<(), Stop> {
        self.agree()?;
        // Homed, or driven, is no arm of a new session.
        let is_old = self.drives() || self.state() == Some(ARMING) || self.status.as_ref().is_some_and(|it| it.homed);
        self.resumed = self.is_live() && is_old;
        self.found_driven = self.is_live() && (self.drives() || self.state() == Some(ARMING));
        self.learn_law()?;
        if self.resumed {
            self.continue_session()?;
        } else if self.is_live() {
            self.send_live()?;
        }
        if self.status.as_ref().is_some_and(|status| status.kept) {
            self.say(
                "black-box",
                "the board holds the black box of an earlier fault: `dump` reads it, `erase` lets it record again",
            )?;
        }
        Ok(())
    }

    /// Takes over what an earlier host has left: its law, its payload, and limits of the first motion that may still be in force.
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

    /// True if an earlier host has left an arm that is driven.
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
                // A record can be replayed only from the first tick on.
                Some(1) => return Ok(()),
                Some(_) if !self.device.tap().is_recording() => return Ok(()),
                Some(first) if attempt == HELLOS || self.drives() => {
                    let text = format!(
                        "the board's first ticks were missed: the record begins at tick {first} and cannot be replayed"
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
        // A drill's target has agreed before, and a session on the desk needs no agreement.
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
        // A board may be holding something that this program does not know: its live inputs follow when its state is known.
        if self.is_live() { Ok(()) } else { self.send_live() }
    }

    /// Sends the live inputs.
    pub(super) fn send_live(&mut self) -> Result<(), Stop> {
        let live = self.arm.limbs.live(self.arm.payload).map_err(ChipError::from)?;
        self.send(&Frame::Live(live))
    }

    /// Handle a hello of the board.
    pub(super) fn greeted(&mut self, theirs: Hello) -> Result<(), Stop> {
        let own = self.arm.hello;
        if (Hello { pacing: own.pacing, ..theirs }) != own {
            return Err(ChipError::OtherRobot { expected: own, found: theirs }.into());
        }
        match theirs.pacing == own.pacing {
            true => self.agreed = true,
            // A board sends this hello when it has started.
            false if self.agreed && self.is_live() => return Err(DeviceError::StartedAnew.into()),
            false => {}
        }
        Ok(())
    }

    /// Interval at which the board has to report, in ticks.
    pub(super) fn needed(&mut self) -> u16 {
        if self.device.tap().is_recording() {
            return 1;
        }
        let shown = (1.0 / (SHOWN * self.arm.period)).max(1.0) as u16;
        match u16::try_from(self.print.0) {
            Ok(every @ 1..) => shown.min(every),
            _ => shown,
        }
    }

    /// Set the interval of the board's reports, in ticks. A drill reports every tick anyway.
    pub(super) fn watch(&mut self, every: u16) -> Result<(), Stop> {
        if !self.is_live() || self.watched == every {
            return Ok(());
        }
        self.watched = every;
        let parts = self.parts(every);
        self.send(&Frame::Watch(Watch { every, parts }))
    }

    /// Contents of the reports at this interval. They hold the reference if the board estimates no external torques, which would be in its
    /// place, and if the wire has time for it.
    fn parts(&mut self, every: u16) -> Parts {
        let has_time = every > 1 && !self.device.tap().is_recording();
        if has_time && !self.arm.estimates { PARTS.and(Parts::REFERENCE) } else { PARTS }
    }

    /// Let time pass until the board has taken the last frame sent.
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
        if request == Request::Arm && self.is_live() {
            if self.resumed && !self.learn_payload()? {
                self.refused = true;
                return self.say(
                    name,
                    "arm: rejected: the board does not report the payload that it holds; declare it with `payload`",
                );
            }
            // The live inputs of the hello may have been lost.
            let live = self.arm.limbs.live(self.arm.payload).map_err(ChipError::from)?;
            self.send_surely(&Frame::Live(live))?;
        }
        let denial = if request == Request::Disarm { self.disarm()? } else { self.request(request)? };
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

    /// Remove the torque as soon as the arm is at rest.
    fn disarm(&mut self) -> Result<Option<Rejection>, Stop> {
        let mut left = REST;
        loop {
            match self.request(Request::Disarm)? {
                Some(Rejection::Denied(Denial { code: NOT_AT_REST, .. }))
                    if left > 0.0 && self.state() != Some(RUNNING) =>
                {
                    self.wait(LOOK)?;
                }
                other => return Ok(other),
            }
            left -= LOOK;
        }
    }

    /// Wait until an arm that was told to hold is at rest, so that another law finds it where it stays.
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

    /// Wait for a time of the board, s.
    pub(super) fn wait(&mut self, seconds: f64) -> Result<(), Stop> {
        let tick = |operator: &Self| operator.status.as_ref().map_or(0, |status| status.tick);
        let (begin, ticks) = (tick(self), (seconds / self.arm.period).round());
        // A simulated board goes on although its cable is cut and no status comes.
        let end = self.device.now() + Duration::from_secs_f64(seconds - 0.5 * self.arm.period);
        while f64::from(tick(self).wrapping_sub(begin)) < ticks
            && !(self.device.is_simulated() && self.device.now() > end)
        {
            self.step()?;
        }
        Ok(())
    }

    /// Wait until the motion has ended, for any reason.
    fn wait_for_the_end(&mut self) -> Result<(), Stop> {
        while self.is_moving() {
            self.step()?;
        }
        let text = match (&self.goal, &self.q) {
            (Some(goal), Some(q)) => {
                let off =
                    q.iter().zip(goal).map(|(q, goal)| (q - goal).abs()).enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
                let (joint, off) = off.unwrap_or((0, 0.0));
                let (name, unit) = self.arm.joints.get(joint).map_or(("", ""), |(name, unit, _)| (name, unit));
                format!("wait: arrived; furthest off: {name}, by {off:.2e} {unit}")
            }
            _ => format!("wait: {}", self.doing()),
        };
        self.say("wait", &text)
    }

    /// Let time pass without a request.
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

    /// Report an unknown or impossible input.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn complain(&self, problem: &str) -> Result<(), Stop> {
        self.say("input", problem)
    }

    /// Executes a command. `disarm`, `quit` and `full-range` are executed by the main loop, because they may need an answer of the user.
    ///
    /// # Errors
    /// See [`Stop`]. A request that the board rejects is no error.
    pub(crate) fn obey(&mut self, command: Command) -> Result<(), Stop> {
        match command {
            Command::Nothing | Command::Disarm(_) | Command::Quit(_) | Command::FullRange => {}
            Command::Erase => {
                let rejection = self.request(Request::Release)?;
                self.answer("erase", rejection, "; the black box records again")?;
            }
            Command::Park => self.park()?,
            Command::Stop => self.stop()?,
            Command::Help => {
                let lines: Vec<_> = HELP.iter().map(|(usage, what)| format!("  {usage:<26} {what}")).collect();
                self.say("help", &lines.join("\n"))?;
            }
            Command::Status => {
                self.until_fresh()?;
                let losses = self.losses();
                let text = self.seen_now().map(|seen| seen.text()).unwrap_or_default();
                self.say("status", &format!("{text}{losses}"))?;
            }
            Command::Ask(request) => self.ask(request)?,
            Command::Run => self.run()?,
            Command::Jog(joint, delta, time) => self.jog(joint, delta, time)?,
            Command::Goto(q, time) => self.go_to(&q, time)?,
            Command::Wait(Some(seconds)) => self.wait(seconds)?,
            Command::Wait(None) => self.wait_for_the_end()?,
            Command::Watch(every) => {
                let tick = self.status.as_ref().map_or(0, |status| status.tick);
                self.print = (every, tick);
                let needed = self.needed();
                self.watch(needed)?;
            }
            Command::Dump(file) => self.dump(file.as_deref())?,
            Command::Record(file) => self.record(file.as_deref())?,
            Command::Get(numbers) => self.get(&numbers)?,
            Command::Set(setting) => self.set(setting)?,
            Command::Payload(mass, place) => self.payload(mass, place)?,
            Command::Law(law) => self.law(law)?,
            Command::Stiffness(factor) => self.stiffness(factor)?,
            Command::CheckTorque(joint) => self.check_torque(joint)?,
            Command::Weigh => self.weigh()?,
            Command::Cut(what, cut) => self.cut(what, cut)?,
            Command::EmergencyStop(pressed) => self.emergency_stop(pressed)?,
        }
        Ok(())
    }

    /// Waits for a report if the last one is old, and says so if none comes.
    fn until_fresh(&mut self) -> Result<(), Stop> {
        if self.silent_for(self.reported) <= OLD {
            return Ok(());
        }
        let (before, end) = (self.statuses, self.device.now() + OLD);
        while self.statuses == before && self.device.now() < end {
            self.pass()?;
        }
        if self.statuses != before {
            return Ok(());
        }
        let age = self.silent_for(self.reported).as_secs_f64();
        self.say("status", &format!("the board is not heard: this is its last report, {age:.1} s old"))
    }

    fn cut(&mut self, what: Cut, cut: bool) -> Result<(), Stop> {
        let name = if cut { "cut" } else { "plug" };
        let what_in_words = match what {
            Cut::Host => "host".to_owned(),
            Cut::Bus(bus) => format!("bus {}", bus + 1),
            Cut::Drive(joint) => format!("drive of {}", self.arm.joints.get(joint).map_or("", |(name, ..)| name)),
        };
        match self.device.cut(what, cut) {
            Ok(()) => {
                self.heard = self.device.now();
                self.say(name, &format!("{name}: {what_in_words}"))
            }
            Err(why) => {
                self.refused = true;
                self.say(name, &format!("{name}: rejected: {why}"))
            }
        }
    }

    fn emergency_stop(&mut self, pressed: bool) -> Result<(), Stop> {
        let name = if pressed { "press" } else { "release" };
        if self.device.press(pressed) {
            self.asking = true;
            let waited = self.wait(2.0 * self.arm.period);
            self.asking = false;
            waited?;
            return self.answer(name, None, "");
        }
        if self.is_live() {
            self.refused = true;
            return self.say(name, &format!("{name}: rejected: the board has an emergency stop of its own"));
        }
        self.lines.emergency_stop = pressed;
        self.asking = true;
        self.send(&Frame::Lines(self.lines))?;
        let taken = self.until_taken();
        self.asking = false;
        taken?;
        self.answer(name, None, "")
    }

    fn dump(&mut self, file: Option<&Path>) -> Result<(), Stop> {
        (self.past, self.whole) = (None, None);
        self.send(&Frame::Dump)?;
        let end = self.device.now() + SILENCE;
        let past = loop {
            self.pass()?;
            if let Some(past) = self.whole.take() {
                break past;
            }
            if self.device.now() > end {
                self.refused = true;
                return self.say("dump", "dump: rejected: the black box did not come whole; ask again");
            }
        };
        let text = match file {
            None => format!("dump: {} ticks\n{}", past.len(), table::table(&past, &self.joint_names())),
            Some(file) => {
                // The session goes on: an arm must not fall for a mistyped name.
                let claimed = self.claim(file);
                let error = |error: io::Error| format!("{}: {error}", file.display());
                let written =
                    claimed.and_then(|()| table::write_csv(&past, self.arm.joints.len(), file).map_err(error));
                if let Err(problem) = written {
                    self.refused = true;
                    return self.say("dump", &format!("dump: rejected: {problem}"));
                }
                self.outputs.written(&[file.to_owned()]).ok();
                format!("dump: {} ticks, {}", past.len(), file.display())
            }
        };
        self.say("dump", &text)
    }

    /// The black box is complete.
    pub(super) fn past_is_whole(&mut self) {
        self.whole = Some(self.past.take().unwrap_or_default());
    }

    fn record(&mut self, file: Option<&Path>) -> Result<(), Stop> {
        let Some(file) = file else {
            self.device.tap().record(None)?;
            let needed = self.needed();
            self.watch(needed)?;
            return self.say("record", "record: off");
        };
        if self.drives() {
            self.refused = true;
            let why = "record: rejected: the arm is driven, and a record begins with a new session; `disarm` first";
            return self.say("record", why);
        }
        if let Err(problem) = self.claim(file) {
            self.refused = true;
            return self.say("record", &format!("record: rejected: {problem}"));
        }
        self.keep(file)?;
        self.begin()?;
        self.say("record", &format!("record: {}; a new session, not homed", file.display()))
    }

    /// The same operator with these outputs: files that `dump` and `record` may overwrite, and inputs that they may not.
    #[must_use]
    pub fn with_outputs(mut self, outputs: Output) -> Self {
        self.outputs = outputs;
        self
    }

    /// Claims a file for `dump` or `record`; the problem as a text, because the session goes on.
    fn claim(&mut self, file: &Path) -> Result<(), String> {
        self.outputs.file(file).map_err(|failure| {
            let report = failure.report();
            report.help().map_or_else(|| report.to_string(), |help| format!("{report}; {help}"))
        })
    }

    /// Record every frame from here on. Call [`Operator::begin`] next.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn keep(&mut self, file: &Path) -> Result<(), Stop> {
        let recorder = Recorder::create(file, &self.arm.recorded).map_err(|error| in_file(file, &error))?;
        Ok(self.device.tap().record(Some(recorder))?)
    }

    /// Close the record.
    ///
    /// # Errors
    /// The record cannot be written.
    pub fn close(&mut self) -> io::Result<()> {
        self.report.still();
        self.device.tap().record(None)?;
        // A file that is not registered is only harder to replace.
        self.outputs.finish().ok();
        Ok(())
    }
}

fn in_file(file: &Path, error: &io::Error) -> Stop {
    Stop::Output(io::Error::other(format!("{}: {error}", file.display())))
}
