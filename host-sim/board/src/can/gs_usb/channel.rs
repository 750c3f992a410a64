//! A channel as an [`Adapter`].

use super::super::adapter::{Adapter, UNSENT_MAX, keep_newest};
use super::super::frame::CanFrame;
use super::host_frame::{Content, FRAME_BYTES, decode, encode};
use super::requests::{self, Started};
use super::transport::Transport;
use std::collections::VecDeque;
use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::io;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle, sleep};
use std::time::Duration;

/// Frames that may be handed over and not have come back: as many as in Linux. A tick has at most six.
pub(super) const UNSENT_FRAMES_MAX: usize = 10;

/// Lower bits of the number of an echo, more than are used: so no number has all bits set, which marks a received frame.
const ECHO_NUMBERS: u32 = 0xf;
const _: () = assert!(UNSENT_FRAMES_MAX <= ECHO_NUMBERS as usize);

/// Most transfers that are read at once, so that no adapter holds up a tick.
const READ_MAX: usize = 128;

/// Longest wait for the last frames when the adapter is closed, ms, and the time that three frames in its mailboxes need, ms.
const LAST_MS: u32 = 20;
const MAILBOXES_MS: u64 = 1;

/// A channel of an adapter.
pub(super) struct GsUsb<T: Transport> {
    /// `None` once the adapter is off.
    usb: Option<T>,
    /// The thread that takes the channel off the bus when the adapter is off or closed, because a tick must not wait for that.
    closing: Option<(Sender<T>, JoinHandle<()>)>,
    channel: u8,
    /// Bytes of a transfer to the adapter.
    transfer_bytes: usize,
    /// Upper bits of the numbers of all echoes, so that none of an earlier program is taken for one of this program.
    echo_base: u32,
    /// By the lower bits of the number of its echo: true if the frame was handed over and has not come back.
    unsent: [bool; UNSENT_FRAMES_MAX],
    /// Number of ticks that began with unsent frames.
    waiting: u32,
    received: VecDeque<Result<CanFrame, ()>>,
    /// Reason why it is off.
    reason: Option<Off>,
    /// True until the reason was reported.
    is_new: bool,
    bytes: Vec<u8>,
}

/// Reason why an adapter is off.
#[derive(Debug)]
enum Off {
    Errors,
    Unsent,
    Usb(io::Error),
}

impl Off {
    fn error(&self) -> io::Error {
        let text = match self {
            Self::Errors => {
                "the adapter left the bus after too many errors: check wiring, termination and bit rate".into()
            }
            Self::Unsent => "frames waited in the adapter for too long, so its channel was reset".into(),
            Self::Usb(error) if error.kind() == io::ErrorKind::NotConnected => "the adapter was unplugged".into(),
            Self::Usb(error) => format!("USB: {error}"),
        };
        io::Error::new(io::ErrorKind::BrokenPipe, text)
    }
}

impl<T: Transport> GsUsb<T> {
    /// Starts a channel at 1 Mbit/s.
    ///
    /// # Errors
    /// The adapter has no such channel, refuses a request, or was unplugged.
    pub(super) fn start(mut usb: T, number: u8) -> io::Result<Self> {
        let started = requests::start(&mut usb, number)?;
        let transfer_bytes = FRAME_BYTES + usize::from(started.longer_transfers);
        let (sender, receiver) = channel::<T>();
        let thread = thread::Builder::new().name("adapter".into()).spawn(move || close(&receiver, &started));
        let thread = thread.inspect_err(|_| {
            let _ = requests::reset(&mut usb, number);
        })?;
        Ok(Self {
            usb: Some(usb),
            closing: Some((sender, thread)),
            channel: number,
            transfer_bytes,
            echo_base: RandomState::new().build_hasher().finish() as u32 & !ECHO_NUMBERS,
            unsent: [false; UNSENT_FRAMES_MAX],
            waiting: 0,
            received: VecDeque::new(),
            reason: None,
            is_new: false,
            bytes: Vec::with_capacity(64),
        })
    }

    /// Stops using the adapter, and lets the thread take it off the bus.
    fn leave(&mut self, reason: Off) {
        if let (Some(usb), Some((closing, _))) = (self.usb.take(), &self.closing) {
            // The thread waits for it.
            let _ = closing.send(usb);
            self.reason = Some(reason);
            self.is_new = true;
        }
    }

