//! What is said to a board beside motions: hellos, requests, what to report, and how a session ends.

use super::command::{Command, HELP};
use super::station::StationError;
use super::{Operator, SILENCE, Stop, has_taken, table, words};
use crate::chip::ChipError;
use crate::session::frame_log::Writer;
use crate::session::states::{ARMED, HOLDING, HOMING, RUNNING};
use link::{Denial, Frame, Hello, Parts, Request, Watch};
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Statuses a second that a person is shown, where nobody needs every tick.
const SHOWN: f64 = 50.0;

/// How often a hello is said to a board that does not answer, or whose first tick was missed.
const HELLOS: u32 = 8;

/// How long the arm may take to come to rest before it is disarmed, s, and how often it is looked at.
const REST: f64 = 10.0;
const LOOK: f64 = 0.05;

/// What a board reports: all that a replay needs.
const PARTS: Parts = Parts::SENSED.and(Parts::TORQUE);

/// [`dynamics_core::safety::Refusal::NotAtRest`].
const NOT_AT_REST: u8 = 6;

impl Operator {
    /// Say hello: the board idles from then on, and both sides know that they speak of the same robot.
    ///
    /// # Errors
    /// A board that is silent, or was built for something else.
    pub fn begin(&mut self) -> Result<(), Stop> {
        for attempt in 1..=HELLOS {
            self.greet()?;
            let end = Instant::now() + SILENCE / HELLOS;
            while self.status.is_none() && Instant::now() < end {
                self.pass()?;
            }
            let first = self.status.as_ref().map(|status| status.tick);
            match first {
                // A record can be replayed from the first tick on alone.
                Some(1) => return Ok(()),
                Some(_) if !self.station.tap().is_recording() => return Ok(()),
                Some(first) if attempt == HELLOS => {
                    let text = format!(
                        "the board's first ticks were missed: the record begins at tick {first} and cannot be replayed"
                    );
                    return self.say("record", &text);
                }
                _ => {}
            }
        }
        Err(StationError::Silent { what: "answer to a hello", time: SILENCE }.into())
    }

    fn greet(&mut self) -> Result<(), Stop> {
        self.feed.clear();
        self.under_way.clear();
        (self.status, self.goal, self.past, self.heard) = (None, None, None, Instant::now());
        // A drill's target has been asked before, and on the desk there is nobody to ask.
        self.agreed = !self.is_live();
        self.send(&Frame::Hello(self.arm.hello))?;
        if self.is_live() {
            // Behind the hello at once, so that the first tick is reported already.
            self.watched = self.needed();
            self.send(&Frame::Watch(Watch { every: self.watched, parts: PARTS }))?;
        } else {
            self.send(&Frame::Lines(self.lines))?;
        }
        let live = self.arm.limbs.live(self.arm.payload).map_err(ChipError::from)?;
        self.send(&Frame::Live(live))
    }

    /// A hello of the board.
    pub(super) fn greeted(&mut self, theirs: Hello) -> Result<(), Stop> {
        let own = self.arm.hello;
        if (Hello { pacing: own.pacing, ..theirs }) != own {
            return Err(ChipError::OtherRobot { expected: own, found: theirs }.into());
        }
        match theirs.pacing == own.pacing {
            true => self.agreed = true,
            // What a board says when it has started.
            false if self.agreed && self.is_live() => return Err(StationError::StartedAnew.into()),
            false => {}
        }
        Ok(())
    }

    /// How often the board has to report, in ticks.
    fn needed(&mut self) -> u16 {
        if self.station.tap().is_recording() {
            return 1;
        }
        let shown = (1.0 / (SHOWN * self.arm.period)).max(1.0) as u16;
        match u16::try_from(self.print.0) {
            Ok(every @ 1..) => shown.min(every),
            _ => shown,
        }
    }

    /// Have the board report every so many ticks. A drill reports every tick anyway.
    fn watch(&mut self, every: u16) -> Result<(), Stop> {
        if !self.is_live() || self.watched == every {
            return Ok(());
        }
        self.watched = every;
        self.send(&Frame::Watch(Watch { every, parts: PARTS }))
    }

    /// Let time pass until the board has taken what was sent last.
    pub(super) fn until_taken(&mut self) -> Result<(), Stop> {
        let sent = self.station.tap().sent();
        let end = Instant::now() + SILENCE;
        while !self.status.as_ref().is_some_and(|status| has_taken(status, sent)) {
            if Instant::now() > end {
                return Err(StationError::Silent { what: "answer to a request", time: SILENCE }.into());
            }
            self.pass()?;
        }
        Ok(())
    }

    /// Ask, and hear why not.
    pub(super) fn request(&mut self, request: Request) -> Result<Option<Denial>, Stop> {
        // Only the tick that took it says so.
        self.watch(1)?;
        (self.asking, self.denial) = (true, None);
        self.send(&Frame::Request(request))?;
        let taken = self.until_taken();
        self.asking = false;
        taken?;
        let needed = self.needed();
        self.watch(needed)?;
        Ok(self.denial.take())
    }

    /// What came of a request, in words.
    pub(super) fn answer(&mut self, name: &str, denial: Option<Denial>, granted: &str) -> Result<(), Stop> {
        let text = match (denial, &self.status) {
            (Some(denial), _) => {
                self.refused = true;
                format!("{name}: {}", words::denial(&denial))
            }
            (None, Some(status)) => {
                let homed = if status.state == 0 && status.homed { ", homed" } else { "" };
                format!("{name}: {}{homed}{granted}", words::doing(status))
            }
            (None, None) => name.to_owned(),
        };
        self.say(name, &text)
    }

