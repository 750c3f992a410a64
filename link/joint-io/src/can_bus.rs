//! A CAN bus as the schedule of commands needs it.

use embedded_can::nb::Can;
use embedded_can::{ErrorKind, Frame, Id};

/// Functions of a bus that the schedule needs, beside sending and receiving.
pub trait CanBus: Can {
    /// True if the controller has left the bus after too many errors. Bringing it back is the board's work (a bxCAN does it
    /// by itself once told to).
    fn is_off(&mut self) -> bool;

    /// Abandon all unsent frames: a torque of the tick before must not go out after this tick's.
    fn abandon(&mut self);

    /// The controller's interrupt. Nothing to do where it holds all frames of a tick.
    fn interrupt(&mut self) {}

    /// Identifier of the next frame that was taken by [`Can::transmit`] and will never be sent. At most [`crate::queued::OUT`] of them wait.
    fn dropped(&mut self) -> Option<Id> {
        None
    }
}

/// A bus that a board does not have: it takes no frame, and none comes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoBus;

/// A frame that cannot be.
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
