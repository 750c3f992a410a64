//! Closed-loop simulation on the desk and against the emulated chip.
//!
//! | room | holds | imports |
//! |---|---|---|
//! | [`plant`] | the simulated arm, its actuators and sensors: f64, an algorithm of its own | none of the others |
//! | [`run`] | the loop once per control period, from a scene to a record, a summary and plots | `plant` |
//! | [`chip`] | the firmware in an emulated STM32F405, driven in lock step | `run`, `session` |
//! | [`session`] | the firmware under its safety state machine, and who talks to it: drill, operator, replay, serial port | `run`, `chip` |
//! | [`study`] | answers that are computed: trade, torque error, extremes, campaign, statics, energy, linkages | all but `cli` |
//! | [`cli`] | one file a command: its arguments, help, call and print | all |
//! | [`failure`] | why a command could not be carried out, and its exit code | - |
#![forbid(unsafe_code)]

pub mod chip;
pub mod cli;
pub mod failure;
pub mod plant;
pub mod run;
pub mod session;
pub mod study;
