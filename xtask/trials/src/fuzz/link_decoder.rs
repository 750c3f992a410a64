//! Fuzz target: any bytes into the link's decoder, as they are, and as the contents of a packet with a valid check sum.

use crate::fuzz::FuzzTarget;
use crate::fuzz::packets::{PAYLOAD_MAX, all_bits, decode, expected, frame, taken, whole};
use link::{DecodeError, Decoder, Encoder, Frame, Hello, PACKET_MAX, Pacing, Received};

/// Payloads of every kind of frame, packets of them, and a long sequence of bytes without an end.
pub const TARGET: FuzzTarget =
    FuzzTarget { name: "link_decoder", check, examples, words: include_str!("../../words/link.dict") };

fn examples() -> Vec<Vec<u8>> {
    let mut all = vec![vec![0x55; 1000]];
    for tag in 0..Frame::KINDS {
        for fill in [0, 1] {
            let mut fields = [fill; PACKET_MAX];
            fields[0] = tag;
            let payload = all_bits(&frame(&mut &fields[..]));
            all.push(whole(tag, &payload));
            all.push(payload);
        }
    }
    all
}

/// The decoder accepts the same frames as an independent reader. Every frame survives being encoded and decoded again, and the next packet is read
/// after any bytes.
pub fn check(bytes: &[u8]) {
    let mut decoder = Decoder::new();
    let results = decode(&mut decoder, bytes);
    assert_eq!(taken(&results), expected(bytes));
    results.iter().flatten().for_each(check_comes_back);
    decode(&mut decoder, &[0]);
    check_next_is_read(&mut decoder, &frame(&mut &bytes[..]));

    let payload = &bytes[..bytes.len().min(PAYLOAD_MAX)];
    let packet = whole(bytes.last().copied().unwrap_or_default(), payload);
    // Use a new decoder, because one that has read packets may reject the number as an earlier one.
    let mut decoder = Decoder::new();
    let results = decode(&mut decoder, &packet);
    match &results[..] {
        [Ok(received)] => check_comes_back(received),
        [Err(DecodeError::UnknownFrame { tag })] => assert!(*tag >= Frame::KINDS && payload[0] == *tag),
        [Err(DecodeError::TooShort)] => assert!(payload.is_empty()),
        [Err(DecodeError::Malformed)] => {}
        other => panic!("a whole packet was read as {other:?}"),
    }
    check_next_is_read(&mut decoder, &frame(&mut &bytes[..]));
}

fn check_comes_back(received: &Received) {
    check_is_read(&mut Decoder::new(), &received.frame);
}

/// Checks that the next packet is read after any bytes, once a hello has restarted the count.
fn check_next_is_read(decoder: &mut Decoder, frame: &Frame) {
    let hello = Frame::Hello(Hello { robot: 0, joints: 0, rate_hz: 0.0, pacing: Pacing::DryRun });
    let mut encoder = Encoder::new();
    check_reads(decoder, &mut encoder, &hello);
    check_reads(decoder, &mut encoder, frame);
}

fn check_is_read(decoder: &mut Decoder, frame: &Frame) {
    check_reads(decoder, &mut Encoder::new(), frame);
}

fn check_reads(decoder: &mut Decoder, encoder: &mut Encoder, frame: &Frame) {
    let packet = encoder.encode(frame).unwrap();
    let read = taken(&decode(decoder, &packet));
    assert!(matches!(&read[..], [one] if one.bits == all_bits(frame)), "{frame:?} was read as {read:?}");
}
