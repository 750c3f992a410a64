//! The firmware's parts without a chip in them: tested on the host, run on the microcontroller.
//!
//! | module | holds |
//! |---|---|
//! | [`board`] | the interface of a board; the boards themselves belong to the program |
//! | [`serve`] | the task between link and session |
//! | [`joint_io`] | ways of reaching the joints: CAN actuators, PWM drives with magnetic encoders; a package of its own |
//!
//! The program joins them with [`session`]. The desk runs both too.
//!
//! On the microcontroller three priorities share the work: the link's receiver interrupts everything, for a byte or for what a DMA has
//! stored; the control tick is owned by a timer interrupt; and frames are read, answered and sent below both.
#![no_std]

pub mod board;
pub mod serve;
pub use joint_io;
