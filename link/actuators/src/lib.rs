//! Actuators and sensors at a controller's wires: their commands, their replies, and their failures.
//!
//! | module | holds |
//! |---|---|
//! | [`mit`] | an actuator that takes MIT-mode frames: its electronics (quantised, limited, with a state of its own), and a free shaft |
//! | [`bus`] | a CAN bus with such actuators, on which replies get lost, late, doubled |
//! | [`wire`] | CAN frames bit by bit, stuffing included |
//! | [`encoder`] | an AS5047P: words with parity, replies one word later, a magnet that can go away |
//!
//! The joint tests put free shafts behind the electronics, the simulated arm its joints.
//!
//! Written from the documents of the devices, in double precision, and without code of the firmware: a mistake in a
//! frame's layout shows as a disagreement instead of cancelling.
#![forbid(unsafe_code)]

pub mod bus;
pub mod encoder;
pub mod frame;
pub mod mit;
pub mod wire;
