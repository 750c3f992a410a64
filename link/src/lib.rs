//! The frames that host and MCU exchange: `no_std`, no allocation, every error named.
//!
//! A packet on the wire, least significant byte first:
//!
//! ```text
//! COBS( version: u8 | sequence: u8 | frame: postcard | CRC-32 of all before: u32 ) 0x00
//! ```
//!
//! COBS leaves no zero byte inside a packet, so a receiver that has lost its place finds it again at the next zero. The
//! version stands in every packet, outside the serialised part: a receiver can tell a peer of another version from
//! noise. The sequence number counts packets, wraps at 256, and shows how many were lost on the way.
//!
//! | module | holds |
//! |---|---|
//! | [`frame`] | the frames: those of the bench, and those of an arm in operation |
//! | [`codec`] | packets on the wire: encoder, decoder, their errors |
//! | [`convert`] | to and from the types of the control loop |
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod codec;
pub mod convert;
pub mod frame;

pub use codec::{DecodeError, Decoder, Encoder, PACKET_MAX, Packet, Received};
pub use convert::{AsymmetricInertia, JointCountMismatch};
pub use frame::{
    Actuation, Command, Cost, Denial, Fault, Frame, Hello, JOINTS_MAX, Joints, Lines, Live, Measurement, Pacing, Parts,
    Payload, Point, Reference, Refusal, Request, Sensed, SensedLines, Setting, Status, TickCost, Value, Watch,
};

/// Version of the protocol: of the packet's layout and of every frame. Any change of either counts it up.
pub const PROTOCOL_VERSION: u8 = 3;
