//! Packets: framing, check sum or seal, sequence numbers.

use crate::PROTOCOL_VERSION;
use crate::frame::Frame;
use crate::packet::{CHECK, DecodeError, HEADER, PACKET_MAX, Packet, RAW_MAX, SEALED};
use crate::seal::{SEAL, SealKey, SessionKeys};
use core::fmt;
use crc::{CRC_32_ISO_HDLC, Crc, Table};

/// CRC-32: finds every error of up to 3 bits, and every burst of up to 32, in a packet of this length. (Koopman, *32-bit
/// cyclic redundancy codes for Internet applications*, DSN 2002: Hamming distance 4 up to 91607 bits.)
pub(crate) const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// A frame that does not fit a packet; no frame of up to [`crate::JOINTS_MAX`] joints is that long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameTooLong;

impl fmt::Display for FrameTooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the frame does not fit a packet of {PACKET_MAX} bytes")
    }
}

impl core::error::Error for FrameTooLong {}

/// Encodes frames into packets and numbers them.
#[derive(Clone, Debug, Default)]
pub struct Encoder {
    /// Number of the next open packet.
    open: u32,
    /// Number of the next sealed packet.
    sealed: u64,
    seal: Option<SealKey>,
}

impl Encoder {
    /// Creates an encoder of open packets, which starts at number 0.
    #[must_use]
    pub const fn new() -> Self {
        Self { open: 0, sealed: 0, seal: None }
    }

    /// Makes [`Encoder::encode`] seal all packets from now on, beginning with number 0.
    pub fn seal_with(&mut self, key: SealKey) {
        (self.sealed, self.seal) = (0, Some(key));
    }

    /// Encodes the next packet: sealed if there is a key, otherwise open.
    ///
    /// # Errors
    /// [`FrameTooLong`]; no frame of this crate causes it, which a test checks for every kind.
    pub fn encode(&mut self, frame: &Frame) -> Result<Packet, FrameTooLong> {
        let mut packet = Packet::new();
        self.encode_to(frame, &mut packet)?;
        Ok(packet)
    }

    /// Encodes the next open packet, even if there is a key. For a peer that does not have the key.
    ///
    /// # Errors
    /// As [`Encoder::encode`].
    pub fn encode_open(&mut self, frame: &Frame) -> Result<Packet, FrameTooLong> {
        let mut packet = Packet::new();
        self.encode_open_to(frame, &mut packet)?;
        Ok(packet)
    }

    /// As [`Encoder::encode`], into an existing packet.
    pub(crate) fn encode_to(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), FrameTooLong> {
        let Some(key) = &self.seal else { return self.encode_open_to(frame, packet) };
        pack(frame, self.sealed, Some(key), packet)?;
        self.sealed += 1;
        Ok(())
    }

    /// As [`Encoder::encode_open`], into an existing packet.
    pub(crate) fn encode_open_to(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), FrameTooLong> {
        pack(frame, u64::from(self.open), None, packet)?;
        self.open = self.open.wrapping_add(1);
        Ok(())
    }
}

/// Encodes one packet. Not inlined, so that the program has one copy.
#[inline(never)]
fn pack(frame: &Frame, number: u64, seal: Option<&SealKey>, packet: &mut Packet) -> Result<(), FrameTooLong> {
    let mut raw = [0_u8; RAW_MAX];
    raw[0] = if seal.is_some() { PROTOCOL_VERSION | SEALED } else { PROTOCOL_VERSION };
    // The wire carries the low half of the number; the seal covers all of it.
    raw[1..HEADER].copy_from_slice(&(number as u32).to_le_bytes());
    let frame = postcard::to_slice(frame, &mut raw[HEADER..RAW_MAX - SEAL]).map_err(|_| FrameTooLong)?.len();
    let end = HEADER + frame;
    let end = match seal {
        Some(key) => {
            let seal = key.seal(number, &raw[..end]);
            raw[end..end + SEAL].copy_from_slice(&seal);
            end + SEAL
        }
        None => {
            let check = CRC.checksum(&raw[..end]).to_le_bytes();
            raw[end..end + CHECK].copy_from_slice(&check);
            end + CHECK
        }
    };
    packet.resize(PACKET_MAX, 0).map_err(|_| FrameTooLong)?;
    let length = cobs::try_encode(&raw[..end], packet).map_err(|_| FrameTooLong)?;
    packet.truncate(length);
    packet.push(0).map_err(|_| FrameTooLong)
}

/// A received frame, and the number of packets missing before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Received {
    /// The frame.
    pub frame: Frame,
    /// Packets lost between the last good one and this one. An open frame that begins a session or a handshake restarts the count.
    pub missed: u32,
}

/// Half of the range of sequence numbers. A number less than this ahead of the expected one is new; any other is [`DecodeError::Repeated`].
const AHEAD: u32 = 1 << 31;

