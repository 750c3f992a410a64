//! Models of actuators and sensors: commands, replies and failures.
//!
//! | module | holds |
//! |---|---|
//! | [`mit`] | an MIT-mode actuator: its electronics (with quantisation, limits and internal state), and a free shaft |
//! | [`bus`] | a CAN bus with such actuators, on which frames can be lost, delayed or doubled |
//! | [`wire`] | CAN frames bit by bit, including stuffing |
//! | [`encoder`] | an AS5047P: words with parity, replies one word later, a magnet that can be too far away |
//!
//! The tests of `joint-io` connect free shafts to the electronics; the simulated arm connects its joints.
//!
//! The models were written from the documents of the devices, in double precision and without code of the firmware. So a mistake in a frame's
//! layout shows up as a disagreement instead of cancelling.
#![forbid(unsafe_code)]

pub mod bus;
pub mod encoder;
pub mod frame;
pub mod mit;
pub mod wire;
