//! The frames that host and MCU exchange: `no_std`, no allocation, every error named.
//!
//! A packet on the wire, least significant byte first:
//!
//! ```text
//! open    COBS( version: u8        | sequence: u32 | frame: postcard | CRC-32 of all before: u32 ) 0x00
//! sealed  COBS( version | 80: u8   | sequence: u32 | frame: postcard | seal of all before: u64   ) 0x00
//! ```
//!
//! COBS leaves no zero byte inside a packet, so a receiver that has lost its place finds it again at the next zero. The
//! version stands in every packet, outside the serialised part: a receiver can tell a peer of another version from
//! noise. The sequence number counts packets and shows how many were lost on the way; one that was there before is refused.
//! [docs/link.md](../../docs/link.md) has every byte.
//!
//! | module | holds |
//! |---|---|
//! | [`frame`] | the frames: those of the bench, and those of an arm in operation |
//! | [`packet`] | packets on the wire: their parts and sizes, and why one could not be read |
//! | [`codec`] | packets: encoder and decoder |
//! | [`seal`] | the link key, proofs, seals |
//! | [`channel`] | who may talk: the handshake, from the board's side and from the host's |
//! | [`inlet`] | bytes on their way from the receiver's interrupt to the decoder |
//! | [`circular`] | the same behind hardware that stores them by itself |
//! | [`outgoing`] | bytes on their way to hardware that sends by itself |
//! | [`key_page`] | the key in a board's flash |
//! | [`convert`] | to and from the types of the control loop |
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

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

/// Version of the protocol: of the packet's layout and of every frame. Any change of either counts it up.
pub const PROTOCOL_VERSION: u8 = 7;