/// Finds packets in a stream of bytes. After any error it is ready for the next packet.
#[derive(Clone, Debug)]
pub struct Decoder {
    bytes: heapless::Vec<u8, PACKET_MAX>,
    overlong: bool,
    /// Expected number of the next packet, open or sealed; `None` before the first open one.
    expected: Option<u64>,
    seal: Option<SealKey>,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// Creates a decoder of open packets, at the start of a stream.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: heapless::Vec::new(), overlong: false, expected: None, seal: None }
    }

    /// Makes the decoder accept packets sealed with this key from now on, beginning with number 0.
    pub fn seal_with(&mut self, key: SealKey) {
        (self.expected, self.seal) = (Some(0), Some(key));
    }

    /// Takes one byte. A zero ends a packet; its frame is returned, open or sealed. Consecutive zeros return nothing.
    ///
    /// # Errors
    /// [`DecodeError`] names what is wrong with the packet that ended. Never panics, for any bytes.
    pub fn push(&mut self, byte: u8) -> Option<Result<Received, DecodeError>> {
        self.push_known(byte).map(|result| result.map(|(received, _)| received))
    }

    /// As [`Decoder::push`], with `true` if the packet was sealed.
    pub(crate) fn push_known(&mut self, byte: u8) -> Option<Result<(Received, bool), DecodeError>> {
        self.collect(byte).then(|| self.finish())
    }

    /// Stores one byte. Returns true if it ends a packet, which [`Decoder::finish`] then reads.
    #[inline]
    pub(crate) fn collect(&mut self, byte: u8) -> bool {
        if byte == 0 {
            return self.overlong || !self.bytes.is_empty();
        }
        self.overlong |= self.bytes.push(byte).is_err();
        false
    }

    /// Reads the packet that has ended.
    pub(crate) fn finish(&mut self) -> Result<(Received, bool), DecodeError> {
        let overlong = core::mem::take(&mut self.overlong);
        let result = if overlong { Err(DecodeError::TooLong) } else { self.read() };
        self.bytes.clear();
        result
    }

    /// Decodes COBS in place, checks check sum or seal, and reads the frame.
    fn read(&mut self) -> Result<(Received, bool), DecodeError> {
        let length = cobs::decode_in_place(&mut self.bytes).map_err(|_| DecodeError::BadCobs)?;
        let raw = self.bytes.get(..length).ok_or(DecodeError::BadCobs)?;
        if raw.first().is_some_and(|version| version & SEALED != 0) {
            let (body, seal) = raw.split_last_chunk::<SEAL>().ok_or(DecodeError::TooShort)?;
            let (sequence, payload) = header(body, SEALED)?;
            let key = self.seal.as_ref().ok_or(DecodeError::BadSeal)?;
            let (number, missed) = place(sequence, self.expected.unwrap_or(0)).ok_or(DecodeError::Repeated)?;
            if !key.fits(number, body, seal) {
                return Err(DecodeError::BadSeal);
            }
            let frame = contents(payload)?;
            self.expected = Some(number + 1);
            return Ok((Received { frame, missed }, true));
        }
        let (body, check) = raw.split_last_chunk::<CHECK>().ok_or(DecodeError::TooShort)?;
        if CRC.checksum(body) != u32::from_le_bytes(*check) {
            return Err(DecodeError::BadCrc);
        }
        let (sequence, payload) = header(body, 0)?;
        let frame = contents(payload)?;
        // In a sealed session open packets do not advance the sequence number.
        if self.seal.is_some() {
            return Ok((Received { frame, missed: 0 }, false));
        }
        let expected = self.expected.filter(|_| !frame.begins()).unwrap_or(u64::from(sequence));
        let (number, missed) = place(sequence, expected).ok_or(DecodeError::Repeated)?;
        self.expected = Some(number + 1);
        Ok((Received { frame, missed }, false))
    }
}

/// Full number of a packet, from the low half that it carries, and the number of packets missing before it; `None` for an earlier packet.
fn place(sequence: u32, expected: u64) -> Option<(u64, u32)> {
    let missed = sequence.wrapping_sub(expected as u32);
    (missed < AHEAD).then(|| (expected + u64::from(missed), missed))
}

/// Sequence number and frame of a packet from which check sum or seal has been removed.
fn header(body: &[u8], mark: u8) -> Result<(u32, &[u8]), DecodeError> {
    let (&[version, ref sequence @ ..], payload) = body.split_first_chunk::<HEADER>().ok_or(DecodeError::TooShort)?;
    if version != PROTOCOL_VERSION | mark {
        return Err(DecodeError::WrongVersion { theirs: version & !SEALED });
    }
    Ok((u32::from_le_bytes(*sequence), payload))
}

#[inline(never)]
fn contents(payload: &[u8]) -> Result<Frame, DecodeError> {
    match payload.first() {
        None => return Err(DecodeError::TooShort),
        Some(&tag) if tag >= Frame::KINDS => return Err(DecodeError::UnknownFrame { tag }),
        Some(_) => {}
    }
    match postcard::take_from_bytes::<Frame>(payload) {
        Ok((frame, [])) => Ok(frame),
        Ok(_) | Err(_) => Err(DecodeError::Malformed),
    }
}

/// Encoder and decoder of one side.
#[derive(Clone, Debug, Default)]
pub(crate) struct Codec {
    pub(crate) encoder: Encoder,
    pub(crate) decoder: Decoder,
}

impl Codec {
    pub(crate) const fn new() -> Self {
        Self { encoder: Encoder::new(), decoder: Decoder::new() }
    }

    /// Begins a sealed session.
    pub(crate) fn seal_with(&mut self, keys: SessionKeys) {
        self.encoder.seal_with(keys.sending);
        self.decoder.seal_with(keys.receiving);
    }
}
