//! Packets on the wire: their parts and sizes, and why one could not be read.

use crate::PROTOCOL_VERSION;
use crate::seal::SEAL;
use core::fmt;
use serde::{Deserialize, Serialize};

/// Version and sequence number.
pub(crate) const HEADER: usize = 5;

/// The check sum behind an open packet.
pub(crate) const CHECK: usize = 4;

/// Bit of the version byte that marks a sealed packet.
pub(crate) const SEALED: u8 = 0x80;

/// Longest packet before COBS: a sealed status of six joints with all its parts has 241 bytes at most; the rest is room to grow.
pub(crate) const RAW_MAX: usize = 250;

/// Longest packet on the wire: COBS adds one byte up to 254, and the zero ends it.
pub const PACKET_MAX: usize = RAW_MAX + 2;

/// Longest frame in a packet, bytes.
pub const FRAME_MAX: usize = RAW_MAX - HEADER - SEAL;

/// A packet ready for the wire, its final zero included.
pub type Packet = heapless::Vec<u8, PACKET_MAX>;

/// Why a packet could not be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DecodeError {
    /// More bytes than the longest packet before a zero came.
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
    /// The frame's contents do not follow its kind, or bytes are left over.
    Malformed,
    /// The seal does not fit: a packet of another session, of the other direction, without the key, or damaged.
    BadSeal,
    /// The packet is an earlier one again, or came late.
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
