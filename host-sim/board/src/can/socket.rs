//! SocketCAN of Linux.
//!
//! The interface returns each frame to the program once it was sent. So the program knows which frames still wait in the kernel, where nobody can take them
//! back: no further frame is sent until they have gone.

use super::adapter::{Adapter, UNSENT_MAX, keep_newest};
use super::frame::{CanFrame, id};
use embedded_can::Frame as _;
use socketcan::{CanError, CanSocket, Frame as _, Socket as _, SocketOptions as _};
use std::collections::VecDeque;
use std::fs::{File, TryLockError};
use std::io;

/// A network interface.
pub(super) struct Socket {
    socket: CanSocket,
    /// Frames that were handed over and have not come back.
    unsent: VecDeque<CanFrame>,
    /// Number of ticks that began with unsent frames.
    waiting: u32,
    off: bool,
    received: VecDeque<CanFrame>,
    /// Held as long as this program uses the interface.
    _lock: File,
}

impl Socket {
    /// Opens an interface. It must be up.
    ///
    /// # Errors
    /// There is no such interface, it is down, another `newtau` uses it, or the system has no SocketCAN.
    pub(super) fn open(name: &str) -> io::Result<Self> {
        let socket = CanSocket::open(name)?;
        let lock = lock(name)?;
        socket.set_nonblocking(true)?;
        socket.set_recv_own_msgs(true)?;
        // Bus-off, and the return from it.
        socket.set_error_filter_accept_all()?;
        let (unsent, received) = (VecDeque::new(), VecDeque::new());
        Ok(Self { socket, unsent, waiting: 0, off: false, received, _lock: lock })
    }

    /// Reads everything that has arrived: confirmations, errors and frames of others.
    fn read_all(&mut self) -> io::Result<()> {
        loop {
            let frame = match self.socket.read_frame() {
                Ok(socketcan::CanFrame::Data(frame)) => {
                    id(frame.raw_id(), frame.is_extended()).and_then(|id| CanFrame::new(id, frame.data()))
                }
                Ok(socketcan::CanFrame::Remote(frame)) => {
                    id(frame.raw_id(), frame.is_extended()).and_then(|id| CanFrame::new_remote(id, frame.dlc()))
                }
                Ok(socketcan::CanFrame::Error(frame)) => {
                    let error = CanError::from(frame);
                    self.off = (self.off || error.is_bus_off()) && !error.is_restarted();
                    continue;
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(()),
                Err(error) => {
                    // The interface is down or gone.
                    self.off = true;
                    return Err(error);
                }
            };
            let Some(frame) = frame else { continue };
            // No drive answers with a frame that is a command: the robot file's identifiers are checked for that.
            match self.unsent.iter().position(|sent| *sent == frame) {
                Some(place) => drop(self.unsent.remove(place)),
                None => keep_newest(&mut self.received, frame),
            }
        }
    }
}

/// Takes the interface for this program: a second one would send its own safe actions to the same drives.
fn lock(name: &str) -> io::Result<File> {
    let file = File::create(std::env::temp_dir().join(format!("newtau-{name}.lock")))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => {
            Err(io::Error::new(io::ErrorKind::ResourceBusy, "another newtau uses this interface"))
        }
        Err(TryLockError::Error(error)) => Err(error),
    }
}

impl Adapter for Socket {
    fn begin_tick(&mut self) {
        // An error is seen as an adapter that is off.
        let _ = self.read_all();
        self.waiting = if self.unsent.is_empty() { 0 } else { self.waiting + 1 };
        self.off |= self.waiting > UNSENT_MAX;
    }

    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        if self.waiting > 0 {
            return Err(io::ErrorKind::WouldBlock.into());
        }
        let made = match frame.is_remote_frame() {
            true => socketcan::CanFrame::new_remote(frame.id(), frame.dlc()),
            false => socketcan::CanFrame::new(frame.id(), frame.data()),
        };
        let sent = self.socket.write_frame(&made.ok_or(io::ErrorKind::InvalidInput)?);
        // A full queue of the interface is ENOBUFS.
        sent.map_err(|error| match error.raw_os_error() {
            Some(code) if code == rustix::io::Errno::NOBUFS.raw_os_error() => io::ErrorKind::WouldBlock.into(),
            _ => error,
        })?;
        self.unsent.push_back(*frame);
        Ok(())
    }

    fn receive(&mut self) -> io::Result<Option<CanFrame>> {
        // All at once, so that the newest are kept.
        self.read_all()?;
        Ok(self.received.pop_front())
    }

    fn is_off(&mut self) -> bool {
        self.off
    }
}