    /// Reads everything that has arrived: echoes, errors and frames of others.
    fn read_all(&mut self) {
        for _ in 0..READ_MAX {
            let Some(usb) = &mut self.usb else { return };
            match usb.receive(&mut self.bytes) {
                Ok(true) => {}
                Ok(false) => return,
                Err(error) => return self.leave(Off::Usb(error)),
            }
            let (content, lost) = decode(&self.bytes, self.channel);
            match content {
                // An echo of an unknown frame is one of an earlier program.
                Content::Echo(number) => {
                    let at = usize::try_from(number ^ self.echo_base).ok();
                    if let Some(unsent) = at.and_then(|at| self.unsent.get_mut(at)) {
                        *unsent = false;
                    }
                }
                Content::Frame(frame) => self.keep(Ok(frame)),
                Content::BusOff => self.leave(Off::Errors),
                Content::Nothing => {}
                Content::Unreadable => self.keep(Err(())),
            }
            if lost {
                self.keep(Err(()));
            }
        }
    }

    fn keep(&mut self, result: Result<CanFrame, ()>) {
        keep_newest(&mut self.received, result);
    }

    /// The reason why it is off.
    fn off(&self) -> io::Error {
        self.reason.as_ref().map_or(io::ErrorKind::BrokenPipe.into(), Off::error)
    }
}

/// Waits for the adapter, which is off or closed, and takes its channel off the bus without the frames that wait in it.
fn close<T: Transport>(adapter: &Receiver<T>, started: &Started) {
    // On a busy computer the frames should not wait for other programs.
    crate::real_time::raise_priority().ok();
    if let Ok(mut usb) = adapter.recv() {
        usb.cancel();
        // An adapter that was unplugged cannot be reset, and needs not.
        let _ = requests::stop(&mut usb, started);
    }
}

impl<T: Transport> Adapter for GsUsb<T> {
    fn begin_tick(&mut self) {
        self.read_all();
        self.waiting = if self.unsent.contains(&true) { self.waiting + 1 } else { 0 };
        if self.waiting > UNSENT_MAX {
            self.leave(Off::Unsent);
        }
    }

    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        let free = self.unsent.iter().position(|unsent| !unsent);
        let Some(usb) = &mut self.usb else { return Err(self.off()) };
        let Some(number) = free.filter(|_| self.waiting == 0) else { return Err(io::ErrorKind::WouldBlock.into()) };
        self.bytes.clear();
        encode(frame, self.echo_base | number as u32, self.channel, &mut self.bytes);
        self.bytes.resize(self.transfer_bytes, 0);
        if let Err(error) = usb.submit(&self.bytes) {
            self.leave(Off::Usb(error));
            return Err(self.off());
        }
        if let Some(unsent) = self.unsent.get_mut(number) {
            *unsent = true;
        }
        Ok(())
    }

    fn receive(&mut self) -> io::Result<Option<CanFrame>> {
        // All at once, so that the newest are kept.
        self.read_all();
        match self.received.pop_front() {
            Some(Ok(frame)) => Ok(Some(frame)),
            Some(Err(())) => Err(io::ErrorKind::InvalidData.into()),
            None if core::mem::take(&mut self.is_new) => Err(self.off()),
            None => Ok(None),
        }
    }

    fn is_off(&mut self) -> bool {
        self.usb.is_none()
    }
}

impl<T: Transport> Drop for GsUsb<T> {
    /// Waits for the last frames, which may switch drives off. Then the channel leaves the bus.
    fn drop(&mut self) {
        for _ in 0..LAST_MS {
            self.read_all();
            if self.usb.is_none() || !self.unsent.contains(&true) {
                break;
            }
            sleep(Duration::from_millis(1));
        }
        let Some((closing, thread)) = self.closing.take() else { return };
        if let Some(usb) = self.usb.take() {
            sleep(Duration::from_millis(MAILBOXES_MS));
            let _ = closing.send(usb);
        }
        // Without a sender the thread ends, if it has not ended long ago.
        drop(closing);
        let _ = thread.join();
    }
}
