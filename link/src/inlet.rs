//! Bytes from the receiver's interrupt to the task that reads them.

use heapless::spsc::Producer;

/// Action of the reader on a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// Nothing yet.
    Waits,
    /// Read: a packet has ended, or half of the queue is full.
    Read,
    /// Read: there was no room, and a byte is lost.
    Lost,
}

/// The writing end of the queue. After a byte was lost the packet that it belonged to is ended: the next byte that finds
/// room comes behind a zero. Otherwise a lost zero would join garbage and the packet behind it, and both would be lost.
pub struct Inlet {
    bytes: Producer<'static, u8>,
    /// A byte was lost, and the zero that ends its packet is still owed.
    owes_zero: bool,
}

impl Inlet {
    /// An inlet to this queue.
    #[must_use]
    pub const fn new(bytes: Producer<'static, u8>) -> Self {
        Self { bytes, owes_zero: false }
    }

    /// Take one byte.
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

    /// End the packet that lost a byte, if there is room for its zero and the byte behind it.
    #[cold]
    fn pay(&mut self, byte: u8) -> bool {
        let room = self.bytes.capacity() - self.bytes.len();
        // A zero pays for itself.
        let paid = byte == 0 || room >= 2 && self.bytes.enqueue(0).is_ok();
        self.owes_zero = !paid;
        paid
    }
}
