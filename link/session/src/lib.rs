//! From frames to ticks to frames, without hardware: the shared code of board and desk between the link, the
//! controller, and the safety state machine around it. The firmware runs it on the microcontroller; a dry run, a replay
//! and a campaign run it on the desk, to the same bits.
//!
//! | module | holds |
//! |---|---|
//! | the root | [`Session`]: received frames in, ticks and answers out, on the bench or under supervision |
//! | [`supervisor`] | the safety state machine around the controller, its inputs, and the trajectory |
//! | [`trajectory`] | the reference motion, buffered ahead of time |
//! | [`black_box`] | inputs and outputs of the last ticks |
//! | [`readings`] | measurements, lines and faults from a board |
//! | [`parameters`] | parameters that can be read back at run time, and those that can be changed |
//! | [`meter`] | cost of a tick, counted exactly or not at all |
//!
//! ```text
//!            hello agrees, on the bench    measurement (lock step) or timer
//! waiting ----------------------------> bench ------------------------------> command or fault
//!    ^  \                                 |
//!    |   \   hello agrees, supervised     |  hello (any state)
//!    |    `----------------------> supervised ------------------------------> status
//!    +------------------------------------+
//!       hello for another robot
//! ```
//!
//! A hello starts afresh: the controller is reset, reference, trajectory and measurement are forgotten, every
//! live input is zero, ticks are counted from 1, and the safety state machine idles, not homed. There is one exception. While
//! the arm of a live session is driven, the hello that the session has begun with continues it: the arm stays as it is, and only the
//! host is forgotten. Any other hello is refused then.
//!
//! On the bench the controller stands alone and no drive is driven; its faults stay until the next hello. Supervised,
//! [`supervisor::Supervisor`] decides in every tick on the action of the drives.
//!
//! Live inputs and parameters come between ticks and hold from the next one on. Where torque acts they hold from the
//! one after: the next tick computes its torque twice, with the old and with the new, and refuses the change where a
//! joint's torque would change by more than it may in a tick ([`JUMP`] of its limit where no rate is given). Live
//! inputs are answered only when they are refused.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod black_box;
pub mod meter;
pub mod parameters;
pub mod readings;
mod session;
pub mod supervisor;
pub mod trajectory;

pub use session::{Buffers, Drives, JUMP, Message, Outcome, Reaction, Session, State};
