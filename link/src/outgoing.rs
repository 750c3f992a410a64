//! Queue of bytes to hardware (DMA) that sends pieces of memory without the processor.

use core::sync::atomic::{AtomicU8, Ordering};

/// Hardware that sends pieces of memory, one at a time.
pub trait Sending {
    /// True if it has taken the last byte of the previous piece. If so, also acknowledges its interrupt.
    fn is_idle(&mut self) -> bool;

    /// Starts to send this piece. Called only while the hardware is idle; nothing writes to the piece until it is idle again.
    fn start(&mut self, piece: &'static [AtomicU8]);
}

/// A queue of `SIZE` bytes. The bytes of a piece are freed together, when all of it has been sent.
///
/// One task owns it, or several of the same priority. A writer that has to wait polls the hardware, so the interrupt at the end of a piece does
/// not need a higher priority than the writer.
pub struct Outgoing<S, const SIZE: usize> {
    bytes: &'static [AtomicU8; SIZE],
    hardware: S,
    /// Index of the first byte that is not sent.
    first: usize,
    /// Number of bytes from there on that the hardware is sending.
    handed: usize,
    /// Number of bytes after these that wait.
    waiting: usize,
}

impl<S: Sending, const SIZE: usize> Outgoing<S, SIZE> {
    /// Creates an empty queue.
    #[must_use]
    pub const fn new(bytes: &'static [AtomicU8; SIZE], hardware: S) -> Self {
        assert!(SIZE > 0, "an empty queue would be waited for without end");
        Self { bytes, hardware, first: 0, handed: 0, waiting: 0 }
    }

    /// Puts all bytes into the queue. Waits while the queue is full; the wait ends, because the hardware sends even if nobody listens.
    pub fn write(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            self.advance();
            bytes = bytes.get(self.fill(bytes)..).unwrap_or_default();
        }
        self.advance();
    }

    /// Number of bytes that [`Outgoing::write`] takes now without waiting.
    pub fn room(&mut self) -> usize {
        self.advance();
        SIZE - self.handed - self.waiting
    }

    /// Starts the next piece if the previous one has been sent. Called by the interrupt at the end of a piece.
    pub fn advance(&mut self) {
        if !self.hardware.is_idle() {
            return;
        }
        // An empty queue restarts at the beginning of the buffer, so that a packet is one piece.
        self.first = if self.waiting == 0 { 0 } else { wrapped::<SIZE>(self.first + self.handed) };
        let piece = self.bytes.get(self.first..).unwrap_or_default();
        let piece = piece.get(..self.waiting).unwrap_or(piece);
        self.handed = piece.len();
        self.waiting -= piece.len();
        if !piece.is_empty() {
            self.hardware.start(piece);
        }
    }

    /// Copies as many bytes as fit contiguously and returns their number.
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

/// Wraps an index below twice the size into the buffer.
const fn wrapped<const SIZE: usize>(index: usize) -> usize {
    if index >= SIZE { index - SIZE } else { index }
}
