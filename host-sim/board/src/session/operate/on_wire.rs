//! A board on a serial port as a device. The board's own timer paces it; time is wall-clock time.

use super::device::{Device, DeviceError, Tap, receive_all};
use crate::chip::ChipError;
use crate::session::serial::{JOIN_SILENCE, SerialError, SerialLink};
use link::{Frame, Key, Pacing, Refusal, Trust};
use std::time::{Duration, Instant};

/// Interval of signs of life to the board if nothing else is sent. The default of a scene's `heartbeat_ms` is 100.
pub const ALIVE_EVERY: Duration = Duration::from_millis(20);

/// A board on a serial port.
pub struct OnWire {
    link: SerialLink,
    begun: Instant,
    sent: Instant,
    tap: Tap,
}

impl OnWire {
    /// Joins the board at an open port, with the key if there is one. Also returns which key the board has. A board without a key cannot arm, so it
    /// is rejected.
    ///
    /// # Errors
    /// A board that is silent, has no key, or has another one.
    pub fn join(mut link: SerialLink, key: Option<Key>) -> Result<(Self, Trust), DeviceError> {
        let Some(challenge) = link.join(key)? else {
            return Err(DeviceError::Silent { what: "answer to a join", time: JOIN_SILENCE });
        };
        if challenge.trust == Trust::NoKey {
            return Err(ChipError::Refused(Refusal::NoKey).into());
        }
        let now = Instant::now();
        Ok((Self { link, begun: now, sent: now, tap: Tap::default() }, challenge.trust))
    }
}

impl Device for OnWire {
    fn pacing(&self) -> Pacing {
        Pacing::Live
    }

    fn send(&mut self, frame: &Frame) -> Result<(), DeviceError> {
        self.link.send(frame)?;
        self.sent = Instant::now();
        Ok(self.tap.hear_sent(self.begun.elapsed(), frame)?)
    }

    fn pass(&mut self) -> Result<Vec<Frame>, DeviceError> {
        if self.sent.elapsed() >= ALIVE_EVERY {
            self.send(&Frame::Alive)?;
        }
        let link = &mut self.link;
        receive_all(&mut self.tap, self.begun, |wait| {
            loop {
                match link.receive(wait) {
                    // The next packet reveals how many were lost before it, and the record keeps that number.
                    Err(SerialError::Undecodable(_)) => {}
                    other => return Ok(other?),
                }
            }
        })
    }

    fn now(&self) -> Duration {
        self.begun.elapsed()
    }

    fn tap(&mut self) -> &mut Tap {
        &mut self.tap
    }
}
