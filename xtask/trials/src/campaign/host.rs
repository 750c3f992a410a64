//! The host's side of the link: its packets in each tick, and the link's faults on them.

use super::fault::FaultKind;
use super::machine::TickInputs;
use super::random::Random;
use dynamics_core::Reference;
use link::codec::FrameTooLong;
use link::seal::SealKey;
use link::{Encoder, Frame, Hello, Measurement, Pacing, Packet, Parts, Point, Request, Watch};

/// Ticks between two points of the trajectory.
const STEP: u32 = 10;

/// Number of ticks by which the host sends its points in advance.
const AHEAD: u32 = 30;

/// Ticks of silence after which the host sends a sign of life.
const ALIVE: u32 = 20;

/// Most bytes that the host sends in a tick. The chip's receive buffer holds three packets of unread bytes, and a
/// dry run's own frames follow.
const BYTES: usize = 560;

/// Traffic of one tick, as far as the judge may know it.
#[derive(Clone, Debug, Default)]
pub(super) struct Sent {
    /// All bytes that were sent.
    pub(super) bytes: Vec<u8>,
    /// Requests that the machine may have received, even if the link damaged them.
    pub(super) requests: Vec<Request>,
    /// True if the machine may have received any message of the host.
    pub(super) spoke: bool,
}

/// The simulated host.
pub(super) struct Host<const N: usize> {
    encoder: Encoder,
    /// Packets of this tick.
    packets: Vec<Packet>,
    requests: Vec<Request>,
    /// Number of the last request.
    number: u8,
    /// Ticks since the host last sent anything.
    quiet: u32,
    /// Lines that it sent last in a dry run.
    lines: Option<link::Lines>,
    /// Point that it sent last.
    pub(super) last: Option<Reference<f64, N>>,
    /// Trajectory ticks sent so far.
    sent: u32,
    /// True if it has not sent anything yet.
    begins: bool,
    /// It says nothing, and does not count what it would have said.
    pub(super) gone: bool,
    /// A request that never reaches the machine, of one that is broken on purpose.
    pub(super) deaf_to: Option<Request>,
}

impl<const N: usize> Host<N> {
    /// Create a host that starts with its hello.
    pub(super) fn new(hello: Hello, seal: Option<SealKey>) -> Result<Self, FrameTooLong> {
        let mut encoder = Encoder::new();
        if let Some(key) = seal {
            encoder.seal_with(key);
        }
        let mut host = Self {
            encoder,
            packets: Vec::new(),
            requests: Vec::new(),
            number: 0,
            quiet: 0,
            lines: None,
            last: None,
            sent: 0,
            begins: true,
            gone: false,
            deaf_to: None,
        };
        host.send(&Frame::Hello(hello))?;
        if hello.pacing == Pacing::Live {
            host.send(&Frame::Watch(Watch { every: 1, parts: Parts::ALL }))?;
        }
        Ok(host)
    }

    /// Send a frame in this tick, unless the tick's bytes are used up.
    pub(super) fn send(&mut self, frame: &Frame) -> Result<(), FrameTooLong> {
        if self.gone || self.packets.iter().map(|packet| packet.len()).sum::<usize>() > BYTES {
            return Ok(());
        }
        self.packets.push(self.encoder.encode(frame)?);
        Ok(())
    }

    /// Send a request.
    pub(super) fn ask(&mut self, request: Request) -> Result<(), FrameTooLong> {
        if self.gone {
            return Ok(());
        }
        self.requests.push(request);
        self.number = self.number.wrapping_add(1);
        if self.deaf_to == Some(request) {
            return Ok(());
        }
        self.send(&Frame::request(self.number, request))
    }

    /// Begin a trajectory.
    pub(super) fn start(&mut self, at: &Reference<f64, N>) -> Result<(), FrameTooLong> {
        self.sent = 0;
        self.point(0, at)
    }

    /// Send a trajectory point.
    pub(super) fn point(&mut self, ticks: u16, at: &Reference<f64, N>) -> Result<(), FrameTooLong> {
        self.last = Some(*at);
        self.send(&Frame::Point(Point { ticks, reference: link::Reference::new(&at.cast::<f32>()) }))
    }

