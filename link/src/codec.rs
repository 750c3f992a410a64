//! Packets: framing, check sum, sequence numbers.

use crate::PROTOCOL_VERSION;
use crate::frame::Frame;
use core::fmt;
use crc::{CRC_32_ISO_HDLC, Crc, Table};
use serde::{Deserialize, Serialize};

/// Version, sequence number, and the check sum behind.
const HEADER: usize = 2;
const CHECK: usize = 4;

/// Longest packet before COBS: a status of six joints with all its parts has 234 bytes at most; the rest is room to grow.
const RAW_MAX: usize = 250;

/// Longest packet on the wire: COBS adds one byte up to 254, and the zero ends it.
pub const PACKET_MAX: usize = RAW_MAX + 2;

/// A packet ready for the wire, its final zero included.
pub type Packet = heapless::Vec<u8, PACKET_MAX>;

/// CRC-32: finds every error of up to 3 bits, and every burst of up to 32, in a packet of this length. (Koopman, *32-bit
/// cyclic redundancy codes for Internet applications*, DSN 2002: Hamming distance 4 up to 91607 bits.)
const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// A frame that does not fit a packet; no frame of up to [`crate::JOINTS_MAX`] joints is that long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameTooLong;

impl fmt::Display for FrameTooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the frame does not fit a packet of {PACKET_MAX} bytes")
    }
}

impl core::error::Error for FrameTooLong {}

/// Makes packets, counting them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Encoder {
    sequence: u8,
}

impl Encoder {
    /// An encoder whose first packet is number 0.
    #[must_use]
    pub const fn new() -> Self {
        Self { sequence: 0 }
    }

    /// The next packet.
    ///
    /// # Errors
    /// [`FrameTooLong`], which no frame of this crate can cause; a test holds every kind to that.
    pub fn encode(&mut self, frame: &Frame) -> Result<Packet, FrameTooLong> {
        let mut raw = [0_u8; RAW_MAX];
        raw[0] = PROTOCOL_VERSION;
        raw[1] = self.sequence;
        let payload = postcard::to_slice(frame, &mut raw[HEADER..RAW_MAX - CHECK]).map_err(|_| FrameTooLong)?.len();
        let end = HEADER + payload;
        let check = CRC.checksum(&raw[..end]).to_le_bytes();
        raw[end..end + CHECK].copy_from_slice(&check);

        let mut packet = Packet::new();
        packet.resize(PACKET_MAX, 0).map_err(|_| FrameTooLong)?;
        let length = cobs::try_encode(&raw[..end + CHECK], &mut packet).map_err(|_| FrameTooLong)?;
        packet.truncate(length + 1);
        self.sequence = self.sequence.wrapping_add(1);
        Ok(packet)
    }
}

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
        }
    }
}

impl core::error::Error for DecodeError {}

/// A frame, and how many packets are missing before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Received {
    /// The frame.
    pub frame: Frame,
    /// Packets lost between the last good one and this, modulo 256. A hello starts the count afresh. From [`STALE`] on
    /// the packet counts as a repeated or late one (256 less this many ago), and the expected number stays the same.
    pub missed: u8,
}

/// Half of the sequence numbers lie ahead, half behind.
pub const STALE: u8 = 128;

/// Finds packets in a stream of bytes. After any error it is ready for the next packet.
#[derive(Clone, Debug)]
pub struct Decoder {
    bytes: heapless::Vec<u8, PACKET_MAX>,
    overlong: bool,
    expected: Option<u8>,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// A decoder at the start of a stream.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: heapless::Vec::new(), overlong: false, expected: None }
    }

    /// Take one byte; a zero ends a packet and gives its frame. Zeros without anything between them give nothing.
    ///
    /// # Errors
    /// [`DecodeError`] names the fault of the packet that ended. Never panics, for any bytes.
    pub fn push(&mut self, byte: u8) -> Option<Result<Received, DecodeError>> {
        if byte != 0 {
            self.overlong |= self.bytes.push(byte).is_err();
            return None;
        }
        let overlong = core::mem::take(&mut self.overlong);
        if overlong {
            self.bytes.clear();
            return Some(Err(DecodeError::TooLong));
        }
        if self.bytes.is_empty() {
            return None;
        }
        let result = read(&mut self.bytes);
        self.bytes.clear();
        Some(result.map(|(frame, sequence)| self.received(frame, sequence)))
    }

    fn received(&mut self, frame: Frame, sequence: u8) -> Received {
        let expected = match frame {
            Frame::Hello(_) => sequence,
            _ => self.expected.unwrap_or(sequence),
        };
        let missed = sequence.wrapping_sub(expected);
        // A repeated or late packet does not move the expected number: otherwise all packets after a replayed one would
        // be accepted.
        self.expected = Some(if missed < STALE { sequence.wrapping_add(1) } else { expected });
        Received { frame, missed }
    }
}

/// Undo COBS in place, check, and read the frame.
fn read(bytes: &mut [u8]) -> Result<(Frame, u8), DecodeError> {
    let length = cobs::decode_in_place(bytes).map_err(|_| DecodeError::BadCobs)?;
    let raw = bytes.get(..length).ok_or(DecodeError::BadCobs)?;
    let (body, check) = raw.split_last_chunk::<CHECK>().ok_or(DecodeError::TooShort)?;
    let (&[version, sequence], payload) = body.split_first_chunk::<HEADER>().ok_or(DecodeError::TooShort)?;
    if CRC.checksum(body) != u32::from_le_bytes(*check) {
        return Err(DecodeError::BadCrc);
    }
    if version != PROTOCOL_VERSION {
        return Err(DecodeError::WrongVersion { theirs: version });
    }
    match payload.first() {
        None => return Err(DecodeError::TooShort),
        Some(&tag) if tag >= Frame::KINDS => return Err(DecodeError::UnknownFrame { tag }),
        Some(_) => {}
    }
    match postcard::take_from_bytes::<Frame>(payload) {
        Ok((frame, [])) => Ok((frame, sequence)),
        Ok(_) | Err(_) => Err(DecodeError::Malformed),
    }
}
