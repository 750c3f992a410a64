//! Disturbing events, and steps between them.

use super::scene;
use super::world::{CommandFate, ReplyFate};
use link::Request;

/// A disturbing event. It takes no time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The joint's command of this period has this fate.
    Command(u8, CommandFate),
    /// The joint's reply of this period has this fate.
    Reply(u8, ReplyFate),
    /// The board's controller is off the bus for two periods.
    BusOff,
    /// The drive of this joint has no power for this number of periods, and restarts.
    Dark(u8, u8),
    /// The emergency stop is pressed for this number of periods and cuts the power of all drives.
    Cut(u8),
    /// The emergency stop is pressed for one period and does not cut the power.
    EmergencyStop,
    /// The period ends after the next one was due.
    Overrun,
    /// The drive switches itself off, and reports no error.
    Trip(u8),
    /// The drive detects an error, which stays until it is cleared.
    DriveError(u8),
    /// An additional request, after the operator's.
    Ask(Request),
    /// The last request is sent again.
    Repeat,
    /// The frame with this index in the next batch from the host is lost.
    LoseFrame(u8),
    /// The host is silent for this number of periods.
    Away(u8),
    /// The host is silent until it sends another hello.
    Gone,
    /// A host sends a hello.
    Hello,
}

/// The next transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// One control period.
    Tick,
    /// [`TAIL`] control periods after the last event of the path; each of them is judged.
    Tail,
    /// A disturbing event.
    Event(Event),
}

/// Number of periods in one step after the last event. Nothing branches there, so fewer states need to be stored.
pub const TAIL: u32 = 8;

/// Periods for which a drive has no power: its shortest restart, within which missing replies are tolerated, and a longer one that the check for
/// jumps does not cover.
pub const DARK: [u8; 2] = [scene::RESTART as u8, 8];
