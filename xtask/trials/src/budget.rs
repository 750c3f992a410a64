//! Costs of a firmware at run time. On the emulated chip, the flashed firmware is measured unchanged, from outside. On a
//! board at a serial port, the cycles of its ticks are measured.
//!
//! | module | holds |
//! |---|---|
//! | [`random_motion`] | random motions that the controller follows without a fault or an active limit |
//! | [`ticks`] | the chip in lock step: instructions of each tick, and the depth of the stack by painting |
//! | [`supervised`] | the chip under its safety state machine, along a trajectory |
//! | [`traced`] | from the emulator's trace: the tick's interrupt, its estimated cycles and masked time, the cost of a link byte |
//! | [`ways`] | the link's interrupts byte by byte and by DMA |
//! | [`flood`] | lateness of a tick while the timer paces and the link is never idle |
//! | [`board`] | a board on a serial port, in lock step: cycles of each tick from its own counter |
//! | [`interrupts`] | exception numbers, and the core's interrupt masks |
//! | [`stack_paint`] | RAM filled before the program starts, and read back |
//! | [`report`] | the measured values, as one JSON object |

pub mod board;
mod failure;
pub mod flood;
pub mod interrupts;
mod program;
pub mod random_motion;
pub mod report;
pub mod stack_paint;
pub mod supervised;
pub mod ticks;
pub mod traced;
pub mod ways;

pub use failure::{BadCounter, Failure};
