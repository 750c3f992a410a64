//! Queues for a CAN controller that holds fewer frames than a tick has.
//!
//! The FDCAN of an STM32G4 holds three frames to send and three received ones; six actuators on one bus need six of each in a tick. [`Queued`]
//! holds the others. The controller's interrupt moves them: when a frame has been sent, the next one is passed to the controller, and a received
//! frame is fetched to free its buffer. The interrupt may be delayed by the time of three replies: at least 130 us, with FD frames at 5 Mbit/s.
//!
//! | call | transmit queue | receive queue |
//! |---|---|---|
//! | `transmit` | appends the frame; refuses it if six wait | |
//! | `interrupt` | passes frames to the controller until it is full | fetches all received frames |
//! | `receive` | | fetches all received frames, then returns an error if there was one, otherwise the first frame |
//! | `abandon` | empties the queue and the controller's buffers | |
//! | `dropped` | returns identifiers of frames that were accepted and not sent: refused or displaced by the controller, or dropped from the queue | |

use crate::can_bus::CanBus;
use embedded_can::nb::Can;
use embedded_can::{Frame as _, Id};
use heapless::Deque;

/// Capacity for frames to be sent: those of a tick, because the controller may still hold those of the previous tick.
pub const OUT: usize = 6;

/// Capacity for received frames, in addition to the controller's own: the replies of a tick and two foreign frames.
pub const IN: usize = 8;

/// A CAN controller with additional queues.
#[derive(Clone, Debug)]
pub struct Queued<B: CanBus> {
    bus: B,
    out: Deque<B::Frame, OUT>,
    received: Deque<B::Frame, IN>,
    /// The last error since the last reception.
    error: Option<B::Error>,
    /// Identifiers of frames that were accepted and will not be sent.
    dropped: Deque<Id, OUT>,
}

impl<B: CanBus> Queued<B> {
    /// Creates empty queues for a controller.
    pub const fn new(bus: B) -> Self {
        Self { bus, out: Deque::new(), received: Deque::new(), error: None, dropped: Deque::new() }
    }

    /// Returns the controller.
    pub const fn bus(&mut self) -> &mut B {
        &mut self.bus
    }

    /// Passes frames to the controller until it is full. A frame that it refuses, or displaces for another one, is dropped.
    fn hand_on(&mut self) {
        // The loop ends: each pass removes a frame, and none is added meanwhile.
        while let Some(frame) = self.out.front() {
            match self.bus.transmit(frame) {
                Err(nb::Error::WouldBlock) => return,
                Ok(None) => {}
                Ok(Some(pushed)) => {
                    self.dropped.push_back(pushed.id()).ok();
                }
                Err(nb::Error::Other(error)) => {
                    self.dropped.push_back(frame.id()).ok();
                    self.error = Some(error);
                }
            }
            self.out.pop_front();
        }
    }

    /// Fetches received frames until the queue is full; the others stay in the controller.
    fn take_in(&mut self) {
        // Errors do not fill the queue, so the number of passes is limited.
        for _ in 0..IN {
            if self.received.is_full() {
                return;
            }
            match self.bus.receive() {
                Ok(frame) => {
                    self.received.push_back(frame).ok();
                }
                Err(nb::Error::WouldBlock) => return,
                Err(nb::Error::Other(error)) => self.error = Some(error),
            }
        }
    }
}

impl<B: CanBus> Can for Queued<B> {
    type Frame = B::Frame;
    type Error = B::Error;

    fn transmit(&mut self, frame: &B::Frame) -> nb::Result<Option<B::Frame>, B::Error> {
        self.hand_on();
        if self.out.is_empty() {
            match self.bus.transmit(frame) {
                Err(nb::Error::WouldBlock) => {}
                sent => return sent,
            }
        }
        let waiting = B::Frame::new(frame.id(), frame.data()).ok_or(nb::Error::WouldBlock)?;
        self.out.push_back(waiting).map_err(|_| nb::Error::WouldBlock)?;
        Ok(None)
    }

    fn receive(&mut self) -> nb::Result<B::Frame, B::Error> {
        self.take_in();
        if let Some(error) = self.error.take() {
            return Err(nb::Error::Other(error));
        }
        self.received.pop_front().ok_or(nb::Error::WouldBlock)
    }
}

impl<B: CanBus> CanBus for Queued<B> {
    fn is_off(&mut self) -> bool {
        self.bus.is_off()
    }

    fn abandon(&mut self) {
        while let Some(frame) = self.out.pop_front() {
            self.dropped.push_back(frame.id()).ok();
        }
        self.bus.abandon();
    }

    fn dropped(&mut self) -> Option<Id> {
        self.dropped.pop_front().or_else(|| self.bus.dropped())
    }

    fn interrupt(&mut self) {
        self.bus.interrupt();
        self.take_in();
        self.hand_on();
    }
}
