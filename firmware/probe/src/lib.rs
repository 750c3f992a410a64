//! Programs for the emulated chip: three count the instructions of calls, one checks functions of the firmware.
//!
//! | program, and its feature | counts, or checks |
//! |---|---|
//! | `probe-copy`, `copy` | the firmware's own `memcpy`, `memmove` and zeroing, for a test |
//! | `probe-kernels`, `kernels` | kernels and the recursion, for `cargo xtask bench` and `cargo xtask cycles` |
//! | `probe-cost`, `cost` | the control tick of a scene, for `cargo xtask firmware cost` |
//! | `probe-micro`, `micro` | instructions of one class each, for `cargo xtask cycles`; on a board, cycles |
//!
//! With `-icount shift=0` an instruction takes 1 ns of QEMU's time, and TIM2 without prescaler counts them (as in
//! `firmware/src/boards/netduinoplus2.rs`).
//!
//! The desk's measurements (the workspace `bench`) time the same functions, so they use these modules too:
//!
//! | module | holds |
//! |---|---|
//! | [`states`] | random states, the same in every run, on every machine and in both precisions |
//! | [`hand`] | gravity torques written by hand, to compare with |
#![no_std]

#[cfg(all(target_os = "none", feature = "counter"))]
mod counter;
pub mod hand;
pub mod states;

#[cfg(all(target_os = "none", feature = "counter"))]
pub use counter::{Counter, give_up, run};
