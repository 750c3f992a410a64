//! A serial port to a board, as whole frames.
//!
//! Nothing here waits without a bound: [`SerialLink::receive`] is given its time, and sending has [`SEND_TIMEOUT`]. Opening
//! a port tells the board nothing but one zero byte, which ends a packet that another program may have left half sent.

use link::codec::FrameTooLong;
use link::{DecodeError, Decoder, Encoder, Frame, Received};
use serialport::{ClearBuffer, ErrorKind, SerialPort};
use std::io;
use std::ops::Range;
use std::time::{Duration, Instant};

/// What the boards' serial port runs at (`firmware/src/boards/f405.rs`).
pub const BAUD: u32 = 1_000_000;

/// A packet of the greatest length takes 1.2 ms at [`BAUD`]; this is for a driver that is stuck.
pub const SEND_TIMEOUT: Duration = Duration::from_secs(1);

/// Why a port is of no use.
#[derive(Debug, thiserror::Error)]
pub enum SerialError {
    /// It cannot be opened.
    #[error("serial port {path}: {source}")]
    Open {
        /// The port, as it was named.
        path: String,
        /// What the system says.
        source: serialport::Error,
    },
    /// It failed while it was open.
    #[error("serial port: {0}")]
    Io(#[from] io::Error),
    /// The other end is gone: unplugged, or a terminal that was closed.
    #[error("serial port: the other end is gone")]
    Gone,
    /// A packet came that cannot be read. What comes after it can be.
    #[error("from the board: {0}")]
    Undecodable(#[from] DecodeError),
    /// A frame that cannot be sent.
    #[error(transparent)]
    TooLong(#[from] FrameTooLong),
}

impl SerialError {
    /// Whether the port is there but not open to this user.
    #[must_use]
    pub fn is_forbidden(&self) -> bool {
        let Self::Open { source, .. } = self else { return false };
        source.kind() == ErrorKind::Io(io::ErrorKind::PermissionDenied)
    }
}

/// An open port with the codec's state of both directions.
pub struct SerialLink {
    port: Box<dyn SerialPort>,
    encoder: Encoder,
    decoder: Decoder,
    buffer: [u8; 512],
    unread: Range<usize>,
}

impl SerialLink {
    /// Open a port. What it received before is thrown away.
    ///
    /// # Errors
    /// [`SerialError::Open`]: there is no such port, it is in use, or this user may not open it.
    pub fn open(path: &str, baud: u32) -> Result<Self, SerialError> {
        let open = || {
            let mut port = serialport::new(path, baud).timeout(SEND_TIMEOUT).open()?;
            port.clear(ClearBuffer::Input)?;
            port.write_all(&[0])?;
            Ok(port)
        };
        let port = open().map_err(|source| SerialError::Open { path: path.to_owned(), source })?;
        Ok(Self { port, encoder: Encoder::new(), decoder: Decoder::new(), buffer: [0; 512], unread: 0..0 })
    }

    /// Send a frame.
    ///
    /// # Errors
    /// The port failed or took no bytes for [`SEND_TIMEOUT`].
    pub fn send(&mut self, frame: &Frame) -> Result<(), SerialError> {
        let packet = self.encoder.encode(frame)?;
        self.port.set_timeout(SEND_TIMEOUT).map_err(io::Error::from)?;
        self.port.write_all(&packet).map_err(gone)
    }

    /// The next frame, with the number of packets lost before it; `None` when none was whole within `timeout`.
    ///
    /// # Errors
    /// [`SerialError::Undecodable`] for a packet that cannot be read: the next call goes on behind it. Any other error ends
    /// the link.
    pub fn receive(&mut self, timeout: Duration) -> Result<Option<Received>, SerialError> {
        let end = Instant::now() + timeout;
        loop {
            while let Some(at) = self.unread.next() {
                if let Some(received) = self.buffer.get(at).and_then(|&byte| self.decoder.push(byte)) {
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
                // A signal to this program says nothing about the port; the time that was given goes on.
                Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::Interrupted) => {}
                Err(error) => return Err(gone(error)),
            }
        }
    }
}

/// Tell a cable that was pulled from other failures.
fn gone(error: io::Error) -> SerialError {
    match error.kind() {
        io::ErrorKind::BrokenPipe | io::ErrorKind::UnexpectedEof => SerialError::Gone,
        _ => SerialError::Io(error),
    }
}

#[cfg(all(test, unix))]
mod tests;
