//! A board on a serial port as a station. Its own timer paces it; time is the wall's.

use super::station::{Station, StationError, Tap};
use crate::session::serial::{SerialError, SerialLink};
use link::{Frame, Pacing};
use std::time::{Duration, Instant};

/// How often the board hears of a host that has nothing else to say. A scene's `heartbeat_ms` is 100 where it does not say.
pub const ALIVE_EVERY: Duration = Duration::from_millis(20);

/// How long [`Station::pass`] waits for the board.
const SLICE: Duration = Duration::from_millis(5);

/// Most frames that are taken before somebody looks at them: a board that talks without end must not keep the host from its own turn.
const FRAMES: usize = 64;

/// A board on a serial port.
pub struct OnWire {
    link: SerialLink,
    begun: Instant,
    sent: Instant,
    tap: Tap,
}

impl OnWire {
    /// A board behind an open port. Nothing is said yet.
    #[must_use]
    pub fn new(link: SerialLink) -> Self {
        let now = Instant::now();
        Self { link, begun: now, sent: now, tap: Tap::default() }
    }
}

impl Station for OnWire {
    fn pacing(&self) -> Pacing {
        Pacing::Live
    }

    fn send(&mut self, frame: &Frame) -> Result<(), StationError> {
        self.link.send(frame)?;
        self.sent = Instant::now();
        Ok(self.tap.hear_sent(self.begun.elapsed(), frame)?)
    }

    fn pass(&mut self) -> Result<Vec<Frame>, StationError> {
        if self.sent.elapsed() >= ALIVE_EVERY {
            self.send(&Frame::Alive)?;
        }
        let mut frames = Vec::new();
        while frames.len() < FRAMES {
            let wait = if frames.is_empty() { SLICE } else { Duration::ZERO };
            match self.link.receive(wait) {
                Ok(Some(received)) => {
                    self.tap.hear_received(received.missed, self.begun.elapsed(), &received.frame)?;
                    frames.push(received.frame);
                }
                Ok(None) => break,
                // The next packet says how many are missing before it, and the record keeps that.
                Err(SerialError::Undecodable(_)) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(frames)
    }

    fn tap(&mut self) -> &mut Tap {
        &mut self.tap
    }
}
