//! Tests of the task between link and session with a model of a board's hardware: a wire of 1 Mbaud in each direction, a DMA that stores received
//! bytes and one that sends, a control timer, and a processor that needs time for each byte and each packet. Whatever floods the wire, no byte is
//! lost, and a request is taken within the stated time.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

use core::cell::{Cell, RefCell};
use core::sync::atomic::{AtomicU8, Ordering};
use firmware::board::{INCOMING, Incoming, LinkOutput, OUTGOING};
use firmware::serve::{self, Served};
use link::{
    Access, BoardChannel, Circular, Encoder, Filling, Frame, Halves, Hello, HostChannel, Key, NonceSource,
    NumberedRequest, Outgoing, PACKET_MAX, Pacing, Received, Refusal, Request, Sending, Value,
};
use std::collections::VecDeque;
use std::rc::Rc;

const KEY: [u8; 32] = [0x31; 32];
const OWN: Hello = Hello { robot: 7, joints: 6, rate_hz: 1000.0, pacing: Pacing::LockStep };
const BUFFER: usize = INCOMING + 2;

/// Cycles at 168 MHz while a byte is on the wire: 10 bits at 1 Mbaud.
const BYTE_TIME: u64 = 1_680;

/// Bytes that the wire carries in a tick, at 1 kHz.
const TICK: u64 = 100;

/// Cycles of a tick, during which this task waits; at most half of its period. This is nine times the longest tick.
const TICK_CYCLES: u64 = 40_000;

/// Cycles that this task needs: to read a byte, to begin a packet, to check each of its bytes, to take a frame, and to make one. The emulator
/// counts, in instructions: 26 to 30 per byte; 159 in total for the shortest packet; 1,600 for an open or wrongly sealed packet of 12 to 17 bytes;
/// 16,700 for one of 252 bytes; 3,700 for an accepted sealed packet of 17 bytes. Each of these gets at least twice as many cycles here.
const BYTE: u64 = 60;
const PACKET: u64 = 600;
const JUDGED_BYTE: u64 = 200;
const TAKE: u64 = 4_000;
const MAKE: u64 = 6_000;

/// Stated time from the last byte of a request until it is taken, in bytes: a tick until the task starts, or half a buffer if that is shorter, plus
/// the time to read the bytes before the request.
fn taken_within(tick: u64) -> u64 {
    tick.min(BUFFER as u64 / 2) + 60
}

/// The board's hardware and its wire. Time advances when the task spends it.
struct World {
    bytes: &'static [AtomicU8; BUFFER],
    /// Received bytes, one per byte time; `None` is an idle line.
    coming: RefCell<VecDeque<Option<u8>>>,
    /// Time in bytes, and the cycles spent of the byte that is on the wire.
    now: Cell<u64>,
    spent: Cell<u64>,
    stored: Cell<usize>,
    halves: Halves,
    was_idle: Cell<bool>,
    /// The piece that the line sends.
    piece: RefCell<&'static [AtomicU8]>,
    sent: RefCell<Vec<u8>>,
    /// True if an interrupt has requested the task, or the next piece.
    pended: Cell<bool>,
    piece_sent: Cell<bool>,
    /// Period of the control timer, in bytes.
    tick: u64,
    ticks: Cell<u64>,
    /// Length so far of the packet that is being read, bytes; it determines the packet's cost.
    packet: Cell<u64>,
}

impl World {
    fn new(tick: u64) -> Rc<Self> {
        Rc::new(Self {
            tick,
            bytes: Box::leak(Box::new([const { AtomicU8::new(0) }; BUFFER])),
            coming: RefCell::default(),
            now: Cell::new(0),
            spent: Cell::new(0),
            stored: Cell::new(0),
            halves: Halves::new(),
            was_idle: Cell::new(true),
            piece: RefCell::default(),
            sent: RefCell::default(),
            pended: Cell::new(false),
            piece_sent: Cell::new(false),
            ticks: Cell::new(0),
            packet: Cell::new(0),
        })
    }

    /// Advances the time by cycles of the task.
    fn spend(&self, cycles: u64) {
        self.spent.set(self.spent.get() + cycles);
        while self.spent.get() >= BYTE_TIME {
            self.spent.set(self.spent.get() - BYTE_TIME);
            self.step();
        }
    }

