//! The link of an STM32F405: USART2 at 1 Mbaud with two streams of DMA1.
//!
//! | stream | does | interrupts |
//! |---|---|---|
//! | 5, channel 4 | stores received bytes in a circular buffer for `serve` | at each half of the buffer; USART2's when the line becomes idle |
//! | 6, channel 4 | sends a piece of the transmit queue | at the end of each piece |
//!
//! Both buffers are zero-initialised statics in SRAM1 (`memory.x`), which the DMA can access. The core has no data cache; a memory barrier precedes
//! the start of each piece.
//!
//! Written from the reference manual (RM0090) and compiled; **not yet run on silicon**.

use super::pac::{DMA1, USART2};
use core::sync::atomic::{AtomicU8, Ordering, fence};
use firmware::board::{INCOMING, LinkInput, OUTGOING};
use link::{Circular, Filling, Halves, Outgoing, Sending};
use stm32f4xx_hal::dma::traits::{DMASet, DmaFlagExt as _, PeriAddress as _, Stream as _};
use stm32f4xx_hal::dma::{
    DmaChannel, DmaDirection, DmaEvent, MemoryToPeripheral, PeripheralToMemory, Stream5, Stream6, StreamsTuple,
};
use stm32f4xx_hal::gpio::{PA2, PA3};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::serial::config::{Config, DmaConfig};
use stm32f4xx_hal::serial::{Rx, Tx};

/// Size of the receive buffer. One byte more than can be read, because the hardware may be overwriting it, and another one so that the size is
/// even.
const BUFFER: usize = INCOMING + 2;

static RECEIVED: [AtomicU8; BUFFER] = [const { AtomicU8::new(0) }; BUFFER];
static HALVES: Halves = Halves::new();
static TO_SEND: [AtomicU8; OUTGOING] = [const { AtomicU8::new(0) }; OUTGOING];

/// The receiver and its DMA stream.
pub struct Input {
    line: Rx<USART2>,
    stream: Stream5<DMA1>,
}

/// Reader of the received bytes.
pub type Incoming = Circular<Position, BUFFER>;

/// Position in the buffer at which the receiving stream stores.
pub struct Position;

/// The transmit queue.
pub type Output = Outgoing<Transmitter, OUTGOING>;

/// The transmitter and its DMA stream.
pub struct Transmitter {
    _line: Tx<USART2>,
    stream: Stream6<DMA1>,
}

/// Starts the link on PA2 and PA3 at 1 Mbaud. `None` if the clock does not permit this rate; with [`clocks`](super::f405::clocks) it does, because
/// 42 MHz is 42 times the rate.
pub fn start(usart: USART2, dma: DMA1, pins: (PA2, PA3), rcc: &mut Rcc) -> Option<(Input, Incoming, Output)> {
    let config = Config::default().baudrate(1_000_000.bps()).dma(DmaConfig::TxRx);
    let (transmitter, mut line) = usart.serial(pins, config, rcc).ok()?.split();
    let StreamsTuple(.., mut storing, mut sending, _) = StreamsTuple::new(dma, rcc);
    // After reset both are disabled, transfer single bytes, and use no FIFO.
    belongs::<_, 4, PeripheralToMemory>(&line, &storing);
    storing.set_channel(DmaChannel::Channel4);
    storing.set_direction(DmaDirection::PeripheralToMemory);
    storing.set_peripheral_address(line.address());
    storing.set_memory_address(RECEIVED.as_ptr().addr() as u32);
    storing.set_number_of_transfers(BUFFER as u16);
    storing.set_memory_increment(true);
    storing.set_circular_mode(true);
    storing.listen(DmaEvent::HalfTransfer | DmaEvent::TransferComplete);
    #[allow(unsafe_code, reason = "starts the stream, which writes to memory by itself")]
    // SAFETY: the stream writes only to `RECEIVED`, within its length. That is a static of atomics, valid for ever, which may change at any time.
    unsafe {
        storing.enable();
    }
    line.listen_idle();

    belongs::<_, 4, MemoryToPeripheral>(&transmitter, &sending);
    sending.set_channel(DmaChannel::Channel4);
    sending.set_direction(DmaDirection::MemoryToPeripheral);
    sending.set_peripheral_address(transmitter.address());
    sending.set_memory_increment(true);
    // After an error the stream is idle too, and the next piece can be sent.
    sending.listen(DmaEvent::TransferComplete | DmaEvent::TransferError);
    let transmitter = Transmitter { _line: transmitter, stream: sending };
    Some((Input { line, stream: storing }, Circular::new(&RECEIVED, Position), Outgoing::new(&TO_SEND, transmitter)))
}

/// Checks at compile time that this stream and this channel serve this half of the link, by the manual's table.
fn belongs<STREAM, const CHANNEL: u8, DIRECTION>(_: &impl DMASet<STREAM, CHANNEL, DIRECTION>, _: &STREAM) {}

impl LinkInput for Input {
    fn received(&mut self) -> bool {
        // Reading status and data clears the idle flag and those of noise and overruns; the packet's check sum detects damaged bytes. Reading the
        // data does not take a byte from the DMA: at this priority the code runs well within the 10 us until the next byte.
        self.line.clear_idle_interrupt();
        true
    }

    fn half_filled(&mut self) {
        let flags = self.stream.flags();
        self.stream.clear_flags(flags);
        HALVES.count(flags.is_half_transfer(), flags.is_transfer_complete());
    }
}

impl Filling for Position {
    fn position(&self) -> usize {
        #[allow(unsafe_code, reason = "the stream's owner neither reads this register nor writes to it any more")]
        // SAFETY: a single volatile read, without a side effect.
        let left = unsafe { (*DMA1::ptr()).st(5).ndtr().read().ndt().bits() };
        BUFFER - usize::from(left).min(BUFFER)
    }

    fn halves(&self) -> u32 {
        HALVES.so_far()
    }
}

impl Sending for Transmitter {
    fn is_idle(&mut self) -> bool {
        // The stream disables itself after the last byte and after an error. The flags must be cleared before it is enabled again.
        let idle = !self.stream.is_enabled();
        if idle {
            self.stream.clear_all_flags();
        }
        idle
    }

    fn start(&mut self, piece: &'static [AtomicU8]) {
        self.stream.set_memory_address(piece.as_ptr().addr() as u32);
        self.stream.set_number_of_transfers(piece.len() as u16);
        // The barrier ensures that the bytes are in memory before the stream reads them.
        fence(Ordering::SeqCst);
        #[allow(unsafe_code, reason = "starts the stream, which reads memory by itself")]
        // SAFETY: the stream reads only this piece, which is a static of atomics; it is idle, and everything else was set up by `start`.
        unsafe {
            self.stream.enable();
        }
    }
}
