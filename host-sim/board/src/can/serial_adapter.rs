//! Adapters on a serial port: a thread reads; writing does not wait.

use super::adapter::{Adapter, UNSENT_MAX, keep_newest};
use super::frame::CanFrame;
use core::marker::PhantomData;
use serialport::{ClearBuffer, SerialPort};
use std::collections::VecDeque;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

/// Bytes as frames, and frames as bytes.
pub(super) trait Protocol: Default + Send + 'static {
    /// Bytes that join the bus.
    const BEGIN: &'static [u8];

    /// Appends the bytes of a frame.
    fn encode(frame: &CanFrame, bytes: &mut Vec<u8>);

    /// Reads a byte.
    fn push(&mut self, byte: u8) -> Parsed;
}

/// Result of a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parsed {
    /// More bytes are needed.
    Nothing,
    /// A frame was received.
    Frame(CanFrame),
    /// The adapter refused a command, or bytes are wrong.
    Error,
}

/// Time for which the thread waits for bytes before it looks whether it is to end.
const READ_TIMEOUT: Duration = Duration::from_millis(20);

/// An adapter with this protocol.
pub(super) struct SerialAdapter<P> {
    port: Box<dyn SerialPort>,
    shared: Arc<Shared>,
    /// Number of ticks that began with bytes that the port had not sent.
    waiting: u32,
    off: bool,
    bytes: Vec<u8>,
    protocol: PhantomData<P>,
}

/// State that the reading thread shares.
#[derive(Default)]
struct Shared {
    received: Mutex<VecDeque<Result<CanFrame, ()>>>,
    gone: AtomicBool,
    ends: AtomicBool,
}

impl Shared {
    fn received(&self) -> MutexGuard<'_, VecDeque<Result<CanFrame, ()>>> {
        self.received.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<P: Protocol> SerialAdapter<P> {
    /// Opens a port and joins the bus.
    ///
    /// # Errors
    /// The port does not exist, is in use, or may not be opened.
    pub(super) fn open(path: &str, baud: u32) -> io::Result<Self> {
        let mut port = serialport::new(path, baud).timeout(Duration::from_millis(200)).open()?;
        port.clear(ClearBuffer::All)?;
        port.write_all(P::BEGIN)?;
        // Only an empty buffer is written to, which takes the bytes of a tick at once.
        port.set_timeout(Duration::from_millis(1))?;
        let mut reader = port.try_clone()?;
        reader.set_timeout(READ_TIMEOUT)?;
        let shared = Arc::new(Shared::default());
        let its = Arc::clone(&shared);
        thread::Builder::new().name("adapter".into()).spawn(move || {
            read::<P>(reader.as_mut(), &its);
            its.gone.store(true, Ordering::Relaxed);
        })?;
        let bytes = Vec::with_capacity(64);
        Ok(Self { port, shared, waiting: 0, off: false, bytes, protocol: PhantomData })
    }
}

/// Reads until the adapter is gone or closed.
fn read<P: Protocol>(port: &mut dyn SerialPort, shared: &Shared) {
    // As the control tick, which waits for these frames.
    crate::real_time::raise_priority().ok();
    let (mut protocol, mut buffer) = (P::default(), [0; 512]);
    while !shared.ends.load(Ordering::Relaxed) {
        let count = match port.read(&mut buffer) {
            Ok(0) => return,
            Ok(count) => count,
            Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::Interrupted) => continue,
            Err(_) => return,
        };
        for &byte in buffer.get(..count).unwrap_or_default() {
            let result = match protocol.push(byte) {
                Parsed::Nothing => continue,
                Parsed::Frame(frame) => Ok(frame),
                Parsed::Error => Err(()),
            };
            keep_newest(&mut shared.received(), result);
        }
    }
}

impl<P: Protocol> Adapter for SerialAdapter<P> {
    fn begin_tick(&mut self) {
        let waits = self.port.bytes_to_write().map_or(true, |bytes| bytes > 0);
        self.waiting = if waits { self.waiting + 1 } else { 0 };
        if self.waiting > UNSENT_MAX {
            // Old commands must not follow. The adapter may be left with a part of one: it is not used any more.
            let _ = self.port.clear(ClearBuffer::Output);
            self.off = true;
        }
    }

    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        if self.off {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        if self.waiting > 0 {
            return Err(io::ErrorKind::WouldBlock.into());
        }
        self.bytes.clear();
        P::encode(frame, &mut self.bytes);
        let sent = self.port.write_all(&self.bytes);
        // Part of a frame may be in the port: the next one would be joined to it.
        self.off |= sent.is_err();
        sent
    }

    fn receive(&mut self) -> io::Result<Option<CanFrame>> {
        match self.shared.received().pop_front() {
            Some(Ok(frame)) => Ok(Some(frame)),
            Some(Err(())) => Err(io::ErrorKind::InvalidData.into()),
            None => Ok(None),
        }
    }

    fn is_off(&mut self) -> bool {
        self.off || self.shared.gone.load(Ordering::Relaxed)
    }
}

impl<P> Drop for SerialAdapter<P> {
    fn drop(&mut self) {
        self.shared.ends.store(true, Ordering::Relaxed);
    }
}
