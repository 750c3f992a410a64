//! The session: turns received frames into ticks, and ticks into frames to send. It connects the link with the controller and the safety state
//! machine, and needs no hardware. Board and desk share this code: the firmware runs it on the microcontroller; dry runs, replays and campaigns
//! run it on the desk and give the same bits.
//!
//! | module | holds |
//! |---|---|
//! | the root | [`Session`]: received frames in, ticks and answers out, in a bench mode or under supervision |
//! | [`supervisor`] | the safety state machine around the controller, and its inputs |
//! | [`trajectory`] | the reference motion, buffered ahead of time |
//! | [`black_box`] | inputs and outputs of the last ticks |
//! | [`readings`] | measurements, lines and faults from a board |
//! | [`parameters`] | parameters that can be read at run time, and those that can be changed |
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
//! A hello restarts everything: the controller is reset; reference, trajectory and measurement are deleted; every live input is zero; ticks are
//! counted from 1; and the safety state machine is idle and not homed. There is one exception, for a live session with a driven arm: a hello
//! equal to the one that began the session continues it. The arm is not affected, and only the state of the previous host is deleted. Any other
//! hello is refused then.
//!
//! In a bench mode the controller runs without the safety state machine and no drive is driven; its faults stay until the next hello. Under
//! supervision, [`supervisor::Supervisor`] decides in every tick on the action of the drives.
//!
//! Live inputs and parameters arrive between ticks and are valid from the next tick on. While torque acts, they are valid one tick later: the
//! next tick computes its torque twice, with the old and the new values. It refuses the change if the torque of a joint would change by more
//! than its limit for one tick ([`JUMP`] times the torque limit if no rate is given). Live inputs are answered only if they are refused.
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

/// The core, in the version that this package's types are made of.
pub use dynamics_core;

pub use session::{Buffers, Drives, JUMP, Message, Outcome, Reaction, Session, State};
