//! A bxCAN controller with the interface that the schedule of [`firmware::joint_io::can`] needs.
//!
//! The `bxcan` crate sets the controller up. Frames, sending and receiving are implemented here instead, because its `transmit` can wait without
//! a bound for a mailbox with an aborted frame, its frames can panic in the tick, and it does not report bus-off.

use super::can_frame::Frame;
use super::pac;
use embedded_can::{ErrorKind, ExtendedId, Id, StandardId};
use firmware::joint_io::can_bus::CanBus;
use firmware::joint_io::frames::Packet;
use stm32f4xx_hal::can::Can;

type Registers = pac::can1::RegisterBlock;

/// A CAN controller and the address of its registers.
pub trait Controller: bxcan::Instance {
    /// The registers.
    const REGISTERS_AT: *const Registers;
}

impl Controller for Can<pac::CAN1> {
    const REGISTERS_AT: *const Registers = pac::CAN1::ptr();
}

impl Controller for Can<pac::CAN2> {
    const REGISTERS_AT: *const Registers = pac::CAN2::ptr();
}

/// Bit timing for 1 Mbit/s from 42 MHz: 3 clocks per quantum, 1 + 11 + 2 quanta per bit, sample point at 86 %, resynchronisation by one quantum.
pub const BIT_TIMING_1_MBIT: u32 = 1 << 20 | 10 << 16 | 2;

/// Mailboxes of a controller.
const MAILBOXES: usize = 3;

/// RFxR: mask of the number of frames that wait; a frame was lost; release a frame.
const WAITING: u32 = 0b11;
const OVERRUN: u32 = 1 << 4;
const RELEASE: u32 = 1 << 5;
/// ESR: the controller has left the bus.
const BUS_OFF: u32 = 1 << 2;
/// TxIR: request to send. TxIR and RxIR: remote request, extended identifier.
const REQUEST: u32 = 1;
const REMOTE: u32 = 1 << 1;
const EXTENDED: u32 = 1 << 2;

/// TSR: the bit for an empty mailbox, and the bit that aborts its frame.
const fn empty_bit(mailbox: usize) -> u32 {
    1 << (26 + mailbox)
}
const fn abort_bit(mailbox: usize) -> u32 {
    1 << (7 + 8 * mailbox)
}

/// A controller on a bus.
pub struct Bus<C: Controller> {
    _controller: bxcan::Can<C>,
}

impl<C: Controller> Bus<C> {
    /// Creates a bus from a controller that is set up. The controller joins as soon as the bus is idle, and also returns after bus-off, without
    /// the processor. This function does not wait for that, because the wait could last for ever.
    pub fn new(mut controller: bxcan::Can<C>) -> Self {
        controller.enable_non_blocking().ok();
        Self { _controller: controller }
    }

    fn registers(&self) -> &'static Registers {
        registers::<C>()
    }
}

fn registers<C: Controller>() -> &'static Registers {
    #[allow(unsafe_code, reason = "the crate that owns the peripheral does not lend its registers")]
    // SAFETY: the address is that of the peripheral's registers, which exist as long as the chip. Every access is
    // volatile; a `Bus` contains the only owner of the peripheral.
    unsafe {
        &*C::REGISTERS_AT
    }
}

/// An identifier in the format of TxIR.
fn head(id: Id) -> u32 {
    match id {
        Id::Standard(id) => u32::from(id.as_raw()) << 21,
        Id::Extended(id) => id.as_raw() << 3 | EXTENDED,
    }
}

/// The identifier in RxIR; `None` for a remote request.
fn identifier(head: u32) -> Option<Id> {
    match head & (EXTENDED | REMOTE) {
        0 => StandardId::new((head >> 21) as u16).map(Id::Standard),
        EXTENDED => ExtendedId::new(head >> 3).map(Id::Extended),
        _ => None,
    }
}

