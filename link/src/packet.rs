//! Packets on the wire: their parts and sizes, and decoding errors.

use crate::PROTOCOL_VERSION;
use core::fmt;
use serde::{Deserialize, Serialize};

/// Length of version and sequence number, bytes.
pub(crate) const HEADER: usize = 5;

/// Length of the check sum at the end of an open packet, bytes.
pub(crate) const CHECK: usize = 4;

/// Bit of the version byte that marks a sealed packet.
pub(crate) const SEALED: u8 = 0x80;

/// Longest packet before COBS, bytes. A sealed status of six joints with all its parts has at most 241; the rest is reserve.
pub(crate) const RAW_MAX: usize = 250;

/// Longest packet on the wire, bytes: COBS adds one byte to a packet of up to 254, and a zero ends it.
pub const PACKET_MAX: usize = RAW_MAX + 2;

/// A packet ready for the wire, its final zero included.
pub type Packet = heapless::Vec<u8, PACKET_MAX>;

/// Reason why a packet could not be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DecodeError {
    /// More bytes than the longest packet arrived without a zero.
    TooLong,
    /// Too few bytes for header and check sum: a fragment.
    TooShort,
    /// The bytes are not COBS.
    BadCobs,
    /// The check sum does not fit the bytes.
    BadCrc,
    /// The peer speaks another version of the protocol.
    WrongVersion {
        /// The version in the packet.
        theirs: u8,
    },
    /// No frame has this tag.
    UnknownFrame {
        /// The tag in the packet.
        tag: u8,
    },
    /// The frame's contents do not match its tag, or bytes are left over.
    Malformed,
    /// The seal does not fit: a packet of another session, of the other direction, without the key, or damaged.
    BadSeal,
    /// The packet repeats an earlier one, or arrived late.
    Repeated,
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong => write!(f, "packet longer than {PACKET_MAX} bytes"),
            Self::TooShort => write!(f, "packet too short for its header and check sum"),
            Self::BadCobs => write!(f, "packet is not valid COBS"),
            Self::BadCrc => write!(f, "bad CRC: the packet was damaged on the way"),
            Self::WrongVersion { theirs } => {
                write!(
                    f,
                    "protocol version {theirs}, expected {PROTOCOL_VERSION}: build host and firmware from one source"
                )
            }
            Self::UnknownFrame { tag } => write!(f, "unknown frame, tag {tag}"),
            Self::Malformed => write!(f, "the frame's contents do not follow its kind"),
            Self::BadSeal => write!(f, "bad seal: the packet is not of this session, or was damaged on the way"),
            Self::Repeated => write!(f, "the packet is an earlier one again, or came late"),
        }
    }
}

impl core::error::Error for DecodeError {}
