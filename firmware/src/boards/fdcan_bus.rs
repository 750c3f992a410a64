//! An FDCAN controller of an STM32G4 with the interface that the schedule of [`firmware::joint_io::can`] needs.
//!
//! Written from the reference manual (RM0440) and compiled; **not yet run on silicon**. The `fdcan` crate (0.2.1) is not used, for two reasons. It
//! does not set the compensation of the transceiver's delay, without which a sender at 5 Mbit/s reads its own bits wrong. And it waits without a
//! bound for an aborted frame.
//!
//! A controller holds three frames to send, the lowest identifier first, and three received ones.
//! [`Queued`](firmware::joint_io::queued::Queued) adds queues, which move frames at the controller's interrupt.
//!
//! | bit at 170 MHz | sampled at | clocks: synchronisation, before, after the sample |
//! |---|---|---|
//! | nominal, 1 Mbit/s | 80 % | 1 + 135 + 34 |
//! | data, 5 Mbit/s | 76 % | 1 + 25 + 8 |
//! | data, 2 Mbit/s, of five clocks each | 76 % | 1 + 12 + 4 |

use super::can_frame::Frame;
use super::pac::fdcan;
use core::sync::atomic::{AtomicU32, Ordering, fence};
use dynamics_core::drive::DataRate;
use embedded_can::{ErrorKind, ExtendedId, Id, StandardId};
use firmware::joint_io::can_bus::CanBus;
use firmware::joint_io::frames::Packet;
use stm32g4::{Periph, Reg, Resettable, Writable};

type Registers = fdcan::RegisterBlock;

/// Address of the controllers' message memory, and the length of each controller's part, words.
const MEMORY_AT: usize = 0x4000_a400;
const MEMORY_WORDS: usize = 212;
/// Offsets in a part of received frames and of frames to send, and the length of a frame, words.
const RECEIVED_AT: usize = 44;
const TO_SEND_AT: usize = 158;
const FRAME_WORDS: usize = 18;

/// Addresses of the controllers' registers.
pub const FIRST: usize = 0x4000_6400;
pub const SECOND: usize = 0x4000_6800;
pub const THIRD: usize = 0x4000_6c00;

/// Number of buffers for frames to send.
const ROOMS: u32 = 3;

/// First word of a frame: flag of an extended identifier, flag of a remote request, bit position of a standard identifier.
const EXTENDED: u32 = 1 << 30;
const REMOTE: u32 = 1 << 29;
const STANDARD_AT: u32 = 18;
/// Second word: bit position of the length, flags of bit-rate switching and of an FD frame.
const LENGTH_AT: u32 = 16;
const SWITCHES_RATE: u32 = 1 << 20;
const FD: u32 = 1 << 21;

/// CCCR: off the bus, configuration enabled, FD frames, bit-rate switching.
const INIT: u32 = 1 << 0;
const OPEN: u32 = 1 << 1;
const FD_OPERATION: u32 = 1 << 8;
const RATE_SWITCH: u32 = 1 << 9;
/// DBTP: transceiver delay compensation.
const COMPENSATED: u32 = 1 << 23;
/// TXBC: queue mode, the lowest identifier first.
const QUEUE: u32 = 1 << 24;
/// IR and IE: a frame was received, lost, sent, or aborted.
const HAS_COME: u32 = 1 << 0;
const LOST: u32 = 1 << 2;
const SENT: u32 = 1 << 7;
const GIVEN_UP: u32 = 1 << 8;

/// NBTP: 1 Mbit/s, resynchronised by up to 34 clocks.
const NOMINAL_TIMING: u32 = (34 - 1) << 25 | (135 - 1) << 8 | (34 - 1);

/// Bit timing of the data of FD frames.
struct DataTiming {
    dbtp: u32,
    tdcr: u32,
}

impl DataTiming {
    /// Timing of a data rate. The compensation makes a sender sample its returning bits at the receiver's sample point, after the measured delay.
    const fn of(rate: DataRate) -> Self {
        match rate {
            DataRate::Mbit5 => Self { dbtp: COMPENSATED | (25 - 1) << 8 | (8 - 1) << 4 | (7 - 1), tdcr: (1 + 25) << 8 },
            DataRate::Mbit2 => Self {
                dbtp: COMPENSATED | (5 - 1) << 16 | (12 - 1) << 8 | (4 - 1) << 4 | (3 - 1),
                tdcr: (5 * (1 + 12)) << 8,
            },
        }
    }
}

