//! The host's side of the link: what it sends in a tick, and what becomes of that on the way.

use super::case::FaultKind;
use super::dice::Dice;
use super::machine::Told;
use dynamics_core::Reference;
use link::codec::FrameTooLong;
use link::{Encoder, Frame, Hello, Measurement, Pacing, Packet, Parts, Point, Request, Watch};

/// Ticks between two points of the trajectory.
const STEP: u32 = 10;

/// Ticks that the host is ahead with its points.
const AHEAD: u32 = 30;

/// Ticks after which the host says that it is there, when it has nothing else to say.
const ALIVE: u32 = 20;

/// Longest that the host talks in a tick: three packets fit into what the chip keeps of bytes that it has not read, and a drill's own
/// frames come behind.
const BYTES: usize = 560;

/// What went over the link in a tick, as the judge may know it.
#[derive(Clone, Debug, Default)]
pub(super) struct Sent {
    /// All the bytes.
    pub(super) bytes: Vec<u8>,
    /// What may have been asked for, whatever became of it on the way.
    pub(super) requests: Vec<Request>,
    /// Whether anything was sent that may have been taken for a word of the host.
    pub(super) spoke: bool,
}

/// The host.
pub(super) struct Host<const N: usize> {
    encoder: Encoder,
    pacing: Pacing,
    /// Packets of this tick.
    packets: Vec<Packet>,
    requests: Vec<Request>,
    /// Ticks since it last said anything.
    quiet: u32,
    /// The lines that it played last.
    lines: Option<link::Lines>,
    /// The point that it sent last.
    pub(super) last: Option<Reference<f64, N>>,
    /// Ticks of the trajectory that it has sent.
    sent: u32,
    /// Whether it has not sent a byte yet.
    begins: bool,
}

impl<const N: usize> Host<N> {
    /// A host that begins with its hello.
    pub(super) fn new(hello: Hello) -> Result<Self, FrameTooLong> {
        let mut host = Self {
            encoder: Encoder::new(),
            pacing: hello.pacing,
            packets: Vec::new(),
            requests: Vec::new(),
            quiet: 0,
            lines: None,
            last: None,
            sent: 0,
            begins: true,
        };
        host.send(&Frame::Hello(hello))?;
        if hello.pacing == Pacing::Live {
            host.send(&Frame::Watch(Watch { every: 1, parts: Parts::ALL }))?;
        }
        Ok(host)
    }

    /// Send a frame in this tick, if the host has not said too much already.
    pub(super) fn send(&mut self, frame: &Frame) -> Result<(), FrameTooLong> {
        if self.packets.iter().map(|packet| packet.len()).sum::<usize>() > BYTES {
            return Ok(());
        }
        self.packets.push(self.encoder.encode(frame)?);
        Ok(())
    }

    /// Ask for something.
    pub(super) fn ask(&mut self, request: Request) -> Result<(), FrameTooLong> {
        self.requests.push(request);
        self.send(&Frame::Request(request))
    }

    /// Begin a trajectory.
    pub(super) fn start(&mut self, at: &Reference<f64, N>) -> Result<(), FrameTooLong> {
        self.sent = 0;
        self.point(0, at)
    }

    /// Send a point.
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

    /// End the tick: all that is sent in it, with what the link does to it. A host that is mute sends nothing.
    ///
    /// In a drill the lines, where they changed, and the measurement come last and unharmed: without them there is no tick.
    pub(super) fn finish(
        &mut self,
        told: &Told<N>,
        wire: Option<(FaultKind, &mut Dice)>,
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
        // Whoever spoke before may have stopped in the middle of a packet, which would take the hello with it.
        let mut bytes = if core::mem::take(&mut self.begins) { vec![0] } else { Vec::new() };
        let harmed = wire.is_some();
        match wire {
            None => bytes.extend(self.packets.iter().flatten()),
            Some((kind, dice)) => harm(kind, &self.packets, dice, &mut bytes),
        }
        let spoke = !bytes.is_empty();
        if spoke {
            self.quiet = 0;
        }
        self.packets.clear();
        if self.pacing == Pacing::Drill {
            if harmed {
                // The end of whatever was cut, and a frame that may be refused because others before it were lost.
                bytes.push(0);
                bytes.extend(self.encoder.encode(&Frame::Alive)?);
            }
            let lines = told.lines();
            if told.overrun || self.lines.is_none_or(|last| !same(&last, &lines)) {
                bytes.extend(self.encoder.encode(&Frame::Lines(lines))?);
                // An overrun is said once.
                self.lines = (!told.overrun).then_some(lines);
            }
            let measurement = dynamics_core::Measurement { sensed: told.sensed, age_ticks: told.oldest() };
            bytes.extend(self.encoder.encode(&Frame::Measurement(Measurement::new(told.tick, &measurement)))?);
        }
        Ok(Sent { bytes, requests: core::mem::take(&mut self.requests), spoke: spoke || self.pacing == Pacing::Drill })
    }
}

/// By the bits: NaN is never itself.
fn same(a: &link::Lines, b: &link::Lines) -> bool {
    let bits = |x: Option<f32>| x.map(f32::to_bits);
    let of = |lines: &link::Lines| {
        let link::Lines { emergency_stop, overrun, zeroed, drive_fault, supply, temperature } = *lines;
        (emergency_stop, overrun, zeroed, drive_fault, bits(supply), bits(temperature))
    };
    of(a) == of(b)
}

/// What comes of the packets on a link with this fault.
fn harm(kind: FaultKind, packets: &[Packet], dice: &mut Dice, bytes: &mut Vec<u8>) {
    let mut order: Vec<&Packet> = packets.iter().collect();
    if kind == FaultKind::Swapped && order.len() > 1 {
        let (a, b) = (dice.index(order.len()), dice.index(order.len()));
        order.swap(a, b);
    }
    for packet in order {
        let begin = bytes.len();
        bytes.extend(packet);
        match kind {
            FaultKind::Damaged => {
                for _ in 0..dice.whole(0, 3) {
                    let at = begin + dice.index(packet.len());
                    bytes[at] ^= 1 << dice.whole(0, 7);
                }
            }
            FaultKind::Lost if dice.chance(0.5) => bytes.truncate(begin),
            FaultKind::Doubled if dice.chance(0.5) => bytes.extend(packet),
            FaultKind::Garbage if dice.chance(0.5) => bytes.truncate(begin + dice.index(packet.len())),
            _ => {}
        }
    }
    if kind == FaultKind::Garbage {
        for _ in 0..dice.whole(0, 80) {
            // Zeros end packets: more of them than chance would have.
            bytes.push(if dice.chance(0.1) { 0 } else { dice.bits() as u8 });
        }
    }
}
