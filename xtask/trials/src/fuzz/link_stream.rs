//! Fuzz target: a stream of good packets, with events on the link.

use crate::fuzz::FuzzTarget;
use crate::fuzz::packets::{Taken, all_bits, begins, decode, expected, frame, taken};
use link::{Decoder, Encoder, Frame, Packet};

/// Streams in which each event happens once, and streams with many events.
pub const TARGET: FuzzTarget = FuzzTarget { name: "link_stream", check, examples, words: "" };

fn examples() -> Vec<Vec<u8>> {
    let mut all: Vec<Vec<u8>> = (0..Event::KINDS).map(|event| vec![0, event, 3, 40, 7, 0, 0, 0]).collect();
    all.push((0..=u8::MAX).collect());
    all.push([Event::KINDS, 255, 0].repeat(3));
    all
}

/// Most packets in one stream.
const PACKETS_MAX: usize = 700;

/// An event that happens to the next packet.
enum Event {
    Arrives,
    /// This many packets are lost.
    Lost(u8),
    Doubled,
    /// The packet arrives after the one that follows it.
    Overtaken,
    /// The packet is cut to this many bytes, modulo its length, so the final zero is always lost.
    Cut(usize),
    /// This bit is flipped.
    Flipped(usize),
    /// This many bytes of noise come before the packet.
    Noise(usize),
}

impl Event {
    const KINDS: u8 = 7;

    fn next(bytes: &mut &[u8]) -> Option<Self> {
        let kind = bytes.split_off_first()?;
        let mut number = || bytes.split_off_first().copied().unwrap_or_default();
        Some(match kind % Self::KINDS {
            0 => Self::Arrives,
            1 => Self::Lost(number()),
            2 => Self::Doubled,
            3 => Self::Overtaken,
            4 => Self::Cut(usize::from(number())),
            5 => Self::Flipped(usize::from(u16::from_le_bytes([number(), number()]))),
            _ => Self::Noise(usize::from(number())),
        })
    }
}

/// Bytes on the link, and the packets that must arrive.
#[derive(Default)]
struct ByteStream {
    bytes: Vec<u8>,
    /// Whole packets that begin at the start or after a zero, and must therefore be read.
    whole: Vec<Vec<u8>>,
    /// Sequence number of each whole packet, while packets have only been lost.
    numbers: Vec<usize>,
    only_loss: bool,
    /// Number of the last packet that must be read; the same or an earlier number is rejected.
    last: Option<usize>,
}

impl ByteStream {
    fn put(&mut self, number: usize, packet: &Packet, frame: &Frame) {
        let new = begins(frame) || self.last.is_none_or(|last| number > last);
        if new && self.bytes.last().is_none_or(|&byte| byte == 0) {
            self.whole.push(all_bits(frame));
            self.numbers.push(number);
            self.last = Some(number);
        }
        self.bytes.extend_from_slice(packet);
    }
}

/// The decoder accepts the same frames as an independent reader. Exactly the whole packets arrive, in the order of the
/// link. If packets were only lost, the number of missing ones is right.
pub fn check(mut bytes: &[u8]) {
    let mut encoder = Encoder::new();
    let mut wire = ByteStream { only_loss: true, ..ByteStream::default() };
    let mut late: Option<(usize, Packet, Frame)> = None;
    let mut number = 0;
    while number < PACKETS_MAX
        && let Some(event) = Event::next(&mut bytes)
    {
        wire.only_loss &= matches!(event, Event::Arrives | Event::Lost(_));
        let noise = if let Event::Noise(length) = event { length.min(bytes.len()) } else { 0 };
        wire.bytes.extend_from_slice(bytes.split_off(..noise).unwrap_or_default());
        let frame = frame(&mut bytes);
        let packet = encoder.encode(&frame).unwrap();
        match event {
            Event::Arrives | Event::Noise(_) => wire.put(number, &packet, &frame),
            Event::Doubled => (0..2).for_each(|_| wire.put(number, &packet, &frame)),
            Event::Lost(more) => {
                for _ in 0..more {
                    encoder.encode(&frame).unwrap();
                }
                number += usize::from(more);
            }
            Event::Cut(length) => wire.bytes.extend_from_slice(&packet[..length % packet.len()]),
            Event::Flipped(bit) => {
                let start = wire.bytes.len();
                wire.bytes.extend_from_slice(&packet);
                wire.bytes[start + bit / 8 % packet.len()] ^= 1 << (bit % 8);
            }
            Event::Overtaken if late.is_none() => {
                late = Some((number, packet, frame));
                number += 1;
                continue;
            }
            Event::Overtaken => wire.put(number, &packet, &frame),
        }
        if let Some((number, packet, frame)) = late.take() {
            wire.put(number, &packet, &frame);
        }
        number += 1;
    }

    let read = taken(&decode(&mut Decoder::new(), &wire.bytes));
    // Noise or a cut packet may contain a good packet by chance; the independent reader detects that with its own check sum.
    assert_eq!(read, expected(&wire.bytes));
    let mut rest = read.iter();
    for whole in &wire.whole {
        assert!(rest.any(|taken| taken.bits == *whole), "a whole packet did not arrive");
    }
    if wire.only_loss {
        check_only_loss(&read, &wire);
    }
}

fn check_only_loss(read: &[Taken], wire: &ByteStream) {
    assert_eq!(read.iter().map(|taken| &taken.bits).collect::<Vec<_>>(), wire.whole.iter().collect::<Vec<_>>());
    for (pair, taken) in wire.numbers.windows(2).zip(read.iter().skip(1)) {
        // A hello (tag 0) and a handshake (tags 15 to 17) restart the count.
        let lost = if matches!(taken.bits[0], 0 | 15..=17) { 0 } else { pair[1] - pair[0] - 1 };
        assert_eq!(taken.missed as usize, lost);
    }
}
