//! A serial port to a board, as whole frames.
//!
//! Every wait here has a limit: the caller gives [`SerialLink::receive`] its timeout, and sending has [`SEND_TIMEOUT`].
//! Opening a port sends the board only one zero byte, which ends a packet that another program may have left half sent.

use link::codec::FrameTooLong;
use link::{DecodeError, Decoder, Encoder, Frame, Received};
use serialport::{ClearBuffer, ErrorKind, SerialPort};
use std::io;
use std::ops::Range;
use std::time::{Duration, Instant};

/// Baud rate of the boards' serial port (`firmware/src/boards/f405.rs`).
pub const BAUD: u32 = 1_000_000;

/// Timeout for sending. A packet of the greatest length takes 1.2 ms at [`BAUD`], so only a stuck driver reaches it.
pub const SEND_TIMEOUT: Duration = Duration::from_secs(1);

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
    /// A frame that cannot be sent.
    #[error(transparent)]
    TooLong(#[from] FrameTooLong),
}

impl SerialError {
    /// Whether the port exists but this user may not open it.
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
    /// Open a port and discard the bytes that it received before.
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

    /// The next frame, with the number of packets lost before it; `None` if no complete frame came within `timeout`.
    ///
    /// # Errors
    /// [`SerialError::Undecodable`] for a packet that cannot be decoded: the next call continues after it. Any other
    /// error ends the link.
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
                // A signal to this program says nothing about the port; the same timeout keeps running.
                Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::Interrupted) => {}
                Err(error) => return Err(gone(error)),
            }
        }
    }
}

/// Distinguish an unplugged cable from other failures.
fn gone(error: io::Error) -> SerialError {
    match error.kind() {
        io::ErrorKind::BrokenPipe | io::ErrorKind::UnexpectedEof => SerialError::Gone,
        _ => SerialError::Io(error),
    }
}

#[cfg(all(test, unix))]
mod tests;
