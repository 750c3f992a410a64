//! A simulated adapter behind the interface to USB, written from the documents: 64 buffers, three transmit mailboxes, echoes from the mailboxes.

use super::super::frame::{CanFrame, id};
use super::transport::Transport;
use embedded_can::Frame as _;
use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard};

/// Buffers for frames, shared by both directions.
const BUFFERS: usize = 64;

/// Transmit mailboxes.
const MAILBOXES: usize = 3;

/// Reply of the drives at the bus to a frame.
type Bus = Box<dyn FnMut(&CanFrame) -> Vec<CanFrame> + Send>;

/// State of an adapter, for inspection and faults.
pub(super) struct State {
    /// Every request to the adapter: number, value, data.
    pub(super) requests: Vec<(u8, u16, Vec<u8>)>,
    /// Requests that are refused.
    pub(super) refused: Option<u8>,
    /// Most bytes of an answer.
    pub(super) answer_max: usize,
    pub(super) channels: u8,
    pub(super) limits: [u32; 10],
    /// The channel that is on, as a program before may have left it.
    pub(super) on: Option<u16>,
    /// True if the channel that is on loops frames back and only listens.
    pub(super) loops: bool,
    /// True if a reset drops the frames in the buffers, which only the newest firmware does.
    pub(super) drops: bool,
    /// True if a drive acknowledges frames.
    pub(super) acknowledges: bool,
    /// Number of further reads after which one does.
    pub(super) acknowledged_after: Option<u32>,
    /// True if transfers from the adapter have a time stamp.
    pub(super) stamps: bool,
    pub(super) unplugged: bool,
    /// Frames that were on the bus.
    pub(super) on_bus: Vec<CanFrame>,
    /// Length of every transfer to the adapter.
    pub(super) lengths: Vec<usize>,
    /// Transfers to the program.
    pub(super) to_host: VecDeque<Vec<u8>>,
    /// Transfers to the adapter that have not ended, and frames in its buffers and mailboxes.
    pending: VecDeque<Vec<u8>>,
    from_host: VecDeque<Vec<u8>>,
    mailboxes: VecDeque<CanFrame>,
    bus: Bus,
}

impl State {
    /// Appends a transfer to the program.
    pub(super) fn report(&mut self, echo: u32, raw: u32, channel: u8, data: &[u8]) {
        let mut bytes = [echo.to_le_bytes(), raw.to_le_bytes()].concat();
        bytes.extend([data.len() as u8, channel, 0, 0]);
        bytes.extend(data);
        bytes.resize(20, 0);
        if self.stamps {
            bytes.extend([1, 2, 3, 4]);
        }
        self.to_host.push_back(bytes);
    }

    /// Appends a frame from the bus.
    pub(super) fn receive(&mut self, frame: &CanFrame, channel: u8) {
        let extended = if frame.is_extended() { 1 << 31 } else { 0 };
        self.report(u32::MAX, frame.raw_id() | extended, channel, frame.data());
    }

    /// Number of frames that wait anywhere.
    pub(super) fn waiting(&self) -> usize {
        self.pending.len() + self.from_host.len() + self.mailboxes.len()
    }

    fn pass(&mut self) {
        loop {
            if self.from_host.len() + self.to_host.len() < BUFFERS
                && let Some(bytes) = self.pending.pop_front()
            {
                // Too short transfers are ignored.
                if bytes.len() >= 20 {
                    self.from_host.push_back(bytes);
                }
                continue;
            }
            if self.on.is_some()
                && self.mailboxes.len() < MAILBOXES
                && let Some(bytes) = self.from_host.pop_front()
            {
                let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
                let (raw, length, channel) = (word(4), usize::from(bytes[8]), bytes[9]);
                assert!(self.on == Some(channel.into()), "a frame for a channel that is off");
                let id = id(raw & 0x1FFF_FFFF, raw >> 31 != 0).unwrap();
                let data = &bytes[12..12 + length];
                self.mailboxes.push_back(CanFrame::new(id, data).unwrap());
                self.report(word(0), raw, channel, data);
                continue;
            }
            if self.loops
                && let Some(channel) = self.on
                && let Some(frame) = self.mailboxes.pop_front()
            {
                self.receive(&frame, channel as u8);
                continue;
            }
            if self.acknowledges
                && let Some(frame) = self.mailboxes.pop_front()
            {
                self.on_bus.push(frame);
                let channel = self.on.unwrap() as u8;
                for reply in (self.bus)(&frame) {
                    self.receive(&reply, channel);
                }
                continue;
            }
            return;
        }
    }