    /// Advances the time by one byte.
    fn step(&self) {
        self.now.set(self.now.get() + 1);
        match self.coming.borrow_mut().pop_front().flatten() {
            Some(byte) => {
                let at = self.stored.get() % BUFFER;
                self.bytes[at].store(byte, Ordering::Relaxed);
                self.stored.set(self.stored.get() + 1);
                let (first, second) = (at + 1 == BUFFER / 2, at + 1 == BUFFER);
                self.halves.count(first, second);
                self.was_idle.set(false);
                if first || second {
                    self.pended.set(true);
                }
            }
            None => {
                if !self.was_idle.replace(true) {
                    self.pended.set(true);
                }
            }
        }
        let piece = *self.piece.borrow();
        if let Some((first, rest)) = piece.split_first() {
            self.sent.borrow_mut().push(first.load(Ordering::Relaxed));
            self.piece.replace(rest);
            if rest.is_empty() {
                self.piece_sent.set(true);
            }
        }
        if self.now.get().is_multiple_of(self.tick) {
            self.ticks.set(self.ticks.get() + 1);
            self.pended.set(true);
            // The tick interrupts the task.
            self.spent.set(self.spent.get() + (self.tick * BYTE_TIME / 2).min(TICK_CYCLES));
        }
    }
}

struct Stored(Rc<World>);

impl Filling for Stored {
    fn position(&self) -> usize {
        self.0.stored.get() % BUFFER
    }

    fn halves(&self) -> u32 {
        self.0.halves.so_far()
    }
}

struct Line(Rc<World>);

impl Sending for Line {
    fn is_idle(&mut self) -> bool {
        // Reading the status costs time, also for a writer that waits.
        self.0.spend(20);
        self.0.piece.borrow().is_empty()
    }

    fn start(&mut self, piece: &'static [AtomicU8]) {
        self.0.piece.replace(piece);
    }
}

struct Input(Circular<Stored, BUFFER>, Rc<World>);

impl Incoming for Input {
    fn next(&mut self) -> Option<u8> {
        let byte = self.0.next_byte();
        let world = &self.1;
        world.spend(BYTE);
        match byte {
            // A byte beyond the longest packet is dropped.
            Some(1..) => world.packet.set((world.packet.get() + 1).min(PACKET_MAX as u64)),
            Some(0) if world.packet.get() > 0 => world.spend(PACKET + JUDGED_BYTE * world.packet.take()),
            _ => {}
        }
        byte
    }

    fn has_lost(&mut self) -> bool {
        self.0.has_lost()
    }
}

struct Output(Outgoing<Line, OUTGOING>, Rc<World>);

impl LinkOutput for Output {
    fn write(&mut self, bytes: &[u8]) {
        self.1.spend(MAKE);
        self.0.write(bytes);
    }

    fn room(&mut self) -> usize {
        self.0.room()
    }

    fn sent(&mut self) {
        self.0.advance();
    }
}

/// A session that reports each tick at full length, and records each request with the time at which it was taken.
struct Session {
    world: Rc<World>,
    said: u64,
    reports: bool,
    taken: Vec<(Frame, u64)>,
}

impl Served<Output> for Session {
    fn take(&mut self, received: Received, channel: &mut BoardChannel, output: &mut Output) {
        self.world.spend(TAKE);
        self.taken.push((received.frame.clone(), self.world.now.get()));
        match received.frame {
            Frame::Get(index) => {
                let value = Value { index, value: 1.5, low: 1.0, high: 2.0 };
                serve::reply(channel, output, &Frame::Value(value));
            }
            Frame::Request(NumberedRequest { request: Request::Hold, .. }) => {}
            _ => serve::reply(channel, output, &Frame::Refusal(Refusal::Lost { missed: 1 })),
        }
    }

    fn say(&mut self) -> Option<(Frame, bool)> {
        let new = self.reports && self.said < self.world.ticks.get();
        self.said = self.world.ticks.get();
        new.then(|| (report(), false))
    }

    fn dumps(&mut self) -> bool {
        false
    }
}

/// A report that needs longer on the wire than a tick.
fn report() -> Frame {
    Frame::Live(link::Live::new(&dynamics_core::Live::<f32, 6>::zero()).unwrap())
}

/// A board, its host, the bytes that the host sends, and the times at which its requests to hold end.
struct Rig {
    world: Rc<World>,
    input: Input,
    output: Output,
    channel: BoardChannel,
    session: Session,
    host: HostChannel,
    wire: Vec<Option<u8>>,
    holds: Vec<u64>,
    lost: bool,
}

impl Rig {
    /// Creates a session with a key, before the flood.
    fn start(tick: u64) -> Self {
        let world = World::new(tick);
        let (mut channel, mut host) = (BoardChannel::new(Access::Key(&KEY)), HostChannel::new(Some(Key::new(KEY))));
        let mut said = Vec::new();
        for byte in host.join([9; 16]).unwrap() {
            channel.push(byte, &OWN, &mut nonce, &mut |bytes| said.extend_from_slice(bytes));
        }
        let challenge = said.iter().find_map(|&byte| host.push(byte)).unwrap().unwrap().frame;
        let Frame::Challenge(challenge) = challenge else { panic!("{challenge:?}") };
        for byte in host.answer(&challenge).unwrap().unwrap() {
            channel.push(byte, &OWN, &mut nonce, &mut |_| panic!("a right proof"));
        }
        Self {
            input: Input(Circular::new(world.bytes, Stored(world.clone())), world.clone()),
            output: Output(Outgoing::new(leak(), Line(world.clone())), world.clone()),
            channel,
            session: Session { world: world.clone(), said: 0, reports: true, taken: Vec::new() },
            host,
            wire: Vec::new(),
            holds: Vec::new(),
            lost: false,
            world,
        }
    }

