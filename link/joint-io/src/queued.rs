//! Queues beside a controller that holds fewer frames than a tick has.
//!
//! The FDCAN of an STM32G4 has room for three frames to send and three that have come; six actuators on one bus make six of each in a tick.
//! [`Queued`] keeps the others. The controller's interrupt moves them on: when a frame is sent the next one takes its room, and one that has
//! come makes room for the next. It may be held up for the time of three replies: 130 us at least, with FD frames at 5 Mbit/s.
//!
//! | call | queue out | queue in |
//! |---|---|---|
//! | `transmit` | behind what waits; refused when six wait | |
//! | `interrupt` | to the controller, as far as it has room | all that has come |
//! | `receive` | | the first, after all that has come since; an error before it |
//! | `abandon` | emptied, with the controller's own | |
//! | `dropped` | identifiers of frames that were taken and not sent: refused or pushed out by the controller, or abandoned in the queue | |

use crate::can_bus::CanBus;
use embedded_can::nb::Can;
use embedded_can::{Frame as _, Id};
use heapless::Deque;

/// Frames that wait to be sent, at most: those of a tick, while the controller still gives up those of the tick before.
pub const OUT: usize = 6;

/// Frames that wait to be read, at most: the replies of a tick and two strangers, beside what the controller holds.
pub const IN: usize = 8;

/// A controller with queues.
#[derive(Clone, Debug)]
pub struct Queued<B: CanBus> {
    bus: B,
    out: Deque<B::Frame, OUT>,
    received: Deque<B::Frame, IN>,
    /// Of the errors since the last reception the last one.
    error: Option<B::Error>,
    /// Identifiers of frames that were taken and are not sent.
    dropped: Deque<Id, OUT>,
}

impl<B: CanBus> Queued<B> {
    /// Empty queues.
    pub const fn new(bus: B) -> Self {
        Self { bus, out: Deque::new(), received: Deque::new(), error: None, dropped: Deque::new() }
    }

    /// The controller.
    pub const fn bus(&mut self) -> &mut B {
        &mut self.bus
    }

    /// Give the controller frames until it has no room. One that it refuses, or pushes out for another, is dropped.
    fn hand_on(&mut self) {
        // Each turn takes a frame away, and nothing puts one in meanwhile.
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

    /// Take what has come. What finds no room stays in the controller.
    fn take_in(&mut self) {
        // Errors take no room, so the turns are counted.
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
