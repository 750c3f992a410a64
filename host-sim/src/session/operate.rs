//! An operator at a board: what is asked, what came of it, and the points of a motion kept ahead of the arm.
//!
//! ```text
//! console -> command -> operator <-> station: a board on a serial port, or a drill with a simulated arm
//!                          |            `-- tap: every frame, counted and kept in a record
//!                          `-> report
//! ```
//!
//! What a board has taken it says itself: every status has the number of frames that had been taken before its tick. A request is
//! answered by the first tick that had taken it, and the room for points by the last status less those that are still under way.
//!
//! | module | holds |
//! |---|---|
//! | [`station`] | a board, or what stands in its place |
//! | [`in_drill`], [`on_wire`] | the two that there are |
//! | [`command`] | what an operator types |
//! | [`console`] | where that comes from |
//! | `converse` | every line of it obeyed |
//! | `arm` | what depends on the arm, and on the number of its joints |
//! | [`feed`] | motions as points |
//! | [`parameters`] | what can be read back and changed, by name |
//! | [`words`] | the numbers of the protocol in words |
//! | [`report`], [`table`] | what an operator is told |

pub mod command;
pub mod console;
pub(crate) mod converse;
pub mod feed;
pub mod in_drill;
pub mod on_wire;
pub mod parameters;
pub mod report;
pub mod station;
pub mod table;
pub mod words;

mod arm;
mod moves;
mod session;

use crate::chip::ChipError;
use crate::session::frame_log::Head;
use crate::session::states::{ARMED, FAULT, HOLDING, RUNNING};
use ::session::trajectory::WAYS;
use arm::Arm;
use dynamics_core::Model;
use feed::Feed;
use link::{Denial, Frame, Lines, Pacing, Refusal, Status, Value};
use report::{Report, Seen};
use robot_compiler::SceneFile;
use station::{Station, StationError};
use std::collections::VecDeque;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// How long a board may say nothing that it was asked for.
pub const SILENCE: Duration = Duration::from_secs(2);