    fn put(&mut self, bytes: &[u8]) {
        self.wire.extend(bytes.iter().copied().map(Some));
    }

    /// Sends a request to hold, after a zero that ends any earlier bytes.
    fn hold(&mut self) {
        let packet = self.host.encode(&Frame::request(1, Request::Hold)).unwrap();
        self.put(&[0]);
        self.put(&packet);
        self.holds.push(self.wire.len() as u64);
    }

    /// Runs this task until all bytes are handled.
    fn run(&mut self, task: fn(&mut Self) -> bool) {
        self.world.coming.borrow_mut().extend(self.wire.drain(..));
        let mut left = 20 * TICK;
        while left > 0 {
            left -= u64::from(self.world.coming.borrow().is_empty());
            if self.world.piece_sent.take() {
                self.output.sent();
                self.world.pended.set(true);
            }
            if self.world.pended.take() {
                self.lost |= self.input.has_lost();
                let again = task(self);
                self.world.pended.set(self.world.pended.get() || again);
                self.world.spend(1_000);
            } else {
                self.world.step();
            }
        }
    }

    /// Times from the end of each request to hold until it was taken, in bytes.
    fn delays(&self) -> Vec<u64> {
        let taken: Vec<u64> =
            self.session.taken.iter().filter(|(frame, _)| is_hold(frame)).map(|(_, time)| *time).collect();
        assert_eq!(taken.len(), self.holds.len(), "requests taken of those sent");
        taken.iter().zip(&self.holds).map(|(taken, sent)| taken - sent).collect()
    }

    /// Number of reports that the host has read.
    fn reports(&mut self) -> usize {
        let sent = core::mem::take(&mut *self.world.sent.borrow_mut());
        let frames = sent.iter().filter_map(|&byte| self.host.push(byte)).map(|received| received.unwrap());
        frames.filter(|received| matches!(received.frame, Frame::Live(_))).count()
    }
}

fn leak() -> &'static [AtomicU8; OUTGOING] {
    Box::leak(Box::new([const { AtomicU8::new(0) }; OUTGOING]))
}

fn is_hold(frame: &Frame) -> bool {
    matches!(frame, Frame::Request(NumberedRequest { request: Request::Hold, .. }))
}

fn nonce() -> Option<([u8; 16], NonceSource)> {
    Some(([3; 16], NonceSource::Generator))
}

/// The task as the firmware runs it.
fn as_it_is(rig: &mut Rig) -> bool {
    let Rig { input, channel, output, session, .. } = rig;
    serve::run(input, channel, output, &OWN, &mut nonce, session)
}

/// An earlier version of the task: it sends reports first, answers each packet, and waits for the line.
fn with_an_answer_to_each(rig: &mut Rig) -> bool {
    let Rig { input, channel, output, session, .. } = rig;
    while let Some((frame, _)) = session.say() {
        serve::send(channel, output, &frame);
    }
    while let Some(byte) = input.next() {
        match channel.push(byte, &OWN, &mut nonce, &mut |bytes| output.write(bytes)) {
            Some(Ok(received)) => session.take(received, channel, output),
            Some(Err(error)) => serve::send(channel, output, &Frame::Refusal(Refusal::Undecodable(error))),
            None => {}
        }
    }
    false
}

/// Pseudo-random bytes, the same in every run.
fn noise(seed: u32) -> impl Iterator<Item = u8> {
    let mut state = seed;
    core::iter::repeat_with(move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        (state >> 11) as u8
    })
}

/// Puts bytes that flood the wire, or idle times, on it.
type Flood = fn(&mut Rig, u32);

fn without_zeros(rig: &mut Rig, seed: u32) {
    let bytes: Vec<u8> = noise(seed + 1).filter(|byte| *byte != 0).take(973).collect();
    rig.put(&bytes);
}

fn any_bytes(rig: &mut Rig, seed: u32) {
    let bytes: Vec<u8> = noise(seed + 1).take(973).collect();
    rig.put(&bytes);
}

/// The shortest packets: each used to cause a refusal of nine times its length.
fn shortest_packets(rig: &mut Rig, _: u32) {
    rig.put(&[1, 0].repeat(487));
}

