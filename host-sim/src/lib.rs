//! Closed-loop simulation on the desk and against the emulated chip.
//!
//! Modules are called rooms here. A room may use itself and the rooms above it in the table; `tests/desk/rooms.rs`
//! checks that.
//!
//! | room | holds |
//! |---|---|
//! | [`plant`] | the simulated arm, its actuators and sensors: f64, with its own algorithm |
//! | [`run`] | the loop once per control period, from a scene to a record, a summary and plots |
//! | [`chip`] | the firmware in an emulated STM32F405, driven in lock step |
//! | [`session`] | the firmware under its safety state machine, and its hosts: drill, operator, replay, serial port |
//! | [`study`] | computed answers: trade, torque error, extremes, campaign, very many runs, statics, energy, linkages |
//! | [`cli`] | one file per command: its arguments, help, call and print |
//!
//! All rooms use [`failure`], the reasons why a command fails, [`output`], the files that commands write, [`key`], the link's keys, and the tables.
#![forbid(unsafe_code)]

pub mod chip;
pub mod cli;
pub mod failure;
pub mod key;
mod marker;
pub mod output;
pub mod plant;
pub mod run;
pub mod session;
pub mod study;
mod table;
