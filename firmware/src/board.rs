//! Interface of a board. One file per board implements this; nothing else names the chip's registers.

use crate::joint_io::JointIo;
use link::{Nonce, NonceSource};
use session::meter::Counter;
use session::readings::Lines;

/// Receiving half of the link, as its interrupts see it. They are more urgent than the tick.
pub trait LinkInput {
    /// The receiver's interrupt, which this acknowledges: a byte has come or, where a DMA stores the bytes, none comes any more. Whether
    /// there is something to read.
    fn received(&mut self) -> bool;

    /// The interrupt of the DMA that stores the bytes, at each half of its buffer.
    fn half_filled(&mut self) {}
}

/// Receiving half of the link, as the task that reads its bytes sees it.
pub trait Incoming {
    /// The next byte, if one has come. Where bytes were lost, a zero ends the packet that they belonged to.
    fn next(&mut self) -> Option<u8>;

    /// True if bytes were lost since this was last asked.
    fn has_lost(&mut self) -> bool;
}

/// Sending half of the link. Called below the priority of the tick.
pub trait LinkOutput {
    /// Send all bytes. Waits for the line where they find no room.
    fn write(&mut self, bytes: &[u8]);

    /// Bytes that [`LinkOutput::write`] takes now without waiting, up to [`OUTGOING`].
    fn room(&mut self) -> usize;

    /// The interrupt of the DMA that sends the bytes, behind each piece.
    fn sent(&mut self) {}
}

/// The timer whose interrupt owns the control tick.
pub trait Ticker {
    /// Let the timer run at the control rate.
    fn run(&mut self);

    /// Hold the timer: ticks come from [`Ticker::trigger`] alone.
    fn hold(&mut self);

    /// Acknowledge the interrupt that started this tick.
    fn acknowledge(&mut self);

    /// True if the next tick became due since [`Ticker::acknowledge`].
    fn is_due(&self) -> bool;

    /// Start one tick now, through the timer's own interrupt.
    fn trigger(&mut self);
}

/// A board's lines beside its joints, and the watchdog.
pub trait BoardLines {
    /// State of the lines now. Called at the start of every tick.
    fn read(&mut self) -> Lines;

    /// A tick that drives has ended in time. The first one starts the watchdog; from then on only this keeps the chip from a reset,
    /// and a reset leaves the drives off.
    fn feed(&mut self);
}

/// Origin of nonces.
pub trait Nonces {
    /// A number that never comes again, and its origin; `None` where the origin has failed. Called below the priority of the
    /// tick.
    fn next(&mut self) -> Option<(Nonce, NonceSource)>;
}

/// Bytes that wait for the task that reads them: three whole packets, the most that a host sends before it waits for an answer (live
/// inputs, reference, measurement).
pub const INCOMING: usize = 3 * link::PACKET_MAX;

/// Bytes that wait for a DMA to send them: four whole packets. [`REPORT_ROOM`] and [`ANSWER_ROOM`] say who may use how much.
pub const OUTGOING: usize = 4 * link::PACKET_MAX;

/// Free space before a report is sent: at most one packet waits before it.
pub const REPORT_ROOM: usize = OUTGOING - link::PACKET_MAX;

/// Free space before answers to packets outside of the session are sent: behind them a report still finds room.
pub const STRANGER_ROOM: usize = REPORT_ROOM + link::channel::ANSWERS_MAX;

/// Free space before an answer to the session's host is sent: refusals and values are shorter. Without it the answer is dropped. A
/// host that asks so often does not read what it is sent, and reading on is more important: its next request may be a stop.
pub const ANSWER_ROOM: usize = 64;

/// Received bytes that are read before reports are sent again: a full buffer.
pub const READ_AT_ONCE: usize = INCOMING;

/// A started board, in the parts that different interrupts own.
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

/// A board under an arm of `N` joints.
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

    /// Set up clocks, link and timers. Brakes are engaged and the control timer is held when this returns.
    fn start(peripherals: Self::Peripherals, rate_hz: f32) -> Parts<Self, N>;

    /// The last thing the program does, from any state: drives off and brakes engaged first, then the log, then
    /// it stops.
    fn halt(write_log: impl FnOnce()) -> !;
}
