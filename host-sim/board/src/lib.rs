//! Boards and their operator: the emulated chip, the serial port, the firmware's session on the desk and at CAN adapters. Without the feature
//! `session` there are [`chip`] and [`key`] alone.
//!
//! | module | holds |
//! |---|---|
//! | [`can`] | CAN adapters of a computer |
//! | [`chip`] | the firmware in an emulated STM32F405, driven in lock step |
//! | [`session`] | the firmware under its safety state machine, and its hosts: dry run, operator, replay, serial port |
//! | [`key`] | keys of the link |
//! | [`real_time`] | priority, locked memory and waiting of a control thread |
#![forbid(unsafe_code)]

#[cfg(feature = "session")]
pub mod can;
pub mod chip;
pub mod key;
#[cfg(feature = "session")]
pub mod real_time;
#[cfg(feature = "session")]
pub mod session;
