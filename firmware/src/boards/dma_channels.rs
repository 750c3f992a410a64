//! The link of an STM32G474: USART2 at 1 Mbaud with two channels of DMA1.
//!
//! | channel | does | interrupts |
//! |---|---|---|
//! | 1, request 26 | stores received bytes in a circular buffer for `serve` | at each half of the buffer; USART2's when the line becomes idle |
//! | 2, request 27 | sends a piece of the transmit queue | at the end of each piece |
//!
//! Both buffers are zero-initialised statics in SRAM1 (`memory.x`), which the DMA can access. The core has no data cache; a memory barrier precedes
//! the start of each piece.
//!
//! Written from the reference manual (RM0440) and compiled; **not yet run on silicon**.

use super::g474::CLOCK_HZ;
use super::pac::{DMA1, DMAMUX, USART2};
use core::sync::atomic::{AtomicU8, Ordering, fence};
use firmware::board::{INCOMING, LinkInput, OUTGOING};
use link::{Circular, Filling, Halves, Outgoing, Sending};

/// Size of the receive buffer. One byte more than can be read, because the hardware may be overwriting it, and another one so that the size is
/// even.
const BUFFER: usize = INCOMING + 2;

static RECEIVED: [AtomicU8; BUFFER] = [const { AtomicU8::new(0) }; BUFFER];
static HALVES: Halves = Halves::new();
static TO_SEND: [AtomicU8; OUTGOING] = [const { AtomicU8::new(0) }; OUTGOING];

/// Channels, counted from 0, and the requests that start their transfers.
const STORING: usize = 0;
const SENDING: usize = 1;
const USART2_RECEIVES: u8 = 26;
const USART2_SENDS: u8 = 27;

/// Bits per second.
const BAUD: u32 = 1_000_000;

/// The receiver and its interrupts.
pub struct Input(USART2);

/// Reader of the received bytes.
pub type Incoming = Circular<Position, BUFFER>;

/// Position in the buffer at which the receiving channel stores.
pub struct Position;

/// The transmit queue.
pub type Output = Outgoing<Transmitter, OUTGOING>;

/// The sending channel. It owns the DMA; the other channel's registers are accessed through [`dma`].
pub struct Transmitter(DMA1);

/// Starts the link. Pins and clocks must be set up.
pub fn start(usart: USART2, dma: DMA1, requests: &DMAMUX) -> (Input, Incoming, Output) {
    let (storing, sending) = (dma.ch(STORING), dma.ch(SENDING));
    #[allow(unsafe_code, reason = "sets up and starts a channel, which writes to memory by itself")]
    // SAFETY: the requests are those of the manual's table. The first channel writes only to `RECEIVED`, within its length. That is a static of
    // atomics, so it is valid for ever and may change at any time. The second channel does nothing yet.
    unsafe {
        requests.ccr(STORING).write(|w| w.dmareq_id().bits(USART2_RECEIVES));
        requests.ccr(SENDING).write(|w| w.dmareq_id().bits(USART2_SENDS));
        storing.par().write(|w| w.pa().bits(usart.rdr().as_ptr().addr() as u32));
        storing.mar().write(|w| w.ma().bits(RECEIVED.as_ptr().addr() as u32));
        sending.par().write(|w| w.pa().bits(usart.tdr().as_ptr().addr() as u32));
    }
    storing.ndtr().write(|w| w.ndt().set(BUFFER as u16));
    // Transfers are of single bytes on both sides, as after reset.
    storing.cr().write(|w| {
        w.dir().from_peripheral().minc().enabled().circ().enabled().htie().enabled().tcie().enabled().en().enabled()
    });
    // After an error the channel is idle too, and the next piece can be sent.
    sending.cr().write(|w| w.dir().from_memory().minc().enabled().tcie().enabled().teie().enabled());

    usart.brr().write(|w| w.brr().set((CLOCK_HZ / BAUD) as u16));
    // An overrun damages a packet, but does not stop the receiver.
    usart.cr3().write(|w| w.dmat().enabled().dmar().enabled().ovrdis().set_bit());
    usart.cr1().write(|w| w.ue().enabled().re().enabled().te().enabled().idleie().enabled());
    (Input(usart), Circular::new(&RECEIVED, Position), Outgoing::new(&TO_SEND, Transmitter(dma)))
}

/// The DMA's registers, for the receiving channel.
fn dma() -> &'static stm32g4::stm32g474::dma1::RegisterBlock {
    #[allow(unsafe_code, reason = "two interrupts have a channel each of one peripheral")]
    // SAFETY: the registers exist as long as the chip, and every access is volatile. Both channels share two registers: one is only read, and in
    // the other a written bit clears only its own flag.
    unsafe {
        &*DMA1::ptr()
    }
}

impl LinkInput for Input {
    fn received(&mut self) -> bool {
        self.0.icr().write(|w| w.idlecf().clear());
        true
    }

    fn half_filled(&mut self) {
        let flags = dma().isr().read();
        let (half, whole) = (flags.htif1().bit_is_set(), flags.tcif1().bit_is_set());
        dma().ifcr().write(|w| w.chtif1().bit(half).ctcif1().bit(whole));
        HALVES.count(half, whole);
    }
}

impl Filling for Position {
    fn position(&self) -> usize {
        let left = dma().ch(STORING).ndtr().read().ndt().bits();
        BUFFER - usize::from(left).min(BUFFER)
    }

    fn halves(&self) -> u32 {
        HALVES.so_far()
    }
}

impl Sending for Transmitter {
    fn is_idle(&mut self) -> bool {
        // An error disables the channel; after the last byte it stays enabled with no bytes left.
        let channel = self.0.ch(SENDING);
        let idle = channel.cr().read().en().is_disabled() || channel.ndtr().read().ndt().bits() == 0;
        if idle {
            channel.cr().modify(|_, w| w.en().disabled());
            self.0.ifcr().write(|w| w.cgif2().clear());
        }
        idle
    }

    fn start(&mut self, piece: &'static [AtomicU8]) {
        let channel = self.0.ch(SENDING);
        channel.ndtr().write(|w| w.ndt().set(piece.len() as u16));
        #[allow(unsafe_code, reason = "the address from which the channel reads memory by itself")]
        // SAFETY: the channel reads only this piece, which is a static of atomics; it is idle, and everything else was set up by `start`.
        unsafe {
            channel.mar().write(|w| w.ma().bits(piece.as_ptr().addr() as u32));
        }
        // The barrier ensures that the bytes are in memory before the channel reads them.
        fence(Ordering::SeqCst);
        channel.cr().modify(|_, w| w.en().enabled());
    }
}
