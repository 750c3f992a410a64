//! The boards' DMA link in the emulated chip, which has no DMA. Code here moves the bytes instead, so that the rest of the DMA link runs in tests
//! and its instructions are counted.
//!
//! | on a board | here |
//! |---|---|
//! | the receiving stream | the receiver's interrupt, a byte at a time |
//! | the idle line | a zero, which ends a packet |
//! | the sending stream | [`transmit`], all at once |
//!
//! The cost of these three does not count as the link's cost.

use super::pac::{Interrupt, USART2};
use core::sync::atomic::{AtomicU8, AtomicUsize, Ordering, fence};
use firmware::board::{INCOMING, LinkInput, OUTGOING};
use link::{Circular, Filling, Halves, Outgoing, Sending};

const BUFFER: usize = INCOMING + 2;

static RECEIVED: [AtomicU8; BUFFER] = [const { AtomicU8::new(0) }; BUFFER];
static POSITION: AtomicUsize = AtomicUsize::new(0);
static HALVES: Halves = Halves::new();
static TO_SEND: [AtomicU8; OUTGOING] = [const { AtomicU8::new(0) }; OUTGOING];

/// The receiver and its stand-in for a DMA stream.
pub struct Input;

/// Reader of the received bytes.
pub type Incoming = Circular<Position, BUFFER>;

/// Position in the buffer at which the next byte is stored.
pub struct Position;

/// The transmit queue.
pub type Output = Outgoing<Transmitter, OUTGOING>;

/// The transmitter and its stand-in for a DMA stream.
pub struct Transmitter(USART2);

/// Starts the link on a USART that is set up. Never `None`; on a board it may be.
#[allow(clippy::unnecessary_wraps, reason = "as on a board")]
pub fn start(usart: USART2) -> Option<(Input, Incoming, Output)> {
    let outgoing = Outgoing::new(&TO_SEND, Transmitter(usart));
    Some((Input, Circular::new(&RECEIVED, Position), outgoing))
}

impl LinkInput for Input {
    fn received(&mut self) -> bool {
        #[allow(unsafe_code, reason = "the receiver's register; the transmitter's owner does not read it")]
        // SAFETY: a single volatile read of the data register, which nothing else reads.
        let byte = unsafe { (*USART2::ptr()).dr().read().dr().bits() } as u8;
        let at = POSITION.load(Ordering::Relaxed);
        if let Some(place) = RECEIVED.get(at) {
            place.store(byte, Ordering::Relaxed);
        }
        POSITION.store(if at + 1 == BUFFER { 0 } else { at + 1 }, Ordering::Relaxed);
        if at + 1 == BUFFER || at + 1 == BUFFER / 2 {
            rtic::pend(Interrupt::DMA1_STREAM5);
        }
        byte == 0
    }

    fn half_filled(&mut self) {
        // A DMA stream's flags would show which half it is.
        let first = POSITION.load(Ordering::Relaxed) >= BUFFER / 2;
        HALVES.count(first, !first);
    }
}

impl Filling for Position {
    fn position(&self) -> usize {
        POSITION.load(Ordering::Relaxed)
    }

    fn halves(&self) -> u32 {
        HALVES.so_far()
    }
}

impl Sending for Transmitter {
    fn is_idle(&mut self) -> bool {
        // Stands for reading a stream's register.
        self.0.cr3().read().dmat().is_disabled()
    }

    fn start(&mut self, piece: &'static [AtomicU8]) {
        fence(Ordering::SeqCst);
        transmit(&self.0, piece);
        rtic::pend(Interrupt::DMA1_STREAM6);
    }
}

/// Does the hardware's work. Not inlined, so that a count of instructions can exclude it by its name.
#[inline(never)]
fn transmit(usart: &USART2, piece: &[AtomicU8]) {
    for byte in piece {
        usart.dr().write(|w| w.dr().set(u16::from(byte.load(Ordering::Relaxed))));
    }
}
