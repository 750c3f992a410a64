//! The parts of the firmware that depend on no chip: they run on the microcontroller and are tested on the host.
//!
//! | module | holds |
//! |---|---|
//! | [`board`] | the interface of a board; the boards themselves are part of the program |
//! | [`code_check`] | comparison of the tick's code in RAM with its original in flash |
//! | [`memory_protection`] | regions of the memory protection unit that make this code read-only |
//! | [`serve`] | the task between link and session |
//! | [`joint_io`] | drivers of the joints: CAN actuators, PWM drives with magnetic encoders; a separate package |
//!
//! The program connects them with [`session`]. The desk runs [`joint_io`] and [`session`] too.
//!
//! On the microcontroller the work has three priorities. The highest is the link's receiver, for single bytes or for bytes that a DMA has stored.
//! The second is the control tick, in a timer's interrupt. At the lowest, frames are read, answered and sent.
#![no_std]

pub mod board;
pub mod code_check;
pub mod memory_protection;
pub mod serve;
pub use joint_io;
