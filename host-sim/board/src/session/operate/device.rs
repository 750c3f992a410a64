//! Destination of an operator's frames. This interface holds the differences between a board on a serial port and a
//! dry run.

use crate::chip::ChipError;
use crate::session::frame_log::Direction;
use crate::session::frame_log::recorder::Recorder;
use crate::session::local::shared::ControlLoop;
use crate::session::serial::SerialError;
use link::{DriveFaultReport, Frame, Pacing, Received, Sensed};
use sim::plant::Diverged;
use std::io;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Timeout for an answer or a status of the board.
pub const SILENCE: Duration = Duration::from_secs(2);

/// A board, or a dry run in its place.
pub trait Device {
    /// The pacing: the event that starts a tick.
    fn pacing(&self) -> Pacing;

    /// Sends a frame.
    ///
    /// # Errors
    /// The board cannot be reached, or a record cannot be written.
    fn send(&mut self, frame: &Frame) -> Result<(), DeviceError>;

    /// Lets time pass, and sends the board a sign of life. Returns the frames received meanwhile. In a dry run one tick passes; on a serial port it
    /// takes a few milliseconds at most.
    ///
    /// # Errors
    /// As [`Device::send`]; also a simulated arm that has diverged.
    fn pass(&mut self) -> Result<Vec<Frame>, DeviceError>;

    /// Report of the first simulated drive with a fault, if this program simulates them.
    fn drive_fault(&self) -> Option<DriveFaultReport> {
        None
    }

    /// The last reading, if this program makes the readings.
    fn reading(&self) -> Option<&Sensed> {
        None
    }

    /// Time since the device was opened. It is simulated time if the device simulates time.
    fn now(&self) -> Duration;

    /// True if arm and time are simulated.
    fn is_simulated(&self) -> bool {
        self.pacing() == Pacing::DryRun
    }

    /// True if the cable between host and board is cut, in a simulation.
    fn is_cut(&self) -> bool {
        false
    }

    /// Presses or releases the emergency stop of a simulated board. Returns false if the device does not simulate it: a real board has its own, and
    /// in a dry run the operator sends it as one of its lines.
    fn press(&mut self, _pressed: bool) -> bool {
        false
    }

    /// Cuts a cable, or plugs it in again.
    ///
    /// # Errors
    /// The reason why this cable cannot be cut here.
    fn cut(&mut self, _what: Cut, _cut: bool) -> Result<(), String> {
        Err("only a simulated link can be cut: start `connect` with `--target desk --simulate-link`".into())
    }

    /// The control loop, if this program runs it.
    fn control_loop(&self) -> Option<Arc<dyn ControlLoop>> {
        None
    }

    /// The tap that sees every frame.
    fn tap(&mut self) -> &mut Tap;
}

/// Slows simulated time down to the pace of the clock, for a person at a terminal.
#[derive(Debug, Default)]
pub struct Pace(Option<Instant>);

impl Pace {
    /// A pace that follows the clock if `is_wanted`; otherwise time passes freely.
    #[must_use]
    pub fn new(is_wanted: bool) -> Self {
        Self(is_wanted.then(Instant::now))
    }

    /// Waits until the clock has reached this simulated time. A delay longer than [`CATCH_UP`] is not caught up.
    pub(super) fn keep(&mut self, simulated: Duration) {
        let Some(begun) = &mut self.0 else { return };
        let passed = begun.elapsed();
        if passed > simulated + CATCH_UP {
            *begun += passed.saturating_sub(simulated);
        }
        std::thread::sleep(simulated.saturating_sub(passed));
    }
}

/// Longest delay after which simulated time still catches up with the clock.
const CATCH_UP: Duration = Duration::from_millis(50);

/// A cable that can be cut in a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// Between host and board.
    Host,
    /// A bus at the board, counted from 0.
    Bus(usize),
    /// The cable of one joint's drive, counted from 0.
    Drive(usize),
}

