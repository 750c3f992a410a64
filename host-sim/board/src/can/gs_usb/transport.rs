//! Interface to USB.

use std::io;

/// USB of an adapter's interface 0. An error of kind `NotConnected` means that the adapter was unplugged.
pub(super) trait Transport: Send + 'static {
    /// Sends a vendor request to the interface, and waits for its end.
    ///
    /// # Errors
    /// The adapter refuses it, does not answer in time, or was unplugged.
    fn control_out(&mut self, request: u8, value: u16, data: &[u8]) -> io::Result<()>;

    /// Asks the interface for this many bytes, and waits for them. There may be fewer.
    ///
    /// # Errors
    /// As for [`Self::control_out`].
    fn control_in(&mut self, request: u8, value: u16, length: u16) -> io::Result<Vec<u8>>;

    /// Begins a bulk transfer to the adapter, and does not wait.
    ///
    /// # Errors
    /// An earlier transfer failed, or the adapter was unplugged.
    fn submit(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Replaces `bytes` by the next transfer from the adapter. Returns false if none has arrived, and does not wait.
    ///
    /// # Errors
    /// A transfer failed in either direction, or the adapter was unplugged.
    fn receive(&mut self, bytes: &mut Vec<u8>) -> io::Result<bool>;

    /// Cancels the bulk transfers to the adapter that have not begun, and waits for the end of all for 20 ms at most.
    fn cancel(&mut self);
}
