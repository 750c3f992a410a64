//! Execution of a command, and its files.

use super::command::{Command, HELP};
use super::device::{Cut, SILENCE};
use super::{Operator, Stop, table};
use crate::session::frame_log::recorder::Recorder;
use link::{Frame, Request, StateCode};
use sim::output::Output;
use std::io;
use std::path::Path;
use std::time::Duration;

/// Age from which a status is old. A board that works reports at least every 20 ms.
const OLD: Duration = Duration::from_millis(200);

impl Operator {
    /// Executes a command. The main loop executes `disarm`, `quit` and `full-range`, because these may need an answer of the user.
    ///
    /// # Errors
    /// See [`Stop`]. A request that the board rejects is no error.
    pub(crate) fn obey(&mut self, command: Command) -> Result<(), Stop> {
        if self.interferes(&command) {
            self.refused = true;
            return self.say("follow", "rejected: the arm follows the targets of another program; `hold` first");
        }
        match command {
            Command::Nothing | Command::Disarm(_) | Command::Quit(_) | Command::FullRange => {}
            Command::Erase => {
                let rejection = self.request(Request::Release)?;
                self.answer("erase", rejection, "; the black box records again")?;
            }
            Command::Park => self.park()?,
            Command::Stop => {
                let before = self.stops_seen;
                self.stop()?;
                if self.stops_seen != before {
                    // Somebody else demanded a stop meanwhile: the lines that follow would move the arm again.
                    return Err(Stop::Interrupted);
                }
            }
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
            Command::Follow(patience) => self.follow(patience)?,
            Command::Wait(Some(seconds)) => self.wait(seconds)?,
            Command::Wait(None) => self.wait_for_the_end()?,
            Command::Watch(every) => {
                let tick = self.status.as_ref().map_or(0, |status| status.tick);
                self.print = (every, tick);
                self.watch_as_needed()?;
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

    /// Waits for a status if the last one is old, and reports it if none comes.
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
        self.say("status", &format!("the controller is not heard: this is its last report, {age:.1} s old"))
    }

    fn cut(&mut self, what: Cut, cut: bool) -> Result<(), Stop> {
        let name = if cut { "cut" } else { "plug" };
        let what_in_words = match what {
            Cut::Host => "host".to_owned(),
            Cut::Bus(bus) => format!("bus {}", bus + 1),
            Cut::Drive(joint) => format!("drive of {}", self.arm.joint(joint).0),
        };
        match self.device.cut(what, cut) {
            Ok(()) => {
                self.heard = self.device.now();
                self.say(name, &format!("{name}: {what_in_words}"))
            }
            Err(why) => self.reject(name, &why),
        }
    }

    /// Waits for the fault of the emergency stop. Statuses from before it may still be on their way.
    fn until_fault(&mut self) -> Result<(), Stop> {
        let end = self.device.now() + OLD;
        while self.state() != Some(StateCode::Fault) && self.device.now() < end {
            self.step()?;
        }
        Ok(())
    }

    fn emergency_stop(&mut self, pressed: bool) -> Result<(), Stop> {
        let name = if pressed { "press" } else { "release" };
        if self.device.press(pressed) {
            self.asking = true;
            let waited = if pressed { self.until_fault() } else { self.wait(2.0 * self.arm.period) };
            self.asking = false;
            waited?;
            return self.answer(name, None, "");
        }
        if self.is_live() {
            return self.reject(name, "this arm has an emergency stop of its own");
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
                return self.reject("dump", "the black box did not come whole; ask again");
            }
        };
        let text = match file {
            None => format!("dump: {} ticks\n{}", past.len(), table::table(&past, &self.joint_names())),
            Some(file) => {
                // On an error the session goes on: an arm must not fall because of a mistyped file name.
                let claimed = self.claim(file);
                let error = |error: io::Error| format!("{}: {error}", file.display());
                let written =
                    claimed.and_then(|()| table::write_csv(&past, self.arm.joints.len(), file).map_err(error));
                if let Err(problem) = written {
                    return self.reject("dump", &problem);
                }
                self.outputs.written(&[file.to_owned()]).ok();
                format!("dump: {} ticks, {}", past.len(), file.display())
            }
        };
        self.say("dump", &text)
    }

    /// Handles the end of the black box: all its ticks have arrived.
    pub(super) fn past_is_whole(&mut self) {
        self.whole = Some(self.past.take().unwrap_or_default());
    }

    fn record(&mut self, file: Option<&Path>) -> Result<(), Stop> {
        let Some(file) = file else {
            self.device.tap().record(None)?;
            self.watch_as_needed()?;
            return self.say("record", "record: off");
        };
        if self.drives() {
            let why = "the arm is driven, and a record begins with a new session; `disarm` first";
            return self.reject("record", why);
        }
        if let Err(problem) = self.claim(file) {
            return self.reject("record", &problem);
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

    /// Claims a file for `dump` or `record`. An error is returned as a text, because the session goes on.
    fn claim(&mut self, file: &Path) -> Result<(), String> {
        self.outputs.file(file).map_err(|failure| {
            let report = failure.report();
            report.help().map_or_else(|| report.to_string(), |help| format!("{report}; {help}"))
        })
    }

    /// Records every frame from here on. Call [`Operator::begin`] next.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn keep(&mut self, file: &Path) -> Result<(), Stop> {
        let recorder = Recorder::create(file, &self.arm.recorded).map_err(|error| in_file(file, &error))?;
        Ok(self.device.tap().record(Some(recorder))?)
    }

    /// Closes the record.
    ///
    /// # Errors
    /// The record cannot be written.
    pub fn close(&mut self) -> io::Result<()> {
        if let Some(shared) = &self.shared {
            shared.end();
        }
        self.report.still();
        self.device.tap().record(None)?;
        // If a file cannot be registered, a later command only refuses to replace it without `--force`.
        self.outputs.finish().ok();
        Ok(())
    }
}

fn in_file(file: &Path, error: &io::Error) -> Stop {
    Stop::Output(io::Error::other(format!("{}: {error}", file.display())))
}
