//! Tests of the fault-injection campaign on the desk.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

mod desk;
mod drives;
mod judge;
