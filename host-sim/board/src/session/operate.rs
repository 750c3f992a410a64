//! An operator at a board: requests, their answers, and the points of a motion, sent ahead of the arm.
//!
//! ```text
//! console -> command -> operator <-> device: a board on a serial port, or a dry run with a simulated arm
//!                          |            `-- tap: every frame, counted and kept in a record
//!                          `-> report
//! ```
//!
//! A request is sent again until its answer has come (`requests`). Of other frames every status holds the number that had been taken
//! before its tick, or were lost before one that was taken. The room for points is the room in the last status less the points that are
//! still under way.
//!
//! | module | holds |
//! |---|---|
//! | [`device`] | interface of a board or a dry run |
//! | [`dry_run_device`], [`on_wire`], [`simulated_board`] | its implementations; [`wire`] loses frames |
//! | [`command`] | the commands that an operator types |
//! | [`console`], `keys` | the source of the commands: a script, a pipe or a terminal; the stop key |
//! | `reason` | the reasons why a command was not completed |
//! | `converse` | the loop that executes them line by line |
//! | `rejection` | the reason why a request had no effect |
//! | `greeting` | hellos: a session that begins, or one that is continued |
//! | `obey` | execution of a command, and its files |
//! | `requests` | requests until their answers, and frames that were lost |
//! | `moment` | the time of a stop |
//! | `stop` | the stop key and the command `stop` |
//! | `ending` | the end of torque: which joints sink, consent, parking |
//! | `arm` | the parts that depend on the arm, and on the number of its joints |
//! | `course` | a motion of an arm with any number of joints |
//! | [`motion_queue`] | motions as points, waiting to be sent |
//! | [`parameters`] | parameters by name: reading and changing them |
//! | `observed` | what was seen of the arm since homing |
//! | `first_motion` | limits of the first motion after homing |
//! | `heat` | heat of the motors, as last reported |
//! | `motor_heat` | heat of the motors, asked for in the background |
//! | `feel` | law, stiffness and payload of an armed arm, changed without a jump of torque |
//! | `samples` | positions and torques of the last ticks |
//! | `torque_check` | comparison of the drives' torque with the commanded torque |
//! | `torque_cause` | the likely cause of a difference |
//! | `weigh` | what the arm holds, from slow motions |
//! | [`messages`] | messages for the protocol's numbers |
//! | [`report`], [`table`] | output for the operator |

pub mod command;
pub mod console;
pub mod converse;
pub mod device;
pub mod dry_run_device;
pub mod messages;
pub mod motion_queue;
pub mod on_wire;
pub mod parameters;
pub mod report;
pub mod simulated_board;
pub mod table;
pub mod wire;

mod arm;
mod ending;
mod feel;
mod first_motion;
mod greeting;
mod heat;
mod keys;
mod moment;
mod motor_heat;
mod moves;
mod obey;
mod observed;
mod planned_motion;
mod reason;
mod rejection;
mod requests;
mod samples;
mod session;
mod stop;
mod torque_cause;
mod torque_check;
mod weigh;

