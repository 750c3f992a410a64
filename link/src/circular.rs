//! Bytes that hardware writes into a buffer round and round, and the task that reads them behind it.
//!
//! The buffer is the queue: nothing is moved in an interrupt. The hardware shows where in the buffer it writes, but not how often it has gone
//! round. An interrupt at each half of the buffer counts that ([`Halves`]), and count and position together are a place in the stream.
//!
//! | may happen | and then |
//! |---|---|
//! | the hardware passes a boundary while its position is read | the position's half differs from the count's: the count is taken as one behind |
//! | it comes round to bytes that are not read | they are lost; the packet before them is ended by a zero, and reading goes on with the newest half |
//! | it comes round while bytes are copied | the place is read again behind the copy; what was copied does not count |
//!
//! The interrupt must not be held off for longer than half a buffer takes: then the count misses a round, and what is read is garbage, which
//! no check sum or seal takes for a packet.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering, fence};

/// Hardware that fills a buffer.
pub trait Filling {
    /// Index of the byte that is written next; at the end of the buffer, its length or 0.
    fn position(&self) -> usize;

    /// The halves that its interrupt has counted ([`Halves::so_far`]).
    fn halves(&self) -> u32;
}

/// The halves of the buffer that were filled, counted by an interrupt.
#[derive(Debug, Default)]
pub struct Halves(AtomicU32);

impl Halves {
    /// None yet.
    #[must_use]
    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// Called by the interrupt: the first half was filled, the second was, or both.
    pub fn count(&self, first: bool, second: bool) {
        self.0.fetch_add(u32::from(first) + u32::from(second), Ordering::Relaxed);
    }

    /// All of them, modulo `2^32`.
    pub fn so_far(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

/// A place in the stream of bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Place {
    /// Whole halves before it, modulo `2^32`.
    halves: u32,
    /// Bytes behind these; less than a half.
    offset: usize,
}

/// Bytes that are copied at once. One look at the hardware is made before them and one behind.
const CHUNK: usize = 32;

/// Reads behind hardware that fills a buffer of `SIZE` bytes, of which `SIZE - 1` may wait.
pub struct Circular<F, const SIZE: usize> {
    bytes: &'static [AtomicU8; SIZE],
    hardware: F,
    /// Place of the next byte to be copied.
    read: Place,
    chunk: [u8; CHUNK],
    /// Rest of the chunk.
    next: usize,
    end: usize,
    lost: bool,
}

impl<F: Filling, const SIZE: usize> Circular<F, SIZE> {
    const HALF: usize = {
        assert!(SIZE.is_multiple_of(2) && SIZE / 2 >= CHUNK, "two halves, none shorter than a chunk");
        SIZE / 2
    };

    /// A reader of hardware that has filled nothing yet.
    #[must_use]
    pub const fn new(bytes: &'static [AtomicU8; SIZE], hardware: F) -> Self {
        let read = Place { halves: 0, offset: 0 };
        Self { bytes, hardware, read, chunk: [0; CHUNK], next: 0, end: 0, lost: false }
    }

    /// The next byte, if one has come. Where bytes were lost, a zero stands in their place.
    #[inline]
    pub fn next_byte(&mut self) -> Option<u8> {
        if self.next == self.end {
            self.refill();
        }
        let byte = self.chunk.get(self.next..self.end)?.first().copied();
        self.next += usize::from(byte.is_some());
        byte
    }

    /// True if bytes were lost since this was last asked.
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

    /// Leave out what was overwritten. The newest half is kept: as much time is then left to read it before the hardware comes round again.
    #[cold]
    fn skip(&mut self, written: Place) {
        self.read = Place { halves: written.halves.wrapping_sub(1), ..written };
        self.lost = true;
        // Ends the packet that lost bytes: what is read next may be the rest of another one.
        self.chunk[0] = 0;
        self.end = 1;
    }

    /// Where the hardware writes next.
    fn written(&self) -> Place {
        // Neither the copies before nor those behind may pass the look at the hardware.
        fence(Ordering::SeqCst);
        // Ends: the count changes once in half a buffer, which takes longer than this.
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
        // An even count has the first half filled next. Otherwise a boundary was passed just now, and its interrupt has not run yet.
        let behind = (halves % 2 == 1) != second;
        let offset = if second { position - Self::HALF } else { position };
        Place { halves: halves.wrapping_add(u32::from(behind)), offset }
    }

    /// Bytes from the next one to be copied to a place.
    fn waiting(&self, written: Place) -> usize {
        let halves = written.halves.wrapping_sub(self.read.halves) as usize;
        (halves.saturating_mul(Self::HALF).saturating_add(written.offset)).saturating_sub(self.read.offset)
    }

    /// Index in the buffer of the next byte to be copied.
    fn index(&self) -> usize {
        self.read.offset + if self.read.halves % 2 == 1 { Self::HALF } else { 0 }
    }
}
