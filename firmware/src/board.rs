//! Interface of a board. Each board has one file that implements it; only files in `boards/` use the chip's registers.

use crate::joint_io::JointIo;
use link::{Circular, Filling, Nonce, NonceSource, Outgoing, Sending};
use session::meter::Counter;
use session::readings::Lines;

/// Receiving half of the link, for its interrupts. They have a higher priority than the tick.
pub trait LinkInput {
    /// Handles and acknowledges the receiver's interrupt: a byte has arrived or, if a DMA stores the bytes, the line is idle. Returns true if
    /// there is something to read.
    fn received(&mut self) -> bool;

    /// Handles the interrupt of the DMA that stores the bytes, at each half of its buffer.
    fn half_filled(&mut self) {}
}

/// Receiving half of the link, for the task that reads its bytes.
pub trait Incoming {
    /// Returns the next byte, if one has arrived. If bytes were lost, a zero ends the packet that they belonged to.
    fn next(&mut self) -> Option<u8>;

    /// True if bytes were lost since the last call.
    fn has_lost(&mut self) -> bool;
}

impl<F: Filling, const SIZE: usize> Incoming for Circular<F, SIZE> {
    fn next(&mut self) -> Option<u8> {
        self.next_byte()
    }

    fn has_lost(&mut self) -> bool {
        Self::has_lost(self)
    }
}

/// Sending half of the link. Called at a lower priority than the tick's.
pub trait LinkOutput {
    /// Sends all bytes. Waits for the line if the queue is full.
    fn write(&mut self, bytes: &[u8]);

    /// Returns the number of bytes that [`LinkOutput::write`] takes now without waiting, up to [`OUTGOING`].
    fn room(&mut self) -> usize;

    /// Handles the interrupt of the DMA that sends the bytes, at the end of each piece.
    fn sent(&mut self) {}
}

impl<S: Sending, const SIZE: usize> LinkOutput for Outgoing<S, SIZE> {
    fn write(&mut self, bytes: &[u8]) {
        Self::write(self, bytes);
    }

    fn room(&mut self) -> usize {
        Self::room(self)
    }

    fn sent(&mut self) {
        self.advance();
    }
}

/// The control timer. Its interrupt runs the tick.
pub trait Ticker {
    /// Starts the timer at the control rate.
    fn run(&mut self);

    /// Stops the timer: only [`Ticker::trigger`] starts ticks.
    fn hold(&mut self);

    /// Acknowledges the interrupt that started this tick.
    fn acknowledge(&mut self);

    /// True if the next tick has become due since [`Ticker::acknowledge`].
    fn is_due(&self) -> bool;

    /// Starts one tick now, through the timer's interrupt.
    fn trigger(&mut self);
}

/// A board's input lines that do not belong to joints, and its watchdog.
pub trait BoardLines {
    /// Returns the present state of the lines. Called at the start of every tick.
    fn read(&mut self) -> Lines;

    /// Feeds the watchdog. Called after every tick of a live session that ended in time. The first call starts the watchdog; after that the chip
    /// is reset if the calls stop, and a reset leaves the drives off.
    fn feed(&mut self);
}

/// Origin of nonces.
pub trait Nonces {
    /// Returns a number that is never repeated, and its origin; `None` if the origin has failed. Called at a lower priority than the tick's.
    fn next(&mut self) -> Option<(Nonce, NonceSource)>;
}

/// Capacity for received bytes: three whole packets, the most that a host sends before it waits for an answer (live inputs, reference,
/// measurement).
pub const INCOMING: usize = 3 * link::PACKET_MAX;

/// Capacity for bytes that wait for a DMA to send them: four whole packets. [`REPORT_ROOM`], [`STRANGER_ROOM`] and [`ANSWER_ROOM`] limit its use.
pub const OUTGOING: usize = 4 * link::PACKET_MAX;

/// Free capacity required to send a report, bytes: at most one packet waits before it.
pub const REPORT_ROOM: usize = OUTGOING - link::PACKET_MAX;

/// Free capacity required to send answers to packets from outside the session, bytes: a report still fits after them.
pub const STRANGER_ROOM: usize = REPORT_ROOM + link::channel::ANSWERS_MAX;

/// Free capacity required to send an answer to the session's host, bytes; refusals and values are shorter. If there is less, the answer is
/// dropped: a host that asks so often does not read the answers, and reading its next request is more important, because it may be a stop.
pub const ANSWER_ROOM: usize = 64;

/// Largest number of received bytes that are read before reports are sent again: a full buffer.
pub const READ_AT_ONCE: usize = INCOMING;

/// The parts of a started board. Different interrupts own them.
pub struct Parts<B: Board<N> + ?Sized, const N: usize> {
    /// Receiving half of the link, for its interrupts.
    pub input: B::Input,
    /// The bytes that it has received.
    pub incoming: B::Incoming,
    /// Sending half of the link.
    pub output: B::Output,
    /// The control timer.
    pub ticker: B::Ticker,
    /// Counter for the cost of a tick.
    pub counter: B::Counter,
    /// Emergency stop, supply, temperature, watchdog.
    pub lines: B::Lines,
    /// The joints.
    pub joints: B::Joints,
    /// Numbers that are used once.
    pub nonces: B::Nonces,
}

/// A board for an arm of `N` joints.
pub trait Board<const N: usize> {
    /// The chip's peripherals.
    type Peripherals;
    /// Receiving half of the link, for its interrupts.
    type Input: LinkInput;
    /// The bytes that it has received.
    type Incoming: Incoming;
    /// Sending half of the link.
    type Output: LinkOutput;
    /// The control timer.
    type Ticker: Ticker;
    /// Counter for the cost of a tick.
    type Counter: Counter;
    /// Emergency stop, supply, temperature, watchdog.
    type Lines: BoardLines;
    /// The joints.
    type Joints: JointIo<N>;
    /// Numbers that are used once.
    type Nonces: Nonces;

    /// Name of the board.
    const NAME: &'static str;

    /// Sets up clocks, link and timers; `rate_hz` is the control rate, Hz. Brakes are engaged and the control timer is stopped when this returns.
    fn start(peripherals: Self::Peripherals, rate_hz: f32) -> Parts<Self, N>;

    /// Ends the program, from any state: switches the drives off and engages the brakes, then writes the log, then stops.
    fn halt(write_log: impl FnOnce()) -> !;
}
