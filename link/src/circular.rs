//! Reader of a circular buffer that hardware (DMA) fills.
//!
//! The buffer is the queue: no interrupt copies bytes. The hardware shows where in the buffer it writes, but not how often it has wrapped
//! around. An interrupt at each half of the buffer counts the halves ([`Halves`]). Count and position together give a position in the stream.
//!
//! | may happen | and then |
//! |---|---|
//! | the hardware passes a boundary while its position is read | the position's half differs from the count's: the count is taken as one too low |
//! | it wraps around to bytes that are not read yet | they are lost; a zero ends the packet before them, and reading goes on with the newest half |
//! | it wraps around while bytes are copied | the position is read again after the copy; if bytes were overwritten, the copy is dropped |
//!
//! The interrupt must not be delayed for longer than the hardware needs for half a buffer. Otherwise the count misses a round and the reader
//! gets garbage, which the check sum or seal then rejects.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering, fence};

/// Hardware that fills a buffer.
pub trait Filling {
    /// Index of the byte that is written next; at the end of the buffer, its length or 0.
    fn position(&self) -> usize;

    /// Number of halves that its interrupt has counted ([`Halves::so_far`]), modulo `2^32`.
    fn halves(&self) -> u32;
}

/// Count of the halves of the buffer that the hardware has filled, kept by an interrupt.
#[derive(Debug, Default)]
pub struct Halves(AtomicU32);

impl Halves {
    /// A count of zero.
    #[must_use]
    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// Counts the halves that were filled: the first, the second or both. Called by the interrupt.
    pub fn count(&self, first: bool, second: bool) {
        self.0.fetch_add(u32::from(first) + u32::from(second), Ordering::Relaxed);
    }

    /// Number of halves filled so far, modulo `2^32`.
    pub fn so_far(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

/// A position in the stream of bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Place {
    /// Whole halves before it, modulo `2^32`.
    halves: u32,
    /// Bytes after these halves; less than a half.
    offset: usize,
}

/// Bytes that are copied at once. The hardware's position is read before and after each copy.
const CHUNK: usize = 32;

/// Reader of a circular buffer of `SIZE` bytes that hardware fills. At most `SIZE - 1` bytes can wait to be read.
pub struct Circular<F, const SIZE: usize> {
    bytes: &'static [AtomicU8; SIZE],
    hardware: F,
    /// Position of the next byte to be copied.
    read: Place,
    chunk: [u8; CHUNK],
    /// `next..end` is the part of the chunk that has not been returned yet.
    next: usize,
    end: usize,
    lost: bool,
}

impl<F: Filling, const SIZE: usize> Circular<F, SIZE> {
    const HALF: usize = {
        assert!(SIZE.is_multiple_of(2) && SIZE / 2 >= CHUNK, "two halves, none shorter than a chunk");
        SIZE / 2
    };

    /// Creates a reader of hardware that has filled nothing yet.
    #[must_use]
    pub const fn new(bytes: &'static [AtomicU8; SIZE], hardware: F) -> Self {
        let read = Place { halves: 0, offset: 0 };
        Self { bytes, hardware, read, chunk: [0; CHUNK], next: 0, end: 0, lost: false }
    }

    /// Returns the next byte, if one has arrived. Returns one zero in place of bytes that were lost.
    #[inline]
    pub fn next_byte(&mut self) -> Option<u8> {
        if self.next == self.end {
            self.refill();
        }
        let byte = self.chunk.get(self.next..self.end)?.first().copied();
        self.next += usize::from(byte.is_some());
        byte
    }

    /// True if bytes were lost since the last call.
    pub fn has_lost(&mut self) -> bool {
        core::mem::take(&mut self.lost)
    }

    #[inline(never)]
    fn refill(&mut self) {
        (self.next, self.end) = (0, 0);
        let written = self.written();
        let waiting = self.waiting(written);
        if waiting >= SIZE {
            return self.skip(written);
        }
        let from = self.bytes.get(self.index()..).unwrap_or_default();
        let count = waiting.min(CHUNK).min(from.len());
        for (to, from) in self.chunk.iter_mut().zip(from.iter().take(count)) {
            *to = from.load(Ordering::Relaxed);
        }
        let written = self.written();
        if self.waiting(written) >= SIZE {
            return self.skip(written);
        }
        self.end = count;
        self.read.offset += count;
        if self.read.offset >= Self::HALF {
            self.read = Place { halves: self.read.halves.wrapping_add(1), offset: self.read.offset - Self::HALF };
        }
    }

    /// Skips the bytes that were overwritten and keeps the newest half. The reader then has the time of half a buffer before the hardware
    /// reaches unread bytes again.
    #[cold]
    fn skip(&mut self, written: Place) {
        self.read = Place { halves: written.halves.wrapping_sub(1), ..written };
        self.lost = true;
        // The zero ends the packet that lost bytes: the bytes after it may be the rest of another packet.
        self.chunk[0] = 0;
        self.end = 1;
    }

    /// Position where the hardware writes next.
    fn written(&self) -> Place {
        // The copies before and after this function must not be reordered with the reads of the hardware.
        fence(Ordering::SeqCst);
        // The loop ends: the count changes once per half a buffer, which takes longer than one pass.
        let (halves, position) = loop {
            let halves = self.hardware.halves();
            let position = self.hardware.position();
            if self.hardware.halves() == halves {
                break (halves, position);
            }
        };
        fence(Ordering::SeqCst);
        let position = if position >= SIZE { 0 } else { position };
        let second = position >= Self::HALF;
        // With an even count the hardware is filling the first half. If the position disagrees, it has just passed a boundary and the interrupt
        // has not run yet.
        let behind = (halves % 2 == 1) != second;
        let offset = if second { position - Self::HALF } else { position };
        Place { halves: halves.wrapping_add(u32::from(behind)), offset }
    }

    /// Number of bytes from the next one to be copied up to the position `written`.
    fn waiting(&self, written: Place) -> usize {
        let halves = written.halves.wrapping_sub(self.read.halves) as usize;
        (halves.saturating_mul(Self::HALF).saturating_add(written.offset)).saturating_sub(self.read.offset)
    }

    /// Index in the buffer of the next byte to be copied.
    fn index(&self) -> usize {
        self.read.offset + if self.read.halves % 2 == 1 { Self::HALF } else { 0 }
    }
}
