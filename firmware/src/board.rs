//! Interface of a board. One file per board implements this; nothing else names the chip's registers.

use crate::joint_io::JointIo;
use link::{Nonce, NonceSource};
use session::meter::Counter;
use session::readings::Lines;

/// Receiving half of the link.
pub trait LinkInput {
    /// The byte that has arrived, if one has. Called in the receive interrupt, which it also acknowledges.
    fn read(&mut self) -> Option<u8>;
}

/// Sending half of the link.
pub trait LinkOutput {
    /// Send all bytes. Blocks; called below the priority of the tick.
    fn write(&mut self, bytes: &[u8]);
}

/// The timer whose interrupt owns the control tick.
pub trait Ticker {
    /// Let the timer run at the control rate.
    fn run(&mut self);

    /// Hold the timer: ticks come from [`Ticker::trigger`] alone.
    fn hold(&mut self);

    /// Acknowledge the interrupt that started this tick.
    fn acknowledge(&mut self);

    /// Whether the next tick became due since [`Ticker::acknowledge`].
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

/// A started board, in the parts that different interrupts own.
pub struct Parts<B: Board<N> + ?Sized, const N: usize> {
    /// Receiving half of the link.
    pub input: B::Input,
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
    /// Receiving half of the link.
    type Input: LinkInput;
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

    /// The last thing the program does, from any state: drives off and brakes engaged first, then its last words, then
    /// it stops.
    fn halt(last_words: impl FnOnce()) -> !;
}