    fn request(&mut self, request: u8, value: u16, data: &[u8]) -> io::Result<()> {
        if self.unplugged {
            return Err(io::ErrorKind::NotConnected.into());
        }
        self.requests.push((request, value, data.to_vec()));
        if self.refused == Some(request) {
            return Err(io::Error::new(io::ErrorKind::ConnectionReset, "endpoint stalled"));
        }
        Ok(())
    }
}

/// USB of a simulated adapter; every copy is of the same one.
#[derive(Clone)]
pub(super) struct SimulatedUsb(Arc<Mutex<State>>);

impl SimulatedUsb {
    /// An adapter with a clock of 48 MHz, on whose bus these drives reply.
    pub(super) fn new(bus: impl FnMut(&CanFrame) -> Vec<CanFrame> + Send + 'static) -> Self {
        Self(Arc::new(Mutex::new(State {
            requests: Vec::new(),
            refused: None,
            answer_max: usize::MAX,
            channels: 1,
            limits: [0b11, 48_000_000, 1, 16, 1, 8, 4, 1, 1024, 1],
            on: None,
            loops: false,
            drops: false,
            acknowledges: true,
            acknowledged_after: None,
            stamps: false,
            unplugged: false,
            on_bus: Vec::new(),
            lengths: Vec::new(),
            to_host: VecDeque::new(),
            pending: VecDeque::new(),
            from_host: VecDeque::new(),
            mailboxes: VecDeque::new(),
            bus: Box::new(bus),
        })))
    }

    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap()
    }
}

impl Transport for SimulatedUsb {
    fn control_out(&mut self, request: u8, value: u16, data: &[u8]) -> io::Result<()> {
        let mut state = self.state();
        state.request(request, value, data)?;
        match (request, data.first()) {
            (2, Some(0)) => {
                state.on = None;
                // The controller is reset when it is started.
                state.mailboxes.clear();
                if state.drops {
                    state.from_host.clear();
                }
            }
            (2, Some(1)) => {
                state.loops = data[4] & 0b11 == 0b11;
                state.on = Some(value);
                state.pass();
            }
            _ => {}
        }
        Ok(())
    }

    fn control_in(&mut self, request: u8, value: u16, length: u16) -> io::Result<Vec<u8>> {
        let mut state = self.state();
        state.request(request, value, &[])?;
        let mut answer = match request {
            4 => state.limits.iter().flat_map(|word| word.to_le_bytes()).collect(),
            5 => vec![0, 0, 0, state.channels - 1, 2, 0, 0, 0, 1, 0, 0, 0],
            _ => panic!("request {request}"),
        };
        assert_eq!(answer.len(), usize::from(length));
        answer.truncate(state.answer_max);
        Ok(answer)
    }

    fn submit(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut state = self.state();
        if state.unplugged {
            return Err(io::ErrorKind::NotConnected.into());
        }
        state.lengths.push(bytes.len());
        state.pending.push_back(bytes.to_vec());
        state.pass();
        Ok(())
    }

    fn receive(&mut self, bytes: &mut Vec<u8>) -> io::Result<bool> {
        let mut state = self.state();
        if state.unplugged {
            return Err(io::ErrorKind::NotConnected.into());
        }
        if let Some(reads) = &mut state.acknowledged_after {
            *reads = reads.saturating_sub(1);
            state.acknowledges = state.acknowledged_after == Some(0);
        }
        state.pass();
        let Some(next) = state.to_host.pop_front() else { return Ok(false) };
        *bytes = next;
        Ok(true)
    }

    fn cancel(&mut self) {
        self.state().pending.clear();
    }
}