fn zeros(rig: &mut Rig, _: u32) {
    rig.put(&[0; 911]);
}

/// The line becomes idle after each byte, which requests the task each time.
fn single_bytes(rig: &mut Rig, _: u32) {
    for _ in 0..160 {
        rig.wire.extend([Some(1), None, Some(0), None]);
    }
}

fn packets_too_long(rig: &mut Rig, _: u32) {
    for length in [253, 254, 300, 500] {
        rig.put(&vec![7; length]);
        rig.put(&[0]);
    }
}

fn open_frames(rig: &mut Rig, seed: u32) {
    let mut stranger = Encoder::new();
    for i in 0..12 {
        for frame in [
            Frame::Join([seed as u8 + i; 16]),
            Frame::Hello(Hello { pacing: Pacing::Live, ..OWN }),
            Frame::request(2, Request::Disarm),
            Frame::Alive,
        ] {
            rig.put(&stranger.encode(&frame).unwrap());
        }
    }
}

/// Packets that are marked as sealed, but have no valid seal.
fn wrong_seals(rig: &mut Rig, seed: u32) {
    for frame in [Frame::Alive, report(), Frame::Alive, report(), Frame::Join([seed as u8; 16])] {
        let mut packet = HostChannel::new(None).encode(&frame).unwrap();
        // The version byte marks the packet as sealed.
        packet[1] |= 0x80;
        rig.put(&packet);
    }
}

/// The host itself sends far more requests than there is capacity for answers.
fn questions(rig: &mut Rig, _: u32) {
    for index in 0..60 {
        let packet = rig.host.encode(&Frame::Get(index)).unwrap();
        rig.put(&packet);
    }
}

const FLOODS: [(&str, Flood); 9] = [
    ("bytes that are not zero", without_zeros),
    ("any bytes", any_bytes),
    ("shortest packets", shortest_packets),
    ("zeros", zeros),
    ("single bytes", single_bytes),
    ("packets that are too long", packets_too_long),
    ("open frames", open_frames),
    ("wrong seals", wrong_seals),
    ("questions", questions),
];

/// Sends requests to hold during a flood that fills the wire for 0.2 s.
fn flooded(flood: Flood, tick: u64, task: fn(&mut Rig) -> bool) -> Rig {
    let mut rig = Rig::start(tick);
    for seed in 0..20 {
        flood(&mut rig, seed);
        rig.hold();
    }
    rig.run(task);
    rig
}

#[test]
fn a_hold_is_taken_in_the_stated_time_whatever_floods_the_wire() {
    // 4 kHz, 1 kHz, 500 Hz, and a rate at which the buffer fills within a tick.
    for tick in [TICK / 4, TICK, 2 * TICK, 10 * TICK] {
        for (name, flood) in FLOODS {
            let rig = flooded(flood, tick, as_it_is);
            assert!(!rig.lost, "{name}: bytes were lost");
            let longest = rig.delays().into_iter().max().unwrap();
            println!("a tick of {tick} bytes, {name}: {longest} bytes' time");
            assert!(longest <= taken_within(tick), "{name}: {longest} bytes' time");
        }
    }
}

/// The line carries 100 bytes per tick, and a report has 130.
#[test]
fn a_flood_keeps_few_reports_from_the_host() {
    for (name, flood) in FLOODS {
        let mut rig = flooded(flood, TICK, as_it_is);
        let (ticks, reports) = (rig.world.ticks.get(), rig.reports() as u64);
        println!("{name}: {reports} reports in {ticks} ticks");
        // The answers to the host's own questions use the line too.
        let least = if name == "questions" { ticks / 20 } else { ticks / 2 };
        assert!(reports >= least, "{name}: {reports} reports in {ticks} ticks");
    }
}

/// Shows why the task's rules are needed: without them the shortest packets keep the task waiting for the line, while the buffer overflows.
#[test]
fn an_answer_to_each_packet_loses_bytes_of_a_flood() {
    let rig = flooded(shortest_packets, TICK, with_an_answer_to_each);
    let taken = rig.session.taken.iter().filter(|(frame, _)| is_hold(frame)).count();
    println!("{taken} of {} requests were taken", rig.holds.len());
    assert!(rig.lost && taken < rig.holds.len());
}

/// A host that requests more reports than the line carries can still send requests.
#[test]
fn reports_that_fill_the_line_do_not_keep_a_request_waiting() {
    let mut rig = Rig::start(TICK);
    for _ in 0..100 {
        rig.wire.extend([None; 70]);
        rig.hold();
    }
    rig.run(as_it_is);
    let longest = rig.delays().into_iter().max().unwrap();
    assert!(!rig.lost && longest <= taken_within(TICK), "{longest} bytes' time");
}