    fn ask(&mut self, request: Request) -> Result<(), Stop> {
        let name = Request::NAMES.iter().find(|(other, _)| *other == request).map_or("request", |(_, name)| *name);
        let denial = if request == Request::Disarm { self.disarm()? } else { self.request(request)? };
        self.answer(name, denial, "")
    }

    /// Take the torque away as soon as the arm rests.
    fn disarm(&mut self) -> Result<Option<Denial>, Stop> {
        let mut left = REST;
        loop {
            match self.request(Request::Disarm)? {
                Some(Denial { code: NOT_AT_REST, .. }) if left > 0.0 && self.state() != Some(RUNNING) => {
                    self.wait(LOOK)?
                }
                other => return Ok(other),
            }
            left -= LOOK;
        }
    }

    /// Let so many seconds of the board's time pass.
    pub(super) fn wait(&mut self, seconds: f64) -> Result<(), Stop> {
        let tick = |operator: &Self| operator.status.as_ref().map_or(0, |status| status.tick);
        let (begin, ticks) = (tick(self), (seconds / self.arm.period).round());
        while f64::from(tick(self).wrapping_sub(begin)) < ticks {
            self.step()?;
        }
        Ok(())
    }

    /// Let time pass until the motion has ended, one way or another.
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
            _ => format!("wait: {}", self.status.as_ref().map(words::doing).unwrap_or_default()),
        };
        self.say("wait", &text)
    }

    /// Time that passes while nothing is asked for.
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

    /// Nothing passes, and nobody has pressed Ctrl-C.
    ///
    /// # Errors
    /// [`Stop::Interrupted`].
    pub fn unless_interrupted(&self) -> Result<(), Stop> {
        if self.presses.load(Ordering::Relaxed) > self.seen { Err(Stop::Interrupted) } else { Ok(()) }
    }

    /// What was typed makes no command, or asks for what cannot be.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn complain(&self, problem: &str) -> Result<(), Stop> {
        self.say("input", problem)
    }

    /// Do what was typed; whether that was the end.
    ///
    /// # Errors
    /// See [`Stop`]. What the board refuses is no error.
    pub fn obey(&mut self, command: Command) -> Result<bool, Stop> {
        match command {
            Command::Nothing => {}
            Command::Quit => return Ok(true),
            Command::Help => {
                let lines: Vec<_> = HELP.iter().map(|(usage, what)| format!("  {usage:<26} {what}")).collect();
                self.say("help", &lines.join("\n"))?;
            }
            Command::Status => {
                let text = self.seen_now().map(|seen| seen.text()).unwrap_or_default();
                self.say("status", &text)?;
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
            Command::EmergencyStop(pressed) => self.emergency_stop(pressed)?,
        }
        Ok(false)
    }

    fn emergency_stop(&mut self, pressed: bool) -> Result<(), Stop> {
        let name = if pressed { "press" } else { "release" };
        if self.is_live() {
            self.refused = true;
            return self.say(name, &format!("{name}: refused: the board has an emergency stop of its own"));
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
        let end = Instant::now() + SILENCE;
        let past = loop {
            self.pass()?;
            if let Some(past) = self.whole.take() {
                break past;
            }
            if Instant::now() > end {
                return Err(StationError::Silent { what: "black box", time: SILENCE }.into());
            }
        };
        let text = match file {
            None => format!("dump: {} ticks\n{}", past.len(), table::table(&past, &self.joint_names())),
            Some(file) => {
                table::write_csv(&past, self.arm.joints.len(), file).map_err(|error| in_file(file, &error))?;
                format!("dump: {} ticks, {}", past.len(), file.display())
            }
        };
        self.say("dump", &text)
    }

    /// The black box has been told.
    pub(super) fn past_is_whole(&mut self) {
        self.whole = Some(self.past.take().unwrap_or_default());
    }

    fn record(&mut self, file: Option<&Path>) -> Result<(), Stop> {
        let Some(file) = file else {
            self.station.tap().record(None)?;
            let needed = self.needed();
            self.watch(needed)?;
            return self.say("record", "record: off");
        };
        if self.drives() {
            self.refused = true;
            let why =
                "record: refused: torque acts, and a record begins with a hello, which takes it away; `disarm` first";
            return self.say("record", why);
        }
        self.keep(file)?;
        self.begin()?;
        self.say("record", &format!("record: {}; a new session, not homed", file.display()))
    }

    /// Keep every frame from here on. [`Operator::begin`] comes next.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn keep(&mut self, file: &Path) -> Result<(), Stop> {
        let open = || {
            let writer = Writer::new(BufWriter::new(File::create(file)?), &self.arm.head)?;
            Ok::<_, io::Error>(writer)
        };
        let writer = open().map_err(|error| in_file(file, &error))?;
        Ok(self.station.tap().record(Some(writer))?)
    }

    /// Stop, wait for rest, and take the torque away.
    ///
    /// # Errors
    /// The board is of no use any more; Ctrl-C once more.
    pub fn end(&mut self) -> Result<(), Stop> {
        self.seen = self.presses.load(Ordering::Relaxed);
        if self.state() == Some(RUNNING) {
            self.ask(Request::Hold)?;
        }
        if matches!(self.state(), Some(HOMING | ARMED | HOLDING)) {
            self.ask(Request::Disarm)?;
        }
        Ok(())
    }

    /// Close the record.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn close(&mut self) -> io::Result<()> {
        self.report.still();
        self.station.tap().record(None)
    }
}

fn in_file(file: &Path, error: &io::Error) -> Stop {
    Stop::Output(io::Error::other(format!("{}: {error}", file.display())))
}
