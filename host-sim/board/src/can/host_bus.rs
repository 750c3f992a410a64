//! An adapter as a bus of the joints' driver.

use super::adapter::Adapter;
use super::frame::CanFrame;
use embedded_can::ErrorKind;
use embedded_can::nb::Can;
use joint_io::can_bus::CanBus;
use std::io;

/// A bus of this computer; without an adapter, no frame can be sent and none is received.
pub struct HostBus(Option<Box<dyn Adapter>>);

impl HostBus {
    /// The bus at this adapter.
    #[must_use]
    pub fn new(adapter: Box<dyn Adapter>) -> Self {
        Self(Some(adapter))
    }

    /// A bus that does not exist.
    #[must_use]
    pub const fn none() -> Self {
        Self(None)
    }
}

impl Can for HostBus {
    type Frame = CanFrame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &CanFrame) -> nb::Result<Option<CanFrame>, ErrorKind> {
        let Some(adapter) = &mut self.0 else { return Err(nb::Error::Other(ErrorKind::Other)) };
        match adapter.send(frame) {
            Ok(()) => Ok(None),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Err(nb::Error::WouldBlock),
            Err(_) => Err(nb::Error::Other(ErrorKind::Other)),
        }
    }

    fn receive(&mut self) -> nb::Result<CanFrame, ErrorKind> {
        match self.0.as_mut().map(|adapter| adapter.receive()) {
            Some(Ok(Some(frame))) => Ok(frame),
            Some(Ok(None)) | None => Err(nb::Error::WouldBlock),
            Some(Err(_)) => Err(nb::Error::Other(ErrorKind::Other)),
        }
    }
}

impl CanBus for HostBus {
    fn is_off(&mut self) -> bool {
        self.0.as_mut().is_some_and(|adapter| adapter.is_off())
    }

    /// Frames that the system has taken cannot be taken back: while they wait, the adapter accepts no others.
    fn abandon(&mut self) {
        if let Some(adapter) = &mut self.0 {
            adapter.begin_tick();
        }
    }
}
