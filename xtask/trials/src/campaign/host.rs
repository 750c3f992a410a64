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

/// Ticks by which the host sends its points in advance.
const AHEAD: u32 = 30;

/// Ticks of silence after which the host sends an `Alive` frame.
const ALIVE: u32 = 20;

/// Most bytes that the host sends in a tick. The chip's receive buffer holds three unread packets, and a dry run's own frames follow.
const BYTES: usize = 560;

/// Traffic of one tick, as far as the judge may use it.
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
    /// Lines sent last, in a dry run.
    lines: Option<link::Lines>,
    /// Point sent last.
    pub(super) last: Option<Reference<f64, N>>,
    /// Trajectory ticks sent so far.
    sent: u32,
    /// True if it has not sent anything yet.
    begins: bool,
    /// True if the host sends nothing and does not count what it would have sent.
    pub(super) gone: bool,
    /// A request that never reaches the machine, for a deliberate fault.
    pub(super) deaf_to: Option<Request>,
}

impl<const N: usize> Host<N> {
    /// Creates a host that starts with its hello.
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

    /// Sends a frame in this tick, unless the tick's bytes are used up.
    pub(super) fn send(&mut self, frame: &Frame) -> Result<(), FrameTooLong> {
        if self.gone || self.packets.iter().map(|packet| packet.len()).sum::<usize>() > BYTES {
            return Ok(());
        }
        self.packets.push(self.encoder.encode(frame)?);
        Ok(())
    }

    /// Sends a request.
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

    /// Begins a trajectory.
    pub(super) fn start(&mut self, at: &Reference<f64, N>) -> Result<(), FrameTooLong> {
        self.sent = 0;
        self.point(0, at)
    }

    /// Sends a trajectory point.
    pub(super) fn point(&mut self, ticks: u16, at: &Reference<f64, N>) -> Result<(), FrameTooLong> {
        self.last = Some(*at);
        self.send(&Frame::Point(Point { ticks, reference: link::Reference::new(&at.cast::<f32>()) }))
    }

    /// Sends the points of a motion that are due in its tick number `now`.
    pub(super) fn feed(&mut self, now: u32, motion: impl Fn(u32) -> Reference<f64, N>) -> Result<(), FrameTooLong> {
        while self.sent < now + AHEAD {
            self.sent += STEP;
            self.point(STEP as u16, &motion(self.sent))?;
        }
        Ok(())
    }

    /// Ends the tick: returns its bytes, after the link's faults. A mute host sends nothing.
    ///
    /// In a dry run, `dry_run` contains the readings. The lines (if they changed) and the measurement come last and undamaged, because there is no
    /// tick without them.
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
        // An earlier host may have stopped in the middle of a packet. The zero ends that packet, so that the hello is not lost with it.
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
                // A zero ends a truncated packet. The following frame may be rejected if frames before it were lost.
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

/// Compares bit by bit, because NaN differs from itself.
fn same(a: &link::Lines, b: &link::Lines) -> bool {
    let bits = |x: Option<f32>| x.map(f32::to_bits);
    let of = |lines: &link::Lines| {
        let link::Lines { emergency_stop, overrun, zeroed, drive_fault, on, zero_lost, supply, temperature } = *lines;
        (emergency_stop, overrun, zeroed, drive_fault, on, zero_lost, bits(supply), bits(temperature))
    };
    of(a) == of(b)
}

/// Appends the packets to `bytes`, with this fault of the link.
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
            // A zero ends a packet, so zeros are more frequent here than by chance.
            bytes.push(if random.chance(0.1) { 0 } else { random.bits() as u8 });
        }
    }
}
