//! Frames made from any bytes, and an independent receiver to compare with the link's. It is slower, and shares only
//! the layout of the frames with it.

use link::{DecodeError, Decoder, Frame, PACKET_MAX, PROTOCOL_VERSION, Received};

/// Longest payload of an unsealed packet: of [`PACKET_MAX`], COBS uses two bytes, version and sequence number five, and the check sum four.
pub(crate) const PAYLOAD_MAX: usize = PACKET_MAX - 11;

/// Large enough for any frame in a packet.
const FRAME_MAX: usize = PACKET_MAX;

/// Takes a frame from the front of the bytes. Missing bytes count as zeros; invalid fields are replaced by zeros.
pub(crate) fn frame(bytes: &mut &[u8]) -> Frame {
    let tag = bytes.split_off_first().copied().unwrap_or_default() % Frame::KINDS;
    let mut fields = [0; FRAME_MAX];
    fields[0] = tag;
    let known = bytes.len().min(FRAME_MAX - 1);
    fields[1..=known].copy_from_slice(&bytes[..known]);
    if let Ok((frame, rest)) = postcard::take_from_bytes::<Frame>(&fields) {
        *bytes = &bytes[known.min(FRAME_MAX - 1 - rest.len())..];
        return frame;
    }
    // A test of the link ensures that zeros are a valid frame of any kind.
    fields[1..].fill(0);
    postcard::from_bytes(&fields).unwrap()
}

/// All contents of a frame as bytes: `==` on floats would not distinguish one NaN from another, and rejects every NaN.
pub(crate) fn all_bits(frame: &Frame) -> Vec<u8> {
    postcard::to_slice(frame, &mut [0; FRAME_MAX]).unwrap().to_vec()
}

/// Results of the link's decoder for some bytes.
pub(crate) fn decode(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Result<Received, DecodeError>> {
    bytes.iter().filter_map(|&byte| decoder.push(byte)).collect()
}

/// A received frame: its bytes, and the number of missing packets before it.
#[derive(Debug, PartialEq)]
pub(crate) struct Taken {
    pub(crate) bits: Vec<u8>,
    pub(crate) missed: u32,
}

/// The good packets among the decoder's results.
pub(crate) fn taken(results: &[Result<Received, DecodeError>]) -> Vec<Taken> {
    let good = results.iter().flatten();
    good.map(|Received { frame, missed }| Taken { bits: all_bits(frame), missed: *missed }).collect()
}

/// The good packets of a stream, read with the whole stream in memory.
pub(crate) fn expected(stream: &[u8]) -> Vec<Taken> {
    let mut next: Option<u32> = None;
    let mut all = Vec::new();
    // Bytes after the last zero belong to an unfinished packet.
    let ended = stream.iter().rposition(|&byte| byte == 0).map_or(0, |at| at + 1);
    for (frame, sequence) in stream[..ended].split(|&byte| byte == 0).filter_map(packet) {
        let afresh = begins(&frame);
        let missed = next.filter(|_| !afresh).map_or(0, |next| sequence.wrapping_sub(next));
        // A sequence number that is half the range or more ahead is an old one, and is rejected.
        if missed <= i32::MAX as u32 {
            next = Some(sequence.wrapping_add(1));
            all.push(Taken { bits: all_bits(&frame), missed });
        }
    }
    all
}

/// True if a frame restarts the packet count: it begins a session, or belongs to the handshake before one.
pub(crate) fn begins(frame: &Frame) -> bool {
    matches!(frame, Frame::Hello(_) | Frame::Join(_) | Frame::Proof(_) | Frame::Challenge(_))
}

/// Frame and sequence number of a packet without its final zero; `None` if the packet is invalid.
fn packet(bytes: &[u8]) -> Option<(Frame, u32)> {
    let raw = (bytes.len() <= PACKET_MAX).then(|| without_cobs(bytes))??;
    let (body, check) = raw.split_last_chunk::<4>()?;
    let [PROTOCOL_VERSION, a, b, c, d, payload @ ..] = body else { return None };
    let sequence = u32::from_le_bytes([*a, *b, *c, *d]);
    if check_sum(body) != *check || payload.first().is_none_or(|&tag| tag >= Frame::KINDS) {
        return None;
    }
    let (frame, rest) = postcard::take_from_bytes(payload).ok()?;
    rest.is_empty().then_some((frame, sequence))
}

/// Decodes consistent overhead byte stuffing. Every block begins with its length, which includes that byte, and decodes to its bytes and a zero. The
/// last block and blocks of length 255 decode to their bytes alone.
fn without_cobs(mut bytes: &[u8]) -> Option<Vec<u8>> {
    let mut raw = Vec::new();
    while let Some((&length, rest)) = bytes.split_first() {
        let (block, rest) = rest.split_at_checked(usize::from(length).checked_sub(1)?)?;
        raw.extend_from_slice(block);
        if length < u8::MAX && !rest.is_empty() {
            raw.push(0);
        }
        bytes = rest;
    }
    Some(raw)
}

/// CRC-32 of ISO HDLC, bit by bit.
fn check_sum(bytes: &[u8]) -> [u8; 4] {
    let step = |sum: u32| if sum & 1 == 1 { (sum >> 1) ^ 0xedb8_8320 } else { sum >> 1 };
    let byte = |sum: u32, &byte: &u8| (0..8).fold(sum ^ u32::from(byte), |sum, _| step(sum));
    (!bytes.iter().fold(!0, byte)).to_le_bytes()
}

/// A packet with any payload, a valid check sum and its final zero.
pub(crate) fn whole(sequence: u8, payload: &[u8]) -> Vec<u8> {
    let mut raw = vec![PROTOCOL_VERSION, sequence, 0, 0, 0];
    raw.extend_from_slice(payload);
    raw.extend_from_slice(&check_sum(&raw));
    let mut packet = cobs::encode_vec(&raw);
    packet.push(0);
    packet
}
