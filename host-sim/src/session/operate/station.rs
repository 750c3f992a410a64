//! Where an operator's frames go: the one thing that a board on a serial port and a drill do differently.

use crate::chip::ChipError;
use crate::plant::Diverged;
use crate::session::frame_log::{Way, Writer};
use crate::session::serial::SerialError;
use link::{Frame, Pacing, Sensed};
use std::fs::File;
use std::io::{self, BufWriter};
use std::time::Duration;

/// A board, or what stands in its place.
pub trait Station {
    /// What starts a tick there.
    fn pacing(&self) -> Pacing;

    /// Send a frame.
    ///
    /// # Errors
    /// The board cannot be reached, or a record cannot be written.
    fn send(&mut self, frame: &Frame) -> Result<(), StationError>;

    /// Let time pass, and the board know that somebody is there: what it has said meanwhile. In a drill one tick passes; on a
    /// wire it takes a few milliseconds at most.
    ///
    /// # Errors
    /// As [`Station::send`]; a simulated arm that cannot be followed any further.
    fn pass(&mut self) -> Result<Vec<Frame>, StationError>;

    /// The last reading, where it is this side that makes it.
    fn reading(&self) -> Option<&Sensed> {
        None
    }

    /// What listens to every frame.
    fn tap(&mut self) -> &mut Tap;
}

/// Why a board is of no use.
#[derive(Debug, thiserror::Error)]
pub enum StationError {
    /// The emulated chip.
    #[error(transparent)]
    Chip(#[from] ChipError),
    /// The serial port.
    #[error(transparent)]
    Serial(#[from] SerialError),
    /// The simulated arm.
    #[error("the simulated arm cannot be followed further: {0}")]
    Diverged(Diverged),
    /// The board says nothing.
    #[error("the board is silent: no {what} came within {time:?}")]
    Silent {
        /// What was waited for.
        what: &'static str,
        /// How long.
        time: Duration,
    },
    /// It has started anew, and knows nothing of this session.
    #[error("the board has started anew: its zeros and its trajectory are gone; connect again")]
    StartedAnew,
    /// A record of the session.
    #[error("the record cannot be written: {0}")]
    Record(#[from] io::Error),
}

/// Listens to every frame: counts those that were sent, as the board does, and keeps them in a file where one is open.
#[derive(Debug, Default)]
pub struct Tap {
    sent: u16,
    log: Option<Writer<BufWriter<File>>>,
}

impl Tap {
    /// Frames sent since the last hello, modulo 65,536.
    #[must_use]
    pub fn sent(&self) -> u16 {
        self.sent
    }

    /// Whether a record is kept.
    #[must_use]
    pub fn is_recording(&self) -> bool {
        self.log.is_some()
    }

    /// Keep a record from now on, or none any more; the one before is closed.
    ///
    /// # Errors
    /// What was kept in memory cannot be written.
    pub fn record(&mut self, log: Option<Writer<BufWriter<File>>>) -> io::Result<()> {
        match core::mem::replace(&mut self.log, log) {
            Some(mut before) => before.flush(),
            None => Ok(()),
        }
    }

    /// A frame was sent.
    pub(super) fn hear_sent(&mut self, at: Duration, frame: &Frame) -> io::Result<()> {
        // A board counts afresh behind a hello.
        self.sent = if matches!(frame, Frame::Hello(_)) { 0 } else { self.sent.wrapping_add(1) };
        self.keep(Way::Sent, 0, at, frame)
    }

    /// Packets were lost on the way to the board: it has not counted them.
    fn lost(&mut self, missed: u8) {
        self.sent = self.sent.wrapping_sub(missed.into());
    }

    /// A frame was received.
    pub(super) fn hear_received(&mut self, missed: u8, at: Duration, frame: &Frame) -> io::Result<()> {
        if let Frame::Refusal(link::Refusal::Lost { missed }) = frame {
            self.lost(*missed);
        }
        self.keep(Way::Received, missed, at, frame)
    }

    fn keep(&mut self, way: Way, missed: u8, at: Duration, frame: &Frame) -> io::Result<()> {
        match &mut self.log {
            Some(log) => log.push(way, missed, at, frame),
            None => Ok(()),
        }
    }
}