use crate::session::frame_log::Head;
use ::session::trajectory::WAYS;
use arm::Arm;
use device::{Device, DeviceError, SILENCE};
use dynamics_core::Model;
use heat::MotorHeat;
pub use keys::Presses;
use link::StateCode;
use link::{Actuation, Answer, Frame, Lines, Pacing, Refusal, Status, Value, Verdict};
use moment::Moment;
use motion_queue::MotionQueue;
use observed::FirstMotion;
pub use reason::Stop;
use report::{Report, StatusView};
use robot_compiler::SceneFile;
use samples::{Sample, Samples};
use sim::output::Output;
use std::collections::VecDeque;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// An operator at a board.
pub struct Operator {
    device: Box<dyn Device>,
    arm: Arm,
    report: Report,
    presses: Presses,
    /// Number of presses already handled.
    seen: u32,
    /// Counter of presses of the stop key, if a user sits at a terminal, and the number already handled.
    stops: Option<Presses>,
    stops_seen: u32,
    /// The stop key is being handled, and does not interrupt its own handling.
    deaf: bool,
    /// The last stop, and true if a stop came since the last motion began.
    stopped_at: Option<Moment>,
    /// Text to be shown once the request has been sent.
    announcement: Option<&'static str>,
    stopped: bool,
    status: Option<Status>,
    /// Time since which the board has to be heard: of the last status, of a hello, or of a cable that was cut or plugged in.
    heard: Duration,
    /// Time of the last status.
    reported: Duration,
    /// Statuses received.
    statuses: u64,
    /// Time when the live inputs were sent last by the clock.
    live_sent: Duration,
    q: Option<Vec<f64>>,
    feed: MotionQueue,
    /// Points on their way: for each, the number of frames sent up to and including it.
    under_way: VecDeque<u16>,
    /// Position of the arm after all requested motions.
    goal: Option<Vec<f64>>,
    /// Interval of the board's reports now, in ticks.
    watched: u16,
    /// Interval of the printed statuses, in ticks, and the tick of the last printed one.
    print: (u64, u32),
    /// State of the board's input lines, which this program simulates in a dry run.
    lines: Lines,
    /// Ticks of the black box received so far, while it is being dumped.
    past: Option<Vec<Status>>,
    /// All ticks of the black box, once it is complete.
    whole: Option<Vec<Status>>,
    /// Answers received so far to questions that expect a value or a refusal; `None` while no question is pending.
    expected: Option<Vec<Result<Value, Refusal>>>,
    /// A request is under way: a change of state is its answer.
    asking: bool,
    /// Number of the last request, and of the one whose answer is awaited.
    number: u8,
    awaited: u8,
    /// The board's verdict on it, and the number of statuses received before.
    verdict: Option<(Verdict, u64)>,
    /// A hold that is sent again and again until the arm no longer runs: its number, and the time when it was sent last.
    urgent: Option<(u8, Duration)>,
    /// True if anything was refused.
    refused: bool,
    agreed: bool,
    /// The board continues the session of an earlier host, and the payload that it holds has not been read yet.
    resumed: bool,
    /// The board was driving the arm when this program came.
    found_driven: bool,
    /// Replies of each joint's drive that were too old in a status, and the statuses with readings.
    stale: (Vec<u64>, u64),
    /// Smallest age of each joint's reading, ticks.
    age_min: Vec<u16>,
    /// The last ticks in which torque acted.
    samples: Samples,
    /// The torques of this arming have been judged.
    judged: bool,
    first_motion: FirstMotion,
    heat: MotorHeat,
    /// Files of `dump` and `record`.
    outputs: Output,
}

impl Operator {
    /// An operator that has not sent anything yet. The second scene has the motion of `run`.
    ///
    /// # Errors
    /// A scene whose motion or payload is not possible.
    pub fn new<const N: usize>(
        device: Box<dyn Device>,
        (scene, plays): (&SceneFile, &SceneFile),
        model: &Model<f64, N>,
        head: Head,
        report: Report,
        presses: Presses,
    ) -> Result<Self, Stop> {
        let hello = crate::chip::hello(scene, model, device.pacing());
        let arm = Arm::new(scene, plays, model, head, hello)?;
        let lines = Lines::CALM;
        Ok(Self {
            outputs: Output::default(),
            feed: MotionQueue::new(arm.period),
            report,
            heard: device.now(),
            reported: device.now(),
            device,
            arm,
            seen: presses.load(Ordering::Relaxed),
            stops: None,
            stops_seen: 0,
            deaf: false,
            stopped_at: None,
            announcement: None,
            stopped: false,
            presses,
            status: None,
            statuses: 0,
            live_sent: Duration::ZERO,
            q: None,
            under_way: VecDeque::new(),
            goal: None,
            watched: 0,
            print: (0, 0),
            lines,
            past: None,
            whole: None,
            expected: None,
            asking: false,
            number: 0,
            awaited: 0,
            verdict: None,
            urgent: None,
            refused: false,
            agreed: false,
            resumed: false,
            found_driven: false,
            stale: (Vec::new(), 0),
            age_min: Vec::new(),
            samples: Samples::default(),
            judged: false,
            first_motion: FirstMotion::default(),
            heat: MotorHeat::default(),
        })
    }

    /// Names of the joints, base first.
    pub fn joint_names(&self) -> Vec<String> {
        self.arm.joints.iter().map(|(name, ..)| name.clone()).collect()
    }

    /// True if nothing was refused and the board is not in a fault.
    pub fn is_content(&self) -> bool {
        !self.refused && self.state() != Some(StateCode::Fault)
    }

    /// True if time passes by itself, as it does on a real board.
    pub fn is_live(&self) -> bool {
        self.device.pacing() == Pacing::Live
    }

    /// True if a motion is under way.
    pub fn is_moving(&self) -> bool {
        let pending = self.status.as_ref().is_some_and(|status| usize::from(status.room) < WAYS);
        self.state() == Some(StateCode::Running) && (pending || !self.feed.is_empty() || !self.under_way.is_empty())
    }

    /// Output for the user.
    pub fn report(&self) -> &Report {
        &self.report
    }

    fn state(&self) -> Option<StateCode> {
        self.status.as_ref().map(|status| status.state)
    }

