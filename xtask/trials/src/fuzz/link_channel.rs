//! Fuzz target: a sealed session with an intruder on its wire.

use crate::fuzz::FuzzTarget;
use crate::fuzz::packets::{all_bits, frame};
use link::{Access, BoardChannel, Encoder, Frame, Hello, HostChannel, Key, NonceSource, Pacing};

/// Sessions in which each kind of event happens once, and sessions with many events.
pub const TARGET: FuzzTarget = FuzzTarget { name: "link_channel", check, examples, words: "" };

const KEY: [u8; 32] = [0x4e; 32];
const OWN: Hello = Hello { robot: 1, joints: 2, rate_hz: 1000.0, pacing: Pacing::LockStep };

/// Most packets in one session.
const PACKETS_MAX: usize = 300;

const KINDS: u8 = 9;

fn examples() -> Vec<Vec<u8>> {
    let mut all: Vec<Vec<u8>> = (0..KINDS).map(|event| vec![0, 10, event, 3, 40, 7, 0, 7, 5, 0, 10]).collect();
    all.push((0..=u8::MAX).collect());
    all.push((0..=u8::MAX).rev().collect());
    all
}

/// A board with a key, its host, and all traffic on the wire.
struct HostAndBoard {
    board: BoardChannel,
    host: HostChannel,
    nonces: u8,
    /// All packets of the host: bytes, frame, and true once the board has accepted it.
    sent: Vec<(Vec<u8>, Vec<u8>, bool)>,
    /// Packets of earlier sessions.
    past: Vec<Vec<u8>>,
    /// Index of the last packet that the board has accepted.
    last: Option<usize>,
    said: Vec<u8>,
}

impl HostAndBoard {
    fn new() -> Self {
        let mut wire = Self {
            board: BoardChannel::new(Access::Key(&KEY)),
            host: HostChannel::new(Some(Key::new(KEY))),
            nonces: 0,
            sent: Vec::new(),
            past: Vec::new(),
            last: None,
            said: Vec::new(),
        };
        wire.join();
        wire
    }

    /// Begins a new session, in which earlier packets are no longer accepted.
    fn join(&mut self) {
        self.host = HostChannel::new(Some(Key::new(KEY)));
        let packet = self.host.join([self.nonces; 16]).unwrap();
        self.said.clear();
        // End any unfinished packet.
        assert!(self.give(&[0]).is_empty());
        self.said.clear();
        assert!(self.give(&packet).is_empty());
        let said = core::mem::take(&mut self.said);
        let heard = said.iter().filter_map(|&byte| self.host.push(byte)).find_map(|result| match result {
            Ok(received) => {
                if let Frame::Challenge(challenge) = received.frame {
                    Some(challenge)
                } else {
                    None
                }
            }
            Err(_) => None,
        });
        let proof = self.host.answer(&heard.unwrap()).unwrap().unwrap();
        assert!(self.give(&proof).is_empty());
        self.past.extend(self.sent.drain(..).map(|(packet, ..)| packet));
        self.last = None;
    }

    /// Passes bytes to the board; returns the frames that it accepts.
    fn give(&mut self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut counted = Vec::new();
        for &byte in bytes {
            let mut nonce = || {
                self.nonces = self.nonces.wrapping_add(1);
                Some(([self.nonces; 16], NonceSource::Counter))
            };
            let received = self.board.push(byte, &OWN, &mut nonce, &mut |said| self.said.extend_from_slice(said));
            counted.extend(received.and_then(Result::ok).map(|received| all_bits(&received.frame)));
        }
        counted
    }

    /// Passes an intruder's bytes to the board. Each accepted frame must be the host's own, sent whole, accepted once, and in order.
    fn stranger(&mut self, bytes: &[u8]) {
        for counted in self.give(bytes) {
            let from = self.last.map_or(0, |last| last + 1);
            let at = (from..self.sent.len()).find(|&at| self.sent[at].1 == counted);
            let at = at.unwrap_or_else(|| panic!("the board counts a frame that nobody sent: {counted:?}"));
            assert!(!core::mem::replace(&mut self.sent[at].2, true), "twice");
            self.last = Some(at);
        }
    }

    fn pack(&mut self, frame: &Frame) -> Vec<u8> {
        let packet = self.host.encode(frame).unwrap().to_vec();
        self.sent.push((packet.clone(), all_bits(frame), false));
        packet
    }
}

/// For anything that an intruder sends between the host's packets: no frame is accepted that the host has not sent, none twice, and none out of
/// order. The host's next whole packet is accepted.
pub fn check(mut bytes: &[u8]) {
    let mut wire = HostAndBoard::new();
    let mut open = Encoder::new();
    for count in 0..PACKETS_MAX {
        let Some(&kind) = bytes.split_off_first() else { break };
        let mut number = || usize::from(bytes.split_off_first().copied().unwrap_or_default());
        let (first, second) = (number(), number());
        match kind % KINDS {
            // A packet that does not arrive, and may be replayed later.
            0 => {
                wire.pack(&frame(&mut bytes));
            }
            1 => {
                let all = wire.past.iter().chain(wire.sent.iter().map(|(packet, ..)| packet));
                let packet = all.rev().nth((first + 256 * second) % 512).cloned();
                wire.stranger(&packet.unwrap_or_default());
            }
            2 => {
                let mut packet = wire.pack(&frame(&mut bytes));
                let bit = (first + 256 * second) % (8 * (packet.len() - 1));
                packet[bit / 8] ^= 1 << (bit % 8);
                wire.stranger(&packet);
            }
            3 => {
                let packet = wire.pack(&frame(&mut bytes));
                wire.stranger(&packet[..first % packet.len()]);
                wire.stranger(&[0]);
            }
            4 => {
                let noise = bytes.split_off(..first.min(bytes.len())).unwrap_or_default();
                wire.stranger(noise);
            }
            // A packet from the board itself, sent back to it.
            5 => {
                let mut packet = Vec::new();
                wire.board.send(&frame(&mut bytes), &mut |bytes| packet.extend_from_slice(bytes));
                wire.stranger(&packet);
            }
            6 => {
                let packet = open.encode(&frame(&mut bytes)).unwrap();
                wire.stranger(&packet);
            }
            7 => wire.join(),
            _ => {
                let said = core::mem::take(&mut wire.said);
                wire.stranger(&said);
            }
        }
        // The host continues after a zero, which ends any unfinished packet.
        wire.stranger(&[0]);
        let sensed = link::Sensed::Counts(link::Joints::new());
        let measurement = link::Measurement { tick: u32::MAX - count as u32, age_ticks: 0, sensed };
        let packet = wire.pack(&Frame::Measurement(measurement));
        wire.stranger(&packet);
        assert_eq!(wire.last, Some(wire.sent.len() - 1), "a packet of the host did not count");
    }
}