/// Value of CCCR for a controller that is on its bus.
const fn mode(fd: bool) -> u32 {
    if fd { FD_OPERATION | RATE_SWITCH } else { 0 }
}

/// A controller on a bus. `AT` is the address of its registers.
pub struct Bus<const AT: usize> {
    owner: Periph<Registers, AT>,
    memory: &'static [AtomicU32; MEMORY_WORDS],
    /// True for FD frames with bit-rate switching.
    fd: bool,
}

impl<const AT: usize> Bus<AT> {
    /// Starts a controller, for FD frames at this data rate or for classic ones. Its clock and pins must be set up. It joins the bus as soon as
    /// that is idle. A controller that is not `wired` stays off.
    pub fn start(owner: Periph<Registers, AT>, rate: Option<DataRate>, wired: bool) -> Self {
        let registers = &*owner;
        put(registers.cccr(), INIT);
        while registers.cccr().read().bits() & INIT == 0 {}
        put(registers.cccr(), INIT | OPEN);
        put(registers.nbtp(), NOMINAL_TIMING);
        let mode = mode(rate.is_some());
        if let Some(DataTiming { dbtp, tdcr }) = rate.map(DataTiming::of) {
            put(registers.dbtp(), dbtp);
            put(registers.tdcr(), tdcr);
        }
        // All frames go to receive FIFO 0, which keeps the old frames if it is full.
        put(registers.rxgfc(), 0);
        put(registers.txbc(), QUEUE);
        put(registers.txbtie(), (1 << ROOMS) - 1);
        put(registers.txbcie(), (1 << ROOMS) - 1);
        put(registers.ie(), HAS_COME | SENT | GIVEN_UP);
        // All interrupts use the first of the two lines.
        put(registers.ile(), 1);
        let memory = memory::<AT>();
        memory.iter().for_each(|word| word.store(0, Ordering::Relaxed));
        put(registers.cccr(), INIT | OPEN | mode);
        if wired {
            put(registers.cccr(), mode);
        }
        Self { owner, memory, fd: rate.is_some() }
    }
}

/// A controller's part of the memory.
fn memory<const AT: usize>() -> &'static [AtomicU32; MEMORY_WORDS] {
    let index = const {
        match AT {
            FIRST => 0,
            SECOND => 1,
            THIRD => 2,
            _ => panic!("no controller stands there"),
        }
    };
    let at = MEMORY_AT + index * MEMORY_WORDS * size_of::<u32>();
    #[allow(unsafe_code, reason = "memory of the controllers, at the address that the reference manual gives")]
    // SAFETY: three parts of this length exist there as long as the chip, aligned to words, and are accessed by words. Controller and core both
    // write to it, as to atomics.
    unsafe {
        &*core::ptr::with_exposed_provenance(at)
    }
}

fn registers<const AT: usize>() -> &'static Registers {
    #[allow(unsafe_code, reason = "the program is over; whoever owned the controller does not run again")]
    // SAFETY: the registers exist as long as the chip, and every access is volatile.
    unsafe {
        &*Periph::<Registers, AT>::ptr()
    }
}

/// Writes a whole register.
fn put<R: Writable + Resettable<Ux = u32>>(register: &Reg<R>, bits: u32) {
    #[allow(unsafe_code, reason = "whole registers, as the reference manual lays them out")]
    // SAFETY: the controller's registers name no memory of the program: no bits in them break its rules.
    unsafe {
        register.write(|w| w.bits(bits));
    }
}

/// An identifier in the format of a frame's first word.
fn head(id: Id) -> u32 {
    match id {
        Id::Standard(id) => u32::from(id.as_raw()) << STANDARD_AT,
        Id::Extended(id) => id.as_raw() | EXTENDED,
    }
}

/// The identifier in a frame's first word; `None` for a remote request.
fn identifier(head: u32) -> Option<Id> {
    match head & (EXTENDED | REMOTE) {
        0 => StandardId::new((head >> STANDARD_AT & 0x7ff) as u16).map(Id::Standard),
        EXTENDED => ExtendedId::new(head & 0x1fff_ffff).map(Id::Extended),
        _ => None,
    }
}

/// The words of a frame's buffer.
fn room(memory: &[AtomicU32; MEMORY_WORDS], first: usize, index: u32) -> Option<&[AtomicU32; 4]> {
    memory.get(first + FRAME_WORDS * index as usize..)?.first_chunk()
}

