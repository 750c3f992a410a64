//! Bytes on their way to hardware that sends a piece of memory by itself.

use core::sync::atomic::{AtomicU8, Ordering};

/// Hardware that sends pieces of memory, one at a time.
pub trait Sending {
    /// True if it has taken the last byte of the piece before. Acknowledges its interrupt if so.
    fn is_idle(&mut self) -> bool;

    /// Send this piece. The hardware is idle, and until it is idle again nothing writes to the piece.
    fn start(&mut self, piece: &'static [AtomicU8]);
}

/// A queue of `SIZE` bytes. The piece that is being sent leaves it as a whole.
///
/// One task owns it, or several of one priority: writing polls the hardware where it has to wait, so that the interrupt behind a piece need
/// not be more urgent than the writer.
pub struct Outgoing<S, const SIZE: usize> {
    bytes: &'static [AtomicU8; SIZE],
    hardware: S,
    /// Index of the first byte that is not sent.
    first: usize,
    /// Bytes from there on that the hardware has.
    handed: usize,
    /// Bytes behind these that wait.
    waiting: usize,
}

impl<S: Sending, const SIZE: usize> Outgoing<S, SIZE> {
    /// An empty queue.
    #[must_use]
    pub const fn new(bytes: &'static [AtomicU8; SIZE], hardware: S) -> Self {
        assert!(SIZE > 0, "an empty queue would be waited for without end");
        Self { bytes, hardware, first: 0, handed: 0, waiting: 0 }
    }

    /// Take all bytes. Waits while the queue is full; that ends, because the hardware sends without a listener too.
    pub fn write(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            self.advance();
            bytes = bytes.get(self.fill(bytes)..).unwrap_or_default();
        }
        self.advance();
    }

    /// Bytes that [`Outgoing::write`] takes now without waiting.
    pub fn room(&mut self) -> usize {
        self.advance();
        SIZE - self.handed - self.waiting
    }

    /// Start the next piece if the one before has been sent. Called by the interrupt behind a piece.
    pub fn advance(&mut self) {
        if !self.hardware.is_idle() {
            return;
        }
        // An empty queue starts anew at the buffer's begin: a packet is then one piece.
        self.first = if self.waiting == 0 { 0 } else { wrapped::<SIZE>(self.first + self.handed) };
        let piece = self.bytes.get(self.first..).unwrap_or_default();
        let piece = piece.get(..self.waiting).unwrap_or(piece);
        self.handed = piece.len();
        self.waiting -= piece.len();
        if !piece.is_empty() {
            self.hardware.start(piece);
        }
    }

    /// Copy as many bytes as find room in one stretch; returns their number.
    fn fill(&mut self, bytes: &[u8]) -> usize {
        let taken = self.handed + self.waiting;
        let at = wrapped::<SIZE>(self.first + taken);
        let room = self.bytes.get(at..).unwrap_or_default().iter().take(SIZE - taken);
        let mut count = 0;
        for (to, from) in room.zip(bytes) {
            to.store(*from, Ordering::Relaxed);
            count += 1;
        }
        self.waiting += count;
        count
    }
}

/// An index below twice the size.
const fn wrapped<const SIZE: usize>(index: usize) -> usize {
    if index >= SIZE { index - SIZE } else { index }
}