    /// Send the points of a motion that are due in its tick number `now`.
    pub(super) fn feed(&mut self, now: u32, motion: impl Fn(u32) -> Reference<f64, N>) -> Result<(), FrameTooLong> {
        while self.sent < now + AHEAD {
            self.sent += STEP;
            self.point(STEP as u16, &motion(self.sent))?;
        }
        Ok(())
    }

    /// End the tick: returns its bytes after the link's faults. A mute host sends nothing.
    ///
    /// In a dry run, of which it is given the readings, the lines (if they changed) and the measurement come last and undamaged, because without them there
    /// is no tick.
    pub(super) fn finish(
        &mut self,
        dry_run: Option<&TickInputs<N>>,
        wire: Option<(FaultKind, &mut Random)>,
        mute: bool,
    ) -> Result<Sent, FrameTooLong> {
        self.quiet += 1;
        if self.packets.is_empty() && self.quiet >= ALIVE {
            self.send(&Frame::Alive)?;
        }
        if mute {
            self.packets.clear();
            self.requests.clear();
        }
        // An earlier host may have stopped in the middle of a packet. The zero ends that packet, so that the hello is
        // not lost with it.
        let mut bytes = if core::mem::take(&mut self.begins) { vec![0] } else { Vec::new() };
        let harmed = wire.is_some();
        match wire {
            None => bytes.extend(self.packets.iter().flatten()),
            Some((kind, random)) => harm(kind, &self.packets, random, &mut bytes),
        }
        let spoke = !bytes.is_empty();
        if spoke {
            self.quiet = 0;
        }
        self.packets.clear();
        if let Some(told) = dry_run {
            if harmed {
                // A zero ends a truncated packet. The frame after it may be refused if frames before it were lost.
                bytes.push(0);
                bytes.extend(self.encoder.encode(&Frame::Alive)?);
            }
            let lines = told.lines();
            if told.overrun || self.lines.is_none_or(|last| !same(&last, &lines)) {
                bytes.extend(self.encoder.encode(&Frame::Lines(lines))?);
                // An overrun is reported once.
                self.lines = (!told.overrun).then_some(lines);
            }
            let measurement = dynamics_core::Measurement { sensed: told.sensed, age_ticks: told.oldest() };
            bytes.extend(self.encoder.encode(&Frame::Measurement(Measurement::new(told.tick, &measurement)))?);
        }
        Ok(Sent { bytes, requests: core::mem::take(&mut self.requests), spoke: spoke || dry_run.is_some() })
    }
}

/// Compare bit by bit, because NaN differs from itself.
fn same(a: &link::Lines, b: &link::Lines) -> bool {
    let bits = |x: Option<f32>| x.map(f32::to_bits);
    let of = |lines: &link::Lines| {
        let link::Lines { emergency_stop, overrun, zeroed, drive_fault, on, zero_lost, supply, temperature } = *lines;
        (emergency_stop, overrun, zeroed, drive_fault, on, zero_lost, bits(supply), bits(temperature))
    };
    of(a) == of(b)
}

/// Append the packets to `bytes` after this fault of the link.
fn harm(kind: FaultKind, packets: &[Packet], random: &mut Random, bytes: &mut Vec<u8>) {
    let mut order: Vec<&Packet> = packets.iter().collect();
    if kind == FaultKind::Swapped && order.len() > 1 {
        let (a, b) = (random.index(order.len()), random.index(order.len()));
        order.swap(a, b);
    }
    for packet in order {
        let begin = bytes.len();
        bytes.extend(packet);
        match kind {
            FaultKind::Damaged => {
                for _ in 0..random.whole(0, 3) {
                    let at = begin + random.index(packet.len());
                    bytes[at] ^= 1 << random.whole(0, 7);
                }
            }
            FaultKind::Lost if random.chance(0.5) => bytes.truncate(begin),
            FaultKind::Doubled if random.chance(0.5) => bytes.extend(packet),
            FaultKind::Garbage if random.chance(0.5) => bytes.truncate(begin + random.index(packet.len())),
            _ => {}
        }
    }
    if kind == FaultKind::Garbage {
        for _ in 0..random.whole(0, 80) {
            // Zeros end packets, so they are more frequent here than by chance.
            bytes.push(if random.chance(0.1) { 0 } else { random.bits() as u8 });
        }
    }
}
