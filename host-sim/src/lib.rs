//! Closed-loop simulation on the desk and against the emulated chip.
//!
//! Each room may name itself and those above it; `tests/desk/rooms.rs` holds that.
//!
//! | room | holds |
//! |---|---|
//! | [`plant`] | the simulated arm, its actuators and sensors: f64, an algorithm of its own |
//! | [`run`] | the loop once per control period, from a scene to a record, a summary and plots |
//! | [`chip`] | the firmware in an emulated STM32F405, driven in lock step |
//! | [`session`] | the firmware under its safety state machine, and who talks to it: drill, operator, replay, serial port |
//! | [`study`] | answers that are computed: trade, torque error, extremes, campaign, statics, energy, linkages |
//! | [`cli`] | one file a command: its arguments, help, call and print |
//!
//! [`failure`], why a command could not be carried out, and tables are for all of them.
#![forbid(unsafe_code)]

pub mod chip;
pub mod cli;
pub mod failure;
pub mod plant;
pub mod run;
pub mod session;
pub mod study;
mod table;