/// Puts a data frame into a free buffer; returns false if there is none.
fn queue(registers: &Registers, memory: &[AtomicU32; MEMORY_WORDS], fd: bool, frame: &Frame) -> bool {
    let status = registers.txfqs().read();
    if status.tfqf().bit_is_set() {
        return false;
    }
    let index = u32::from(status.tfqpi().bits());
    let Some([first, second, low, high]) = room(memory, TO_SEND_AT, index) else { return false };
    let [a, b, c, d, e, f, g, h] = frame.bytes;
    first.store(head(frame.id), Ordering::Relaxed);
    second.store(u32::from(frame.length) << LENGTH_AT | if fd { FD | SWITCHES_RATE } else { 0 }, Ordering::Relaxed);
    low.store(u32::from_le_bytes([a, b, c, d]), Ordering::Relaxed);
    high.store(u32::from_le_bytes([e, f, g, h]), Ordering::Relaxed);
    // The barrier ensures that the frame is in memory before the controller reads it.
    fence(Ordering::SeqCst);
    put(registers.txbar(), 1 << index);
    true
}

/// Requests the abort of every waiting frame. A frame on the wire is still sent to its end.
fn give_up(registers: &Registers) {
    // Only buffers with a frame: aborting an empty one would also cause an interrupt.
    put(registers.txbcr(), registers.txbrp().read().bits());
}

/// Sends the last frames of the program, after aborting all others. Takes bounded time and needs no ownership of the controller: call it with
/// interrupts off, as the last action of the program.
pub fn send_last<const AT: usize>(fd: bool, packets: impl Iterator<Item = Packet>) {
    /// Number of attempts before a frame is dropped: two frames at 1 Mbit/s take 270 us, an attempt some 20 cycles at 170 MHz.
    const LOOKS: u32 = 10_000;
    let (registers, memory) = (registers::<AT>(), memory::<AT>());
    give_up(registers);
    for Packet { id, data } in packets {
        let frame = Frame { id, length: 8, bytes: data };
        for _ in 0..LOOKS {
            if queue(registers, memory, fd, &frame) {
                break;
            }
        }
    }
}

impl<const AT: usize> embedded_can::nb::Can for Bus<AT> {
    type Frame = Frame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ErrorKind> {
        let sent = queue(&self.owner, self.memory, self.fd, frame);
        if sent { Ok(None) } else { Err(nb::Error::WouldBlock) }
    }

    fn receive(&mut self) -> nb::Result<Frame, ErrorKind> {
        let registers = &*self.owner;
        let status = registers.rxf0s().read();
        if status.rf0l().bit_is_set() {
            put(registers.ir(), LOST);
            return Err(nb::Error::Other(ErrorKind::Overrun));
        }
        if status.f0fl().bits() == 0 {
            return Err(nb::Error::WouldBlock);
        }
        let index = u32::from(status.f0gi().bits());
        // The status is read before the frame.
        fence(Ordering::SeqCst);
        let words = room(self.memory, RECEIVED_AT, index);
        let [head, kind, low, high] =
            words.map_or([REMOTE, 0, 0, 0], |words| words.each_ref().map(|word| word.load(Ordering::Relaxed)));
        // The frame is read before its buffer is released.
        fence(Ordering::SeqCst);
        put(registers.rxf0a(), index);
        let length = kind >> LENGTH_AT & 0xf;
        let ([a, b, c, d], [e, f, g, h]) = (low.to_le_bytes(), high.to_le_bytes());
        match identifier(head) {
            // In a classic frame a length code above 8 means 8. An FD frame with such a code is longer and belongs to no drive.
            Some(id) if length <= 8 || kind & FD == 0 => {
                Ok(Frame { id, length: length.min(8) as u8, bytes: [a, b, c, d, e, f, g, h] })
            }
            _ => Err(nb::Error::Other(ErrorKind::Other)),
        }
    }
}

impl<const AT: usize> CanBus for Bus<AT> {
    fn is_off(&mut self) -> bool {
        let off = self.owner.psr().read().bo().bit_is_set();
        // The controller has left the bus. Once INIT is cleared, it returns after 129 times 11 recessive bits.
        if off && self.owner.cccr().read().bits() & INIT != 0 {
            put(self.owner.cccr(), mode(self.fd));
        }
        off
    }

    fn abandon(&mut self) {
        give_up(&self.owner);
    }

    fn interrupt(&mut self) {
        put(self.owner.ir(), HAS_COME | SENT | GIVEN_UP);
    }
}