/// Puts a data frame into an empty mailbox; returns false if there is none.
fn queue(registers: &Registers, id: Id, length: u8, bytes: [u8; 8]) -> bool {
    let status = registers.tsr().read().bits();
    let Some(mailbox) = (0..MAILBOXES).find(|&mailbox| status & empty_bit(mailbox) != 0) else { return false };
    let [a, b, c, d, e, f, g, h] = bytes;
    let mailbox = registers.tx(mailbox);
    #[allow(unsafe_code, reason = "whole registers, as the reference manual lays them out")]
    // SAFETY: the mailbox is empty, so these registers belong to the program; every bit pattern is a frame.
    unsafe {
        mailbox.tdtr().write(|w| w.bits(u32::from(length)));
        mailbox.tdlr().write(|w| w.bits(u32::from_le_bytes([a, b, c, d])));
        mailbox.tdhr().write(|w| w.bits(u32::from_le_bytes([e, f, g, h])));
        mailbox.tir().write(|w| w.bits(head(id) | REQUEST));
    }
    true
}

/// Requests the abort of every waiting frame. A frame on the wire is still sent to its end.
fn give_up(registers: &Registers) {
    let status = registers.tsr().read().bits();
    let bits = (0..MAILBOXES)
        .filter(|&mailbox| status & empty_bit(mailbox) == 0)
        .fold(0, |bits, mailbox| bits | abort_bit(mailbox));
    #[allow(unsafe_code, reason = "whole registers, as the reference manual lays them out")]
    // SAFETY: only requests to abort are set; writing zero changes nothing in this register.
    unsafe {
        registers.tsr().write(|w| w.bits(bits));
    }
}

/// Sends the last frames of the program, after aborting all others. Takes bounded time and needs no ownership of the controller: call it with
/// interrupts off, as the last action of the program.
pub fn send_last<C: Controller>(packets: impl Iterator<Item = Packet>) {
    /// Number of attempts before a frame is dropped: two frames at 1 Mbit/s take 270 us, an attempt some 20 cycles at 168 MHz.
    const LOOKS: u32 = 10_000;
    let registers = registers::<C>();
    give_up(registers);
    for Packet { id, data } in packets {
        for _ in 0..LOOKS {
            if queue(registers, id, 8, data) {
                break;
            }
        }
    }
}

impl<C: Controller> embedded_can::nb::Can for Bus<C> {
    type Frame = Frame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ErrorKind> {
        let sent = queue(self.registers(), frame.id, frame.length, frame.bytes);
        if sent { Ok(None) } else { Err(nb::Error::WouldBlock) }
    }

    fn receive(&mut self) -> nb::Result<Frame, ErrorKind> {
        let registers = self.registers();
        let status = registers.rfr(0).read().bits();
        if status & OVERRUN != 0 {
            set_fifo(registers, OVERRUN);
            return Err(nb::Error::Other(ErrorKind::Overrun));
        }
        if status & WAITING == 0 {
            return Err(nb::Error::WouldBlock);
        }
        let fifo = registers.rx(0);
        let (head, length) = (fifo.rir().read().bits(), fifo.rdtr().read().bits());
        let [a, b, c, d] = fifo.rdlr().read().bits().to_le_bytes();
        let [e, f, g, h] = fifo.rdhr().read().bits().to_le_bytes();
        set_fifo(registers, RELEASE);
        match identifier(head) {
            // A length code above 8 means 8.
            Some(id) => Ok(Frame { id, length: (length & 0xf).min(8) as u8, bytes: [a, b, c, d, e, f, g, h] }),
            None => Err(nb::Error::Other(ErrorKind::Other)),
        }
    }
}

fn set_fifo(registers: &Registers, bit: u32) {
    #[allow(unsafe_code, reason = "whole registers, as the reference manual lays them out")]
    // SAFETY: the bit is set to act and cleared by the hardware; writing zero changes nothing in this register.
    unsafe {
        registers.rfr(0).write(|w| w.bits(bit));
    }
}

impl<C: Controller> CanBus for Bus<C> {
    fn is_off(&mut self) -> bool {
        self.registers().esr().read().bits() & BUS_OFF != 0
    }

    fn abandon(&mut self) {
        give_up(self.registers());
    }
}
