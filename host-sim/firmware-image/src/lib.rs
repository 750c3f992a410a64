//! The firmware of a scene and a board: its build, flashing, and key.
//!
//! | module | holds |
//! |---|---|
//! | [`board`] | the boards and their chips |
//! | [`build`] | the build of a program for a scene and a board |
//! | [`can_buses`] | load of a scene's frames on a board's CAN buses |
//! | [`child_process`] | child processes that end with the program, however it ends |
//! | [`emitted`] | Rust source of the arm, written before cargo starts |
//! | [`flash`] | writing programs and keys to a board with probe-rs |
//! | [`install`] | installation of the emulator and other missing packages |
//! | [`log_strings`] | check that the log of a program can be decoded |
//! | [`process`] | finding and running other programs, with errors that name them |
//! | [`scratch`] | files that live as long as the program |
//! | [`toolchain`] | the compiler for the chip |
#![forbid(unsafe_code)]

mod bad_input;
pub mod board;
pub mod build;
pub mod can_buses;
pub mod child_process;
pub mod emitted;
pub mod flash;
pub mod install;
pub mod log_strings;
pub mod process;
pub mod scratch;
pub mod toolchain;

pub use bad_input::BadInput;
pub use board::{Board, Chip, Trust};
pub use build::Build;