/// Reason why a board cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// The emulated chip failed.
    #[error(transparent)]
    Chip(#[from] ChipError),
    /// The serial port failed.
    #[error(transparent)]
    Serial(#[from] SerialError),
    /// The simulated arm diverged.
    #[error("the simulated arm cannot be followed further: {0}")]
    Diverged(Diverged),
    /// The control thread of this program has ended.
    #[error("the control thread has ended; the drives' own timeouts stop the arm")]
    ControlEnded,
    /// The board is silent.
    #[error("the controller is silent: no {what} came within {time:?}")]
    Silent {
        /// The awaited answer.
        what: &'static str,
        /// Length of the wait.
        time: Duration,
    },
    /// The board has restarted and has lost this session.
    #[error("the board has started anew: its zeros and its trajectory are gone; connect again")]
    StartedAnew,
    /// The record of the session cannot be written.
    #[error("the record cannot be written: {0}")]
    Record(#[from] io::Error),
}

/// Time that [`Device::pass`] waits for a board that paces itself.
const SLICE: Duration = Duration::from_millis(5);

/// Limit on the frames read in one pass, so that a board that sends without pause does not block the host.
const FRAMES: usize = 64;

/// Receives the frames of a pass: waits for the first, and takes those that are there already. `receive` returns the next one within a time.
pub(crate) fn receive_all(
    tap: &mut Tap,
    begun: Instant,
    mut receive: impl FnMut(Duration) -> Result<Option<Received>, DeviceError>,
) -> Result<Vec<Frame>, DeviceError> {
    let mut frames = Vec::new();
    while frames.len() < FRAMES {
        let wait = if frames.is_empty() { SLICE } else { Duration::ZERO };
        let Some(received) = receive(wait)? else { break };
        tap.hear_received(received.missed, begun.elapsed(), &received.frame)?;
        frames.push(received.frame);
    }
    Ok(frames)
}

/// Tap that sees every frame. It counts sent frames as the board does, and writes all frames to a file if one is open.
#[derive(Debug, Default)]
pub struct Tap {
    sent: u16,
    /// Number of frames that the board reported as lost, and of the board's frames that were lost.
    lost: (u64, u64),
    /// True if the board may have lost more frames than it could report.
    lost_more: bool,
    log: Option<Recorder>,
}

impl Tap {
    /// Frames sent since the last hello, including those that were lost, modulo 65,536.
    #[must_use]
    pub fn sent(&self) -> u16 {
        self.sent
    }

    /// True if a record is open.
    #[must_use]
    pub fn is_recording(&self) -> bool {
        self.log.is_some()
    }

    /// Starts a record, or none; the previous record is closed.
    ///
    /// # Errors
    /// The buffered bytes of the previous record cannot be written.
    pub fn record(&mut self, log: Option<Recorder>) -> io::Result<()> {
        match core::mem::replace(&mut self.log, log) {
            Some(before) => before.close(),
            None => Ok(()),
        }
    }

    /// Counts and records a sent frame.
    pub(crate) fn hear_sent(&mut self, at: Duration, frame: &Frame) -> io::Result<()> {
        // A board restarts its count after a hello.
        self.sent = if matches!(frame, Frame::Hello(_)) { 0 } else { self.sent.wrapping_add(1) };
        self.keep(Direction::Sent, 0, at, frame)
    }

    /// Number of frames that the board reported as lost on the way to it, and of the board's frames that were lost.
    #[must_use]
    pub fn lost(&self) -> (u64, u64) {
        self.lost
    }

    /// True if the board may have lost more frames than [`Tap::lost`] returns: a report counts only to 255.
    #[must_use]
    pub fn lost_more(&self) -> bool {
        self.lost_more
    }

    /// Records a received frame.
    pub(super) fn hear_received(&mut self, missed: u32, at: Duration, frame: &Frame) -> io::Result<()> {
        if let Frame::Refusal(link::Refusal::Lost { missed }) = frame {
            self.lost.0 += u64::from(*missed);
            self.lost_more |= *missed == u8::MAX;
        }
        self.lost.1 += u64::from(missed);
        self.keep(Direction::Received, u8::try_from(missed).unwrap_or(u8::MAX), at, frame)
    }

    fn keep(&mut self, way: Direction, missed: u8, at: Duration, frame: &Frame) -> io::Result<()> {
        match &mut self.log {
            Some(log) => log.push(way, missed, at, frame),
            None => Ok(()),
        }
    }
}
