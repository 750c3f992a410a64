//! Interface to a CAN bus for the schedule of commands.

use embedded_can::nb::Can;
use embedded_can::{ErrorKind, Frame, Id};

/// Functions of a bus that the schedule needs in addition to sending and receiving.
pub trait CanBus: Can {
    /// True if the controller has left the bus after too many errors. The board must bring it back; a bxCAN can be configured to return without
    /// the processor.
    fn is_off(&mut self) -> bool;

    /// Drops all unsent frames: a torque of the previous tick must not be sent after this tick's.
    fn abandon(&mut self);

    /// Handles the controller's interrupt. Does nothing for a controller that holds all frames of a tick.
    fn interrupt(&mut self) {}

    /// Returns the identifier of the next frame that [`Can::transmit`] accepted and that will never be sent. At most [`crate::queued::OUT`] of
    /// them wait.
    fn dropped(&mut self) -> Option<Id> {
        None
    }
}

/// Stands for a bus that a board does not have: no frame can be sent, and none is received.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoBus;

/// The frame type of [`NoBus`]; it has no values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoFrame {}

impl Frame for NoFrame {
    fn new(_: impl Into<Id>, _: &[u8]) -> Option<Self> {
        None
    }

    fn new_remote(_: impl Into<Id>, _: usize) -> Option<Self> {
        None
    }

    fn is_extended(&self) -> bool {
        match *self {}
    }

    fn is_remote_frame(&self) -> bool {
        match *self {}
    }

    fn id(&self) -> Id {
        match *self {}
    }

    fn dlc(&self) -> usize {
        match *self {}
    }

    fn data(&self) -> &[u8] {
        match *self {}
    }
}

impl Can for NoBus {
    type Frame = NoFrame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &NoFrame) -> nb::Result<Option<NoFrame>, ErrorKind> {
        match *frame {}
    }

    fn receive(&mut self) -> nb::Result<NoFrame, ErrorKind> {
        Err(nb::Error::WouldBlock)
    }
}

impl CanBus for NoBus {
    fn is_off(&mut self) -> bool {
        false
    }

    fn abandon(&mut self) {}
}
