//! Queue of bytes from the receiver's interrupt to the task that reads them.

use heapless::spsc::Producer;

/// Action that the reader should take after a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// Nothing to do yet.
    Waits,
    /// Read the queue: a packet has ended, or half of the queue is full.
    Read,
    /// Read the queue: it was full, and a byte is lost.
    Lost,
}

/// The writing end of the queue. After a lost byte it ends the packet that the byte belonged to: it writes a zero before the next byte that
/// fits. Otherwise a lost zero would merge garbage with the packet after it, and both would be lost.
pub struct Inlet {
    bytes: Producer<'static, u8>,
    /// A byte was lost, and the zero that ends its packet is not written yet.
    owes_zero: bool,
}

impl Inlet {
    /// Creates an inlet to this queue.
    #[must_use]
    pub const fn new(bytes: Producer<'static, u8>) -> Self {
        Self { bytes, owes_zero: false }
    }

    /// Puts one byte into the queue.
    pub fn push(&mut self, byte: u8) -> Arrival {
        if self.owes_zero && !self.pay(byte) {
            return Arrival::Lost;
        }
        if self.bytes.enqueue(byte).is_err() {
            self.owes_zero = true;
            return Arrival::Lost;
        }
        if byte == 0 || 2 * self.bytes.len() >= self.bytes.capacity() { Arrival::Read } else { Arrival::Waits }
    }

    /// Ends the packet that lost a byte, if the queue has space for its zero and the byte after it. Returns true if it did.
    #[cold]
    fn pay(&mut self, byte: u8) -> bool {
        let room = self.bytes.capacity() - self.bytes.len();
        // If the byte is itself a zero, it ends the packet.
        let paid = byte == 0 || room >= 2 && self.bytes.enqueue(0).is_ok();
        self.owes_zero = !paid;
        paid
    }
}
