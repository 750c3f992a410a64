//! The link of an STM32G474: USART2 at 1 Mbaud, whose bytes two channels of DMA1 move.
//!
//! | channel | does | interrupts |
//! |---|---|---|
//! | 1, request 26 | stores what comes, round and round in a buffer that `serve` reads behind it | at each half of the buffer; USART2 where the line falls idle |
//! | 2, request 27 | sends a piece of the queue out | behind each piece |
//!
//! Both buffers are zeroed variables, in SRAM1 (`memory.x`), which the DMA reaches. This core has no cache; a barrier stands before each piece
//! that is handed over.
//!
//! Written from the reference manual (RM0440) and compiled; **not yet run on silicon**.

use super::g474::CLOCK_HZ;
use super::pac::{DMA1, DMAMUX, USART2};
use core::sync::atomic::{AtomicU8, Ordering, fence};
use firmware::board::{INCOMING, LinkInput, LinkOutput, OUTGOING};
use link::{Circular, Filling, Halves, Outgoing, Sending};

/// One byte of a full buffer is never read: the hardware may be storing it anew. Two, so that there are halves.
const BUFFER: usize = INCOMING + 2;

static RECEIVED: [AtomicU8; BUFFER] = [const { AtomicU8::new(0) }; BUFFER];
static HALVES: Halves = Halves::new();
static TO_SEND: [AtomicU8; OUTGOING] = [const { AtomicU8::new(0) }; OUTGOING];

/// Channels, counted from 0, and what asks for their transfers.
const STORING: usize = 0;
const SENDING: usize = 1;
const USART2_RECEIVES: u8 = 26;
const USART2_SENDS: u8 = 27;

/// Bits per second.
const BAUD: u32 = 1_000_000;

/// The receiver, and the channel behind it.
pub struct Input(USART2);

/// Reader of the received bytes.
pub struct Incoming(Circular<Position, BUFFER>);

/// Where the receiving channel stores.
struct Position;

/// Queue out.
pub struct Output(Outgoing<Transmitter, OUTGOING>);

/// The channel before the transmitter. It owns the DMA; the other channel's registers are reached by [`dma`].
struct Transmitter(DMA1);

/// The link, whose pins and clocks are set up.
pub fn start(usart: USART2, dma: DMA1, requests: &DMAMUX) -> (Input, Incoming, Output) {
    let (storing, sending) = (dma.ch(STORING), dma.ch(SENDING));
    #[allow(unsafe_code, reason = "sets up and starts a channel, which writes to memory by itself")]
    // SAFETY: the requests are those of the manual's table. The first channel writes to `RECEIVED` alone, within its length, which is a static
    // of atomics: valid for ever, and changed by others at any time. The second one does nothing yet.
    unsafe {
        requests.ccr(STORING).write(|w| w.dmareq_id().bits(USART2_RECEIVES));
        requests.ccr(SENDING).write(|w| w.dmareq_id().bits(USART2_SENDS));
        storing.par().write(|w| w.pa().bits(usart.rdr().as_ptr().addr() as u32));
        storing.mar().write(|w| w.ma().bits(RECEIVED.as_ptr().addr() as u32));
        sending.par().write(|w| w.pa().bits(usart.tdr().as_ptr().addr() as u32));
    }
    storing.ndtr().write(|w| w.ndt().set(BUFFER as u16));
    // Bytes on both sides, as the reset has it.
    storing.cr().write(|w| {
        w.dir().from_peripheral().minc().enabled().circ().enabled().htie().enabled().tcie().enabled().en().enabled()
    });
    // After an error the channel is idle too, and the next piece follows.
    sending.cr().write(|w| w.dir().from_memory().minc().enabled().tcie().enabled().teie().enabled());

    usart.brr().write(|w| w.brr().set((CLOCK_HZ / BAUD) as u16));
    // A byte that comes too early costs its packet, and does not stop the receiver.
    usart.cr3().write(|w| w.dmat().enabled().dmar().enabled().ovrdis().set_bit());
    usart.cr1().write(|w| w.ue().enabled().re().enabled().te().enabled().idleie().enabled());
    (Input(usart), Incoming(Circular::new(&RECEIVED, Position)), Output(Outgoing::new(&TO_SEND, Transmitter(dma))))
}

/// The registers, for the receiving channel.
fn dma() -> &'static stm32g4::stm32g474::dma1::RegisterBlock {
    #[allow(unsafe_code, reason = "two interrupts have a channel each of one peripheral")]
    // SAFETY: the registers exist as long as the chip, and every access is volatile. Of those that both channels share, one is only read, and
    // of the other a written bit clears its own flag alone.
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

impl firmware::board::Incoming for Incoming {
    fn next(&mut self) -> Option<u8> {
        self.0.next_byte()
    }

    fn has_lost(&mut self) -> bool {
        self.0.has_lost()
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

impl LinkOutput for Output {
    fn write(&mut self, bytes: &[u8]) {
        self.0.write(bytes);
    }

    fn room(&mut self) -> usize {
        self.0.room()
    }

    fn sent(&mut self) {
        self.0.advance();
    }
}

impl Sending for Transmitter {
    fn is_idle(&mut self) -> bool {
        // An error disables the channel; behind the last byte it stays enabled, and has nothing left.
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
        // SAFETY: it reads this piece alone, which is valid for ever and of atomics; the channel is idle, and all else was set up by `start`.
        unsafe {
            channel.mar().write(|w| w.ma().bits(piece.as_ptr().addr() as u32));
        }
        // The bytes are in memory before the channel reads them.
        fence(Ordering::SeqCst);
        channel.cr().modify(|_, w| w.en().enabled());
    }
}
