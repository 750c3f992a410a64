//! The link without a DMA, for the emulated chip: an interrupt for each received byte, and a register write for each sent byte.

use super::pac;
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m::singleton;
use firmware::board::{INCOMING, LinkInput, LinkOutput, OUTGOING};
use heapless::spsc::{Consumer, Queue};
use link::{Arrival, Inlet};

/// Receiver of USART2. [`Output`] shares the peripheral, but does not use the register that is read here.
pub struct Input(Inlet);

/// The queue's reading end.
pub struct Incoming(Consumer<'static, u8>);

/// Transmitter of USART2.
pub struct Output(pac::USART2);

/// True if the queue was full when a byte arrived.
static LOST: AtomicBool = AtomicBool::new(false);

/// Starts the link on a USART that is set up; `None` if it was started before.
pub fn start(usart: pac::USART2) -> Option<(Input, Incoming, Output)> {
    // A queue holds one less than its size.
    let (bytes, pending) = singleton!(: Queue<u8, { INCOMING + 1 }> = Queue::new())?.split();
    Some((Input(Inlet::new(bytes)), Incoming(pending), Output(usart)))
}

impl LinkInput for Input {
    fn received(&mut self) -> bool {
        // The status register is not read: each access wakes the emulator's input loop, which is most of a byte's cost. Reading the data register
        // acknowledges the interrupt, which occurs once per byte, so there always is a byte.
        #[allow(unsafe_code, reason = "the receiver's register; the transmitter's owner does not read it")]
        // SAFETY: a single volatile read of the data register, which nothing else reads.
        let byte = unsafe { (*pac::USART2::ptr()).dr().read().dr().bits() };
        let arrival = self.0.push(byte as u8);
        if arrival == Arrival::Lost {
            LOST.store(true, Ordering::Relaxed);
        }
        arrival != Arrival::Waits
    }
}

impl firmware::board::Incoming for Incoming {
    fn next(&mut self) -> Option<u8> {
        self.0.dequeue()
    }

    fn has_lost(&mut self) -> bool {
        LOST.load(Ordering::Relaxed) && LOST.swap(false, Ordering::Relaxed)
    }
}

impl LinkOutput for Output {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            // The emulated transmitter takes a byte at once: there is no need to wait, and reading the status would take time.
            self.0.dr().write(|w| w.dr().set(u16::from(byte)));
        }
    }

    // No byte ever waits.
    fn room(&mut self) -> usize {
        OUTGOING
    }
}
