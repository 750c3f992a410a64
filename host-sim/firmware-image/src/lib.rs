//! The firmware of a scene and a board: built, flashed, and given its key.
//!
//! | module | holds |
//! |---|---|
//! | [`board`] | the boards and their chips |
//! | [`build`] | the build of a program for a scene and a board |
//! | [`can_buses`] | what a scene's frames take of a board's CAN buses |
//! | [`emitted`] | Rust source of the arm, written before cargo starts |
//! | [`flash`] | programs and keys, written to a board by probe-rs |
//! | [`install`] | the emulator and other packages, installed where they are missing |
//! | [`log_strings`] | whether the log of a program can be decoded |
//! | [`process`] | other programs: found, run, and named if they fail |
//! | [`scene_keys`] | keys of a scene file that are needed before its robot is compiled |
//! | [`toolchain`] | the compiler for the chip |
#![forbid(unsafe_code)]

mod bad_input;
pub mod board;
pub mod build;
pub mod can_buses;
pub mod emitted;
pub mod flash;
pub mod install;
pub mod log_strings;
pub mod process;
pub mod scene_keys;
pub mod toolchain;

pub use bad_input::BadInput;
pub use board::{Board, Chip, Trust};
pub use build::Build;
