//! A serial port to a board, for whole frames.
//!
//! Every wait here has a limit: the caller gives [`SerialLink::receive`] its timeout, and sending has [`SEND_TIMEOUT`]. Opening a port sends only one
//! zero byte, which ends a packet that another program may have left half sent.

use crate::can::adapter_name::port_advice;
use crate::key::{self, KeyError};
use link::codec::FrameTooLong;
use link::{Challenge, DecodeError, Distrust, Frame, HostChannel, Key, Received};
use serialport::{ClearBuffer, ErrorKind, SerialPort};
use std::io;
use std::ops::Range;
use std::time::{Duration, Instant};

/// Baud rate of the boards' serial port (`firmware/src/boards/f405.rs`).
pub const BAUD: u32 = 1_000_000;

/// Timeout for sending. A packet of the greatest length takes 1.2 ms at [`BAUD`], so only a stuck driver reaches it.
pub const SEND_TIMEOUT: Duration = Duration::from_secs(1);

/// Number of joins sent to a board that does not answer, and the timeout of each: at [`BAUD`] an answer takes a millisecond.
const JOINS: u32 = 5;
const JOIN_MS: u64 = 400;
const JOIN_TIMEOUT: Duration = Duration::from_millis(JOIN_MS);

/// Time after which a board counts as silent.
pub const JOIN_SILENCE: Duration = Duration::from_millis(JOINS as u64 * JOIN_MS);

/// Reason why a port cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SerialError {
    /// The port cannot be opened.
    #[error("serial port {path}: {source}")]
    Open {
        /// The port's name, as given.
        path: String,
        /// Error of the system.
        source: serialport::Error,
    },
    /// The open port failed.
    #[error("serial port: {0}")]
    Io(#[from] io::Error),
    /// The other end is gone: unplugged, or a closed terminal.
    #[error("serial port: the other end is gone")]
    Gone,
    /// A packet could not be decoded. Later packets can still be read.
    #[error("from the board: {0}")]
    Undecodable(#[from] DecodeError),
    /// The board's key does not match this host's key, or only one of the two has a key.
    #[error("{0}")]
    Distrust(#[from] Distrust),
    /// No random numbers are available.
    #[error(transparent)]
    Key(#[from] KeyError),
    /// A frame that cannot be sent.
    #[error(transparent)]
    TooLong(#[from] FrameTooLong),
}

impl SerialError {
    /// Advice for a port that cannot be opened or does not answer.
    #[must_use]
    pub fn advice(&self) -> &'static str {
        port_advice(self.is_forbidden())
    }

    /// True if the port exists but this user may not open it.
    fn is_forbidden(&self) -> bool {
        let Self::Open { source, .. } = self else { return false };
        source.kind() == ErrorKind::Io(io::ErrorKind::PermissionDenied)
    }
}

/// An open port with the state of the codec in both directions.
pub struct SerialLink {
    port: Box<dyn SerialPort>,
    channel: HostChannel,
    buffer: [u8; 512],
    unread: Range<usize>,
}

impl SerialLink {
    /// Opens a port and discards the bytes that it received before.
    ///
    /// # Errors
    /// [`SerialError::Open`]: the port does not exist, it is in use, or this user may not open it.
    pub fn open(path: &str, baud: u32) -> Result<Self, SerialError> {
        let open = || {
            let mut port = serialport::new(path, baud).timeout(SEND_TIMEOUT).open()?;
            port.clear(ClearBuffer::Input)?;
            port.write_all(&[0])?;
            Ok(port)
        };
        let port = open().map_err(|source| SerialError::Open { path: path.to_owned(), source })?;
        Ok(Self { port, channel: HostChannel::new(None), buffer: [0; 512], unread: 0..0 })
    }

    /// Asks the board for its firmware and its key, several times; `None` if it is silent. Disturbs no session.
    ///
    /// # Errors
    /// The port failed, or nothing but packets came that cannot be decoded.
    pub fn find(&mut self, key: Option<Key>) -> Result<Option<Challenge>, SerialError> {
        self.channel = HostChannel::new(key);
        let mut unreadable = None;
        for _ in 0..JOINS {
            let packet = self.channel.join(key::random()?)?;
            self.write(&packet)?;
            let end = Instant::now() + JOIN_TIMEOUT;
            loop {
                match self.receive(end.saturating_duration_since(Instant::now())) {
                    Ok(Some(Received { frame: Frame::Challenge(challenge), .. })) => return Ok(Some(challenge)),
                    // Other frames were sent before the question.
                    Ok(Some(_)) => {}
                    Ok(None) => break,
                    Err(SerialError::Undecodable(error @ DecodeError::WrongVersion { .. })) => return Err(error.into()),
                    // The rest of an earlier packet.
                    Err(SerialError::Undecodable(error)) => unreadable = Some(error),
                    Err(error) => return Err(error),
                }
                // Bytes may keep coming without an answer; the time limit ends the wait.
                if Instant::now() >= end {
                    break;
                }
            }
        }
        unreadable.map_or(Ok(None), |error| Err(error.into()))
    }

    /// Checks that the board's key matches this host's.
    ///
    /// # Errors
    /// [`Distrust`].
    pub fn check(&self, challenge: &Challenge) -> Result<(), Distrust> {
        self.channel.check(challenge)
    }

    /// Finds the board and begins a session with it. If the board has a key, it must be this one, and the session is sealed. `None` if the board is
    /// silent.
    ///
    /// # Errors
    /// As [`SerialLink::find`] and [`SerialLink::check`].
    pub fn join(&mut self, key: Option<Key>) -> Result<Option<Challenge>, SerialError> {
        let Some(challenge) = self.find(key)? else { return Ok(None) };
        if let Some(packet) = self.channel.answer(&challenge)? {
            self.write(&packet)?;
        }
        Ok(Some(challenge))
    }

    /// Sends a frame.
    ///
    /// # Errors
    /// The port failed or took no bytes for [`SEND_TIMEOUT`].
    pub fn send(&mut self, frame: &Frame) -> Result<(), SerialError> {
        let packet = self.channel.encode(frame)?;
        self.write(&packet)
    }

    fn write(&mut self, packet: &[u8]) -> Result<(), SerialError> {
        self.port.set_timeout(SEND_TIMEOUT).map_err(io::Error::from)?;
        self.port.write_all(packet).map_err(gone)
    }

    /// The next frame, with the number of packets lost before it; `None` if no complete frame came within `timeout`.
    ///
    /// # Errors
    /// [`SerialError::Undecodable`] for a packet that cannot be decoded: the next call continues after it. Any other
    /// error ends the link.
    pub fn receive(&mut self, timeout: Duration) -> Result<Option<Received>, SerialError> {
        let end = Instant::now() + timeout;
        loop {
            while let Some(at) = self.unread.next() {
                if let Some(received) = self.buffer.get(at).and_then(|&byte| self.channel.push(byte)) {
                    return Ok(Some(received?));
                }
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.port.set_timeout(left).map_err(io::Error::from)?;
            match self.port.read(&mut self.buffer) {
                Ok(0) => return Err(SerialError::Gone),
                Ok(count) => self.unread = 0..count,
                // A signal to this program is no failure of the port; the same timeout keeps running.
                Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::Interrupted) => {}
                Err(error) => return Err(gone(error)),
            }
        }
    }
}

/// Tells an unplugged cable from other failures.
fn gone(error: io::Error) -> SerialError {
    match error.kind() {
        io::ErrorKind::BrokenPipe | io::ErrorKind::UnexpectedEof => SerialError::Gone,
        _ => SerialError::Io(error),
    }
}

#[cfg(all(test, unix))]
mod tests;
