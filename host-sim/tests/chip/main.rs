//! Tests of the real firmware in the emulated chip. They run one emulator at a time, because it keeps one processor busy and the test keeps another.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

mod closed_loop;
mod copy;
mod cost;
mod dry_run;
mod faults;
#[cfg(unix)]
mod flash;
mod float_mode;
mod golden;
mod interrupt;
mod live;
mod memory;
mod operate;
mod overrun;
mod parity;
mod pinned;
#[path = "../program/mod.rs"]
mod program;
mod states;
