//! What the firmware does, without hardware in it: tested on the host, run on the microcontroller.
//!
//! | module | holds |
//! |---|---|
//! | [`session`] | hello, running, fault: received frames in, ticks and answers out |
//! | [`board`] | what a board must do; the boards themselves belong to the program |
//! | [`joint_io`] | ways of reaching the joints: CAN actuators, PWM drives with magnetic encoders |
//! | [`meter`] | what a tick costs, counted exactly or not at all |
//!
//! On the microcontroller three priorities share the work: bytes from the link come in above everything, the control
//! tick is owned by a timer interrupt, and frames are read, answered and sent below both.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod board;
pub mod joint_io;
pub mod meter;
pub mod session;
