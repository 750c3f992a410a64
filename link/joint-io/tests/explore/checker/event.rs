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
    /// The drive has no power for so many periods, and restarts.
    Dark(u8, u8),
    /// The emergency stop is pressed, and cuts the power of all drives, for so many periods.
    Cut(u8),
    /// The emergency stop is pressed for one period, and cuts nothing.
    EmergencyStop,
    /// The period ends after the next one was due.
    Overrun,
    /// The drive switches itself off, and reports no error.
    Trip(u8),
    /// The drive finds an error of its own, which stays until it is cleared.
    DriveError(u8),
    /// An additional request, after the operator's.
    Ask(Request),
    /// The last request once more.
    Repeat,
    /// One of the next batch of frames from the host is lost: this one.
    LoseFrame(u8),
    /// The host is silent for so many periods.
    Away(u8),
    /// The host is silent until it says hello again.
    Gone,
    /// A host says hello.
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

/// Periods of a step after the last event: nothing branches there, so fewer states are looked at.
pub const TAIL: u32 = 8;

/// Periods that a drive is dark: its shortest restart, within which missing replies are tolerated, and more than the check for jumps sees.
pub const DARK: [u8; 2] = [scene::RESTART as u8, 8];