    /// True if the drives apply torque.
    fn drives(&self) -> bool {
        self.state().is_some_and(StateCode::has_torque)
    }

    /// Let time pass: send points, and receive frames of the board.
    ///
    /// # Errors
    /// The board can no longer be used; Ctrl-C.
    pub fn step(&mut self) -> Result<(), Stop> {
        self.unless_interrupted()?;
        self.pass()
    }

    /// As [`Operator::step`], regardless of Ctrl-C, but not of the stop key.
    fn pass(&mut self) -> Result<(), Stop> {
        if self.stop_pressed() {
            return Err(Stop::Pressed);
        }
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

    /// Sends the live inputs again before the board counts them as old.
    fn renew_live(&mut self) -> Result<(), Stop> {
        let Some(every) = self.arm.live_every else { return Ok(()) };
        if !self.agreed || self.resumed || self.silent_for(self.live_sent) < every {
            return Ok(());
        }
        self.live_sent = self.device.now();
        self.send_live()
    }

    /// The last status in the units of the arm.
    fn seen_now(&self) -> Option<StatusView<'_>> {
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

    /// State of the board in words, and a drive's report of a fault.
    fn doing(&self) -> String {
        self.seen_now().map(|seen| seen.doing()).unwrap_or_default()
    }

    fn take(&mut self, frame: Frame) -> Result<(), Stop> {
        match frame {
            // A status before the hellos agree belongs to the previous session.
            Frame::Status(status) if self.agreed => self.told(status)?,
            Frame::Past(Some(status)) => self.past.get_or_insert_default().push(status),
            Frame::Past(None) => self.past_is_whole(),
            Frame::Value(value) => {
                if self.takes_heat(&value) {
                    return Ok(());
                }
                // The answer to a question that was repeated may come twice.
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
            // The board goes on with somebody else's session.
            Frame::Refusal(refusal @ Refusal::Driven) if !self.agreed => {
                return Err(crate::chip::ChipError::Refused(refusal).into());
            }
            Frame::Refusal(Refusal::Lost { .. } | Refusal::Undecodable(_)) => self.frames_were_lost()?,
            // Only an older firmware does not know a parameter of this program: the heat of motors.
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

    fn told(&mut self, status: Status) -> Result<(), Stop> {
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
        let before = self.status.replace(status);
        let Some(status) = &self.status else { return Ok(()) };
        let doing = |status: &Status| (status.state, status.cause, status.joint);
        let changed = before.as_ref().is_some_and(|before| doing(before) != doing(status));
        if changed && before.is_some_and(|before| before.state == StateCode::Running) {
            // The board has forgotten its trajectory.
            self.feed.clear();
            self.under_way.clear();
            self.goal = None;
        }
        if changed && !self.asking {
            let text = format!("tick {}: {}", status.tick, self.doing());
            self.report.say("change", &text, self.seen_now().as_ref())?;
            if let (StateCode::Fault, Some((text, _))) = (status.state, self.torque_in_words()) {
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

    /// Counts readings that are older than the joint's youngest: in their tick the drive's reply was missing.
    fn count_stale(&mut self, ages: &[u16]) {
        self.age_min.resize(ages.len(), u16::MAX);
        self.stale.0.resize(ages.len(), 0);
        self.stale.1 += 1;
        for ((age, min), count) in ages.iter().zip(&mut self.age_min).zip(&mut self.stale.0) {
            *min = (*min).min(*age);
            *count += u64::from(*age > *min);
        }
    }

    /// Frames lost on the host link and replies missing on the drives' buses, in words; empty if there are none.
    fn losses(&mut self) -> String {
        let mut text = String::new();
        let (to_board, to_host) = self.device.tap().lost();
        if to_board > 0 || to_host > 0 {
            let least = if self.device.tap().lost_more() { "at least " } else { "" };
            text += &format!(
                "\nhost link: {least}{to_board} frames lost on the way to the board, {to_host} on the way back"
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

    /// Keep where the arm is and what it is told, as long as torque acts.
    fn sample(&mut self, status: &Status) {
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

    /// Time since a moment of the device's clock.
    fn silent_for(&self, since: Duration) -> Duration {
        self.device.now().saturating_sub(since)
    }

    fn say(&self, about: &str, text: &str) -> Result<(), Stop> {
        Ok(self.report.say(about, text, self.seen_now().as_ref())?)
    }

    fn send(&mut self, frame: &Frame) -> Result<(), Stop> {
        Ok(self.device.send(frame)?)
    }
}

/// True if the board had taken, or missed, the frame with number `sent` before this tick.
fn has_taken(status: &Status, sent: u16) -> bool {
    status.taken.wrapping_sub(sent) < 0x8000
}
