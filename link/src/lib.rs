//! The frames that host and MCU exchange: `no_std`, no allocation, every error named.
//!
//! A packet on the wire, least significant byte first:
//!
//! ```text
//! open    COBS( version: u8        | sequence: u32 | frame: postcard | CRC-32 of all before: u32 ) 0x00
//! sealed  COBS( version | 80: u8   | sequence: u32 | frame: postcard | seal of all before: u64   ) 0x00
//! ```
//!
//! COBS leaves no zero byte inside a packet, so a receiver that has lost its position in the stream resumes at the next zero. Every
//! packet carries the version, outside the serialised part: a receiver can tell a peer of another version from noise. The sequence
//! number counts packets and shows how many were lost; a packet whose number has been used before is refused.
//! [docs/link.md](../../docs/link.md) describes every byte.
//!
//! | module | holds |
//! |---|---|
//! | [`frame`] | the frames of the bench modes and of an arm in operation |
//! | [`packet`] | packets on the wire: their parts and sizes, and why one could not be read |
//! | [`codec`] | packets: encoder and decoder |
//! | [`seal`] | the link key, proofs, seals |
//! | [`channel`] | authentication: the handshake, from the board's side and from the host's |
//! | [`inlet`] | queue of bytes from the receiver's interrupt to the decoder |
//! | [`circular`] | reader of a circular buffer that hardware (DMA) fills |
//! | [`outgoing`] | queue of bytes to hardware (DMA) that sends pieces of memory |
//! | [`key_page`] | the key in a board's flash |
//! | [`convert`] | to and from the types of the control loop |
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

/// Runs the examples of the README as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub mod channel;
pub mod circular;
pub mod codec;
pub mod convert;
pub mod frame;
pub mod inlet;
pub mod key_page;
pub mod outgoing;
pub mod packet;
pub mod seal;
pub mod state;

/// The core, in the version that this package's types are made of.
pub use dynamics_core;

pub use channel::{Access, BoardChannel, Distrust, HostChannel};
pub use circular::{Circular, Filling, Halves};
pub use codec::{Decoder, Encoder, Received};
pub use convert::{AsymmetricInertia, JointCountMismatch};
pub use frame::{
    Actuation, Answer, Challenge, Command, Cost, Denial, DriveFaultReport, ExtraFields, Fault, Frame, Hello,
    JOINTS_MAX, Joints, Lines, Live, Measurement, NonceSource, NumberedRequest, Pacing, Parts, Payload, Point,
    Reference, Refusal, Request, Sensed, SensedLines, Setting, Status, TickCost, Trust, Value, Verdict, Watch,
};
pub use inlet::{Arrival, Inlet};
pub use outgoing::{Outgoing, Sending};
pub use packet::{DecodeError, PACKET_MAX, Packet};
pub use seal::{Key, Nonce, Proof};
pub use state::StateCode;

/// Version of the protocol. It covers the packet's layout and every frame; any change of either increments it.
pub const PROTOCOL_VERSION: u8 = 7;