/// Why a command was not carried out to its end.
#[derive(Debug, thiserror::Error)]
pub enum Stop {
    /// The board is of no use any more.
    #[error(transparent)]
    Board(#[from] StationError),
    /// What was asked for cannot be.
    #[error("{0}")]
    Input(String),
    /// Ctrl-C.
    #[error("interrupted")]
    Interrupted,
    /// Standard output cannot be written.
    #[error(transparent)]
    Output(#[from] io::Error),
}

impl From<ChipError> for Stop {
    fn from(error: ChipError) -> Self {
        Self::Board(error.into())
    }
}

/// How often somebody has pressed Ctrl-C.
pub type Presses = Arc<AtomicU32>;

/// An operator at a board.
pub struct Operator {
    station: Box<dyn Station>,
    arm: Arm,
    report: Report,
    presses: Presses,
    /// Presses that were seen to.
    seen: u32,
    status: Option<Status>,
    heard: Instant,
    q: Option<Vec<f64>>,
    feed: Feed,
    /// Points on their way, as the number of frames that had been sent with each.
    under_way: VecDeque<u16>,
    /// Where the arm is to be when all that was asked for is done.
    goal: Option<Vec<f64>>,
    /// What the board reports now, in ticks.
    watched: u16,
    /// Print a status every so many ticks, and the tick of the last one.
    print: (u64, u32),
    /// Lines of the board that this program plays.
    lines: Lines,
    /// What the black box has said so far, while it speaks.
    past: Option<Vec<Status>>,
    /// All that it had to say.
    whole: Option<Vec<Status>>,
    /// What was said to questions that are answered by a value or a refusal, while one is under way.
    expected: Option<Vec<Result<Value, Refusal>>>,
    /// A request is under way: what changes is its answer.
    asking: bool,
    /// Why it was not granted.
    denial: Option<Denial>,
    /// Something was refused.
    refused: bool,
    agreed: bool,
}

impl Operator {
    /// An operator who has said nothing yet.
    ///
    /// # Errors
    /// A scene whose motion or payload cannot be.
    pub fn new<const N: usize>(
        station: Box<dyn Station>,
        scene: &SceneFile,
        model: &Model<f64, N>,
        head: Head,
        report: Report,
        presses: Presses,
    ) -> Result<Self, Stop> {
        let hello = crate::chip::hello(scene, model, station.pacing());
        let arm = Arm::new(scene, model, head, hello)?;
        let lines = Lines::CALM;
        Ok(Self {
            feed: Feed::new(arm.period),
            station,
            arm,
            report,
            seen: presses.load(Ordering::Relaxed),
            presses,
            status: None,
            heard: Instant::now(),
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
            denial: None,
            refused: false,
            agreed: false,
        })
    }

    /// Names of the joints, base first.
    pub fn joint_names(&self) -> Vec<String> {
        self.arm.joints.iter().map(|(name, ..)| name.clone()).collect()
    }

    /// Whether something was refused, or a fault stands.
    pub fn is_content(&self) -> bool {
        !self.refused && self.state() != Some(FAULT)
    }

    /// Whether time passes by itself.
    pub fn is_live(&self) -> bool {
        self.station.pacing() == Pacing::Live
    }

    /// Whether a motion is under way.
    pub fn is_moving(&self) -> bool {
        let pending = self.status.as_ref().is_some_and(|status| usize::from(status.room) < WAYS);
        self.state() == Some(RUNNING) && (pending || !self.feed.is_empty() || !self.under_way.is_empty())
    }

    /// Where a person looks.
    pub fn report(&self) -> &Report {
        &self.report
    }

    fn state(&self) -> Option<u8> {
        self.status.as_ref().map(|status| status.state)
    }

    /// Whether torque acts.
    fn drives(&self) -> bool {
        matches!(self.state(), Some(ARMED | RUNNING | HOLDING))
    }

    /// Let time pass: points are sent, what the board says is taken.
    ///
    /// # Errors
    /// The board is of no use any more; Ctrl-C.
    pub fn step(&mut self) -> Result<(), Stop> {
        self.unless_interrupted()?;
        self.pass()
    }

    /// As [`Operator::step`], whoever presses what.
    fn pass(&mut self) -> Result<(), Stop> {
        self.fill()?;
        for frame in self.station.pass()? {
            self.take(frame)?;
        }
        if self.heard.elapsed() > SILENCE {
            return Err(StationError::Silent { what: "status", time: SILENCE }.into());
        }
        if let Some(seen) = self.seen_now().as_ref().filter(|_| self.is_moving()) {
            self.report.live(seen);
        }
        Ok(())
    }

    /// What the last status says.
    fn seen_now(&self) -> Option<Seen<'_>> {
        let status = self.status.as_ref()?;
        let q = self.q.as_deref();
        Some(Seen { status, q, joints: &self.arm.joints, period: self.arm.period })
    }

    fn take(&mut self, frame: Frame) -> Result<(), Stop> {
        match frame {
            // Before the hellos agree a status is one of the session before.
            Frame::Status(status) if self.agreed => self.told(status)?,
            Frame::Past(Some(status)) => self.past.get_or_insert_default().push(status),
            Frame::Past(None) => self.past_is_whole(),
            Frame::Value(value) => {
                if let Some(answers) = &mut self.expected {
                    answers.push(Ok(value));
                }
            }
            Frame::Refusal(refusal) => {
                if let Some(answers) = &mut self.expected {
                    answers.push(Err(refusal));
                    return Ok(());
                }
                self.refused = true;
                self.say("refusal", &words::frame(&refusal))?;
            }
            Frame::Hello(theirs) => self.greeted(theirs)?,
            _ => {}
        }
        Ok(())
    }

    fn told(&mut self, status: Status) -> Result<(), Stop> {
        self.heard = Instant::now();
        while self.under_way.front().is_some_and(|&sent| has_taken(&status, sent)) {
            self.under_way.pop_front();
        }
        let sensed = status.sensed.as_ref().map(|sensed| &sensed.sensed).or(self.station.reading());
        if let Some(q) = sensed.and_then(|sensed| self.arm.limbs.positions(sensed)) {
            self.q = Some(q);
        }
        self.denial = status.refused.filter(|_| self.asking).or(self.denial.take());
        let before = self.status.replace(status);
        let Some(status) = &self.status else { return Ok(()) };
        let doing = |status: &Status| (status.state, status.cause, status.joint);
        let changed = before.as_ref().is_some_and(|before| doing(before) != doing(status));
        if changed && before.is_some_and(|before| before.state == RUNNING) {
            // The board has forgotten its trajectory.
            self.feed.clear();
            self.under_way.clear();
            self.goal = None;
        }
        if changed && !self.asking {
            let text = format!("tick {}: {}", status.tick, words::doing(status));
            self.report.say("change", &text, self.seen_now().as_ref())?;
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

    fn say(&self, about: &str, text: &str) -> Result<(), Stop> {
        Ok(self.report.say(about, text, self.seen_now().as_ref())?)
    }

    fn send(&mut self, frame: &Frame) -> Result<(), Stop> {
        Ok(self.station.send(frame)?)
    }
}

/// Whether so many frames had been taken before this tick.
fn has_taken(status: &Status, sent: u16) -> bool {
    status.taken.wrapping_sub(sent) < 0x8000
}
