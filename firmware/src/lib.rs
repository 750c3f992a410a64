//! What the firmware does, without hardware in it: tested on the host, run on the microcontroller.
//!
//! | module | holds |
//! |---|---|
//! | [`session`] | received frames in, ticks and answers out: on the bench, or under supervision |
//! | [`supervisor`] | the safety state machine around the controller, all that it is told, and the trajectory |
//! | [`trajectory`] | where the arm should be, ahead of time |
//! | [`black_box`] | what the last ticks were told and did |
//! | [`board`] | what a board must do; the boards themselves belong to the program |
//! | [`joint_io`] | ways of reaching the joints: CAN actuators, PWM drives with magnetic encoders |
//! | [`parameters`] | what can be read back at run time, and what of it can be changed |
//! | [`meter`] | what a tick costs, counted exactly or not at all |
//!
//! On the microcontroller three priorities share the work: bytes from the link come in above everything, the control
//! tick is owned by a timer interrupt, and frames are read, answered and sent below both.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod black_box;
pub mod board;
pub mod joint_io;
pub mod meter;
pub mod parameters;
pub mod session;
pub mod supervisor;
pub mod trajectory;
