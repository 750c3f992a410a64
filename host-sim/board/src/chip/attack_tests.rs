//! Strangers on the wire of the emulated chip: whatever they send, no tick of theirs is driven, and no tick of the session's
//! is lost.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use super::{Chip, ChipError, Emulator, Timeouts, build_firmware, build_firmware_by_dma};
use crate::key;
use dynamics_core::{Measurement, Reference, Sensed};
use link::{
    Actuation, Distrust, Encoder, Frame, Hello, HostChannel, Key, Lines, Pacing, Point, Refusal, Request, StateCode,
    Status, Trust,
};
use robot_compiler::SceneFile;
use std::path::{Path, PathBuf};

const KEY: Key = Key::new([0x6b; 32]);
const REST: Sensed<f32, 2> = Sensed::State { q: [0.1, 0.2], qd: [0.0; 2] };

fn scene() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/planar2r_swing.toml")
}

fn hello(pacing: Pacing) -> Hello {
    let file = SceneFile::load(&scene()).unwrap();
    crate::chip::hello(&file, &file.robot.model::<2>().unwrap(), pacing)
}

fn emulator(key: Option<Key>) -> Emulator {
    emulator_of(&build_firmware(&scene()).unwrap(), key)
}

fn emulator_of(elf: &Path, key: Option<Key>) -> Emulator {
    let program = Path::new("qemu-system-arm");
    match key {
        Some(key) => Emulator::start_with_key(program, elf, Timeouts::default(), key),
        None => Emulator::start_without_key(program, elf, Timeouts::default()),
    }
    .unwrap()
}

/// A chip with its host in a dry run, and the number of the last tick.
struct AttackedDryRun(Chip, u32);

impl AttackedDryRun {
    fn start() -> Self {
        Self::over(emulator(Some(KEY)))
    }

    fn over(emulator: Emulator) -> Self {
        let mut chip = Chip::over(emulator, hello(Pacing::LockStep)).unwrap();
        chip.change_pacing(hello(Pacing::DryRun)).unwrap();
        chip.send(&Frame::Lines(Lines::CALM)).unwrap();
        Self(chip, 0)
    }

    /// A dry run whose arm is armed, with all bytes that led there.
    fn armed() -> Self {
        Self::start().arm()
    }

    fn arm(mut self) -> Self {
        for request in [Request::Home, Request::Confirm, Request::Arm] {
            self.ask(request);
        }
        while self.tick().0.state != StateCode::Armed {
            assert!(self.1 < 100, "it is not armed");
        }
        self
    }

    fn running() -> Self {
        Self::armed().run()
    }

    fn run(mut self) -> Self {
        let reference = link::Reference::new(&Reference { q: [0.1_f32, 0.2], qd: [0.0; 2], qdd: [0.0; 2] });
        self.0.send(&Frame::Point(Point { ticks: 0, reference })).unwrap();
        assert_eq!(self.ask(Request::Run).0.state, StateCode::Running);
        self
    }

    fn ask(&mut self, request: Request) -> (Status, u16) {
        let number = self.1 as u8;
        self.0.send(&Frame::request(number, request)).unwrap();
        self.tick()
    }

    /// One tick: its status, and the count of packets that were refused before it as not authentic, if any were.
    fn tick(&mut self) -> (Status, u16) {
        let (status, refusals) = self.tick_after_noise();
        let count = |refusal: &Refusal| match refusal {
            Refusal::Unauthentic { count } => *count,
            other => panic!("{other:?}"),
        };
        (status, refusals.iter().map(count).fold(0, |_, last| last))
    }

    /// One tick: its status, and every refusal before it.
    fn tick_after_noise(&mut self) -> (Status, Vec<Refusal>) {
        self.1 += 1;
        let measurement = link::Measurement::new(self.1, &Measurement { sensed: REST, age_ticks: 0 });
        self.0.send(&Frame::Measurement(measurement)).unwrap();
        let mut refusals = Vec::new();
        loop {
            match self.0.receive("a status").unwrap() {
                Frame::Refusal(refusal) => refusals.push(refusal),
                Frame::Answer(_) => {}
                Frame::Status(status) => return (status, refusals),
                other => panic!("{other:?}"),
            }
        }
    }

    /// A packet of the session, not sent yet.
    fn packet(&mut self, frame: &Frame) -> Vec<u8> {
        self.0.channel.encode(frame).unwrap().to_vec()
    }

    fn attack(&mut self, bytes: &[u8]) {
        self.0.emulator.write(bytes).unwrap();
    }
}

fn drives(status: &Status) -> bool {
    matches!(status.actuation, Some(Actuation::Drive { .. }))
}

/// Give a chip bytes, and return all that it said to them, as a stranger hears it: up to the challenge that he asks for at the
/// end.
fn heard_by_a_stranger(emulator: &mut Emulator, bytes: &[u8]) -> Vec<Frame> {
    let mut stranger = HostChannel::new(None);
    emulator.write(bytes).unwrap();
    emulator.write(&stranger.join([0xee; 16]).unwrap()).unwrap();
    let mut frames = Vec::new();
    // Bytes of his may hold a join too: the challenge is the last one when nothing follows it for a while.
    while !matches!(frames.last(), Some(Frame::Challenge(_))) {
        let byte = emulator.read_byte("a challenge").unwrap();
        if let Some(Ok(received)) = stranger.push(byte) {
            frames.push(received.frame);
        }
    }
    frames
}

/// A chip that has started, and said its hello.
fn started(key: Option<Key>) -> Emulator {
    let mut emulator = emulator(key);
    let mut host = HostChannel::new(None);
    while host.push(emulator.read_byte("the chip's hello").unwrap()).is_none() {}
    emulator
}

#[test]
fn a_whole_session_replayed_to_a_chip_that_has_started_anew_does_nothing() {
    let mut dry_run = AttackedDryRun::armed();
    assert!(drives(&dry_run.tick().0));
    let sent = dry_run.0.sent.clone();
    // The same key, another start: another random number beside the key.
    let mut anew = started(Some(KEY));
    // The replayed join gets a challenge of its own, the stranger's the second.
    let mut said = heard_by_a_stranger(&mut anew, &sent);
    said.extend(heard_by_a_stranger(&mut anew, &[]));
    assert!(
        !said.iter().any(|frame| matches!(frame, Frame::Status(_) | Frame::Command(_) | Frame::Hello(_))),
        "{said:?}"
    );
    assert!(said.iter().any(|frame| matches!(frame, Frame::Refusal(Refusal::Unauthentic { count: 5.. }))), "{said:?}");
}

#[test]
fn packets_of_the_session_itself_replayed_or_out_of_order_do_nothing_more() {
    let mut dry_run = AttackedDryRun::armed();
    let armed = dry_run.0.sent.clone();
    dry_run.ask(Request::Disarm);
    assert!(!drives(&dry_run.tick().0));
    // The brakes engage.
    let mut ticks = 0;
    while dry_run.tick().0.state == StateCode::Disarming {
        ticks += 1;
        assert!(ticks < 1000);
    }
    // All that once led to torque, and the same backwards.
    let packets: Vec<&[u8]> = armed.split_inclusive(|&byte| byte == 0).filter(|packet| packet.len() > 1).collect();
    let refused_before = dry_run.tick().1;
    dry_run.attack(&packets.concat());
    dry_run.attack(&packets.iter().rev().copied().collect::<Vec<_>>().concat());
    let (status, refused) = dry_run.tick();
    assert!(!drives(&status) && status.state == StateCode::Idle, "{status:?}");
    // The joins among them are answered, not refused.
    assert_eq!((refused_before, usize::from(refused)), (0, 2 * (packets.len() - 1)));
    // A request that comes too late, behind a later packet.
    let early = dry_run.packet(&Frame::request(201, Request::Arm));
    dry_run.0.send(&Frame::Alive).unwrap();
    assert_eq!(dry_run.0.receive("a refusal").unwrap(), Frame::Refusal(Refusal::Lost { missed: 1 }));
    dry_run.attack(&early);
    assert!(!drives(&dry_run.tick().0));
}

#[test]
fn a_request_with_a_bit_changed_or_its_seal_cut_short_is_refused_and_the_whole_one_is_granted() {
    let mut dry_run = AttackedDryRun::start();
    dry_run.ask(Request::Home);
    dry_run.ask(Request::Confirm);
    let arm = dry_run.packet(&Frame::request(201, Request::Arm));
    let mut attacks = 0;
    for bit in (0..8 * (arm.len() - 1)).step_by(3) {
        let mut changed = arm.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        // A changed byte may be a zero, or end the packet early; what is left of it is then a packet of its own.
        dry_run.attack(&changed);
        dry_run.attack(&[0]);
        attacks += 1;
    }
    for length in 2..arm.len() - 1 {
        dry_run.attack(&arm[..length]);
        dry_run.attack(&[0]);
        attacks += 1;
    }
    assert!(attacks > 50);
    dry_run.0.emulator.write(&arm).unwrap();
    // They were refused before the whole packet was taken; several that come at once share a refusal.
    let (status, refusals) = dry_run.tick_after_noise();
    assert!(!refusals.is_empty());
    assert_eq!(status.state, StateCode::Arming);
}

#[test]
fn a_host_with_another_key_gets_nowhere_and_a_forged_proof_gets_no_further() {
    let mut emulator = started(Some(KEY));
    let (mut wrong, other) = (HostChannel::new(Some(Key::new([1; 32]))), Key::new([1; 32]));
    emulator.write(&wrong.join([9; 16]).unwrap()).unwrap();
    let challenge = loop {
        match wrong.push(emulator.read_byte("a challenge").unwrap()) {
            Some(Ok(received)) => break received.frame,
            Some(Err(error)) => panic!("{error}"),
            None => {}
        }
    };
    let Frame::Challenge(challenge) = challenge else { panic!("{challenge:?}") };
    assert_eq!(wrong.answer(&challenge), Err(Distrust::WrongProof));
    // He goes on all the same, with proof and seals of his own key.
    let Trust::Key { nonce, .. } = challenge.trust else { panic!("{challenge:?}") };
    let transcript = link::seal::Transcript::new(&[9; 16], &nonce);
    let mut encoder = Encoder::new();
    let mut bytes = encoder.encode(&Frame::Proof(other.proof(link::seal::Side::Host, &transcript))).unwrap().to_vec();
    encoder.seal_with(other.session(link::seal::Side::Host, &transcript).sending);
    for frame in [Frame::Hello(hello(Pacing::DryRun)), Frame::Lines(Lines::CALM), Frame::request(202, Request::Home)] {
        bytes.extend_from_slice(&encoder.encode(&frame).unwrap());
    }
    let said = heard_by_a_stranger(&mut emulator, &bytes);
    // Packets that come at once share a refusal, which counts all of them.
    let (_, refusals) = said.split_last().unwrap();
    assert!(refusals.iter().all(|frame| matches!(frame, Frame::Refusal(Refusal::Unauthentic { .. }))), "{said:?}");
    assert_eq!(refusals.last(), Some(&Frame::Refusal(Refusal::Unauthentic { count: 4 })));
}

#[test]
fn a_flood_of_joins_hellos_and_open_stops_disturbs_no_tick_of_the_session() {
    let mut dry_run = AttackedDryRun::running();
    let mut stranger = Encoder::new();
    for round in 1..=20_u16 {
        for _ in 0..5 {
            for frame in [
                Frame::Join(key::random().unwrap()),
                Frame::Hello(hello(Pacing::Live)),
                Frame::request(203, Request::Hold),
                Frame::request(204, Request::Disarm),
            ] {
                let packet = stranger.encode(&frame).unwrap();
                dry_run.attack(&packet);
            }
        }
        let (status, refused) = dry_run.tick();
        assert!(drives(&status) && status.state == StateCode::Running, "{status:?}");
        assert_eq!(refused, 15 * round, "hellos and requests are counted, joins are answered");
    }
}

#[test]
fn without_a_key_there_is_the_bench_and_no_dry_run() {
    let mut emulator = started(None);
    let mut encoder = Encoder::new();
    let dry_run = encoder.encode(&Frame::Hello(hello(Pacing::DryRun))).unwrap();
    let said = heard_by_a_stranger(&mut emulator, &dry_run);
    assert_eq!(said[0], Frame::Refusal(Refusal::NoKey));
    let Some(Frame::Challenge(challenge)) = said.last() else { panic!("{said:?}") };
    assert_eq!((challenge.trust, challenge.own), (Trust::NoKey, hello(Pacing::LockStep)));
    let bench = Chip::over(self::emulator(None), hello(Pacing::LockStep));
    let mut bench = bench.unwrap();
    let error = bench.change_pacing(hello(Pacing::DryRun)).unwrap_err();
    assert!(matches!(error, ChipError::Refused(Refusal::NoKey)), "{error}");
    assert!(error.to_string().contains("cargo newtau firmware key write"), "{error}");
}

/// No two challenges of a chip are the same, nor those of two starts.
#[test]
fn nonces_do_not_come_again() {
    let mut all = Vec::new();
    for _ in 0..2 {
        let mut emulator = started(Some(KEY));
        for _ in 0..5 {
            let said = heard_by_a_stranger(&mut emulator, &[]);
            let Some(Frame::Challenge(challenge)) = said.last() else { panic!("{said:?}") };
            let Trust::Key { nonce, .. } = challenge.trust else { panic!("{challenge:?}") };
            assert!(!all.contains(&nonce), "{nonce:?}");
            all.push(nonce);
        }
    }
}

/// More garbage than the chip's queue of bytes holds, its last zero dropped with it: the stop behind it is taken.
#[test]
fn a_stop_behind_a_flood_of_garbage_stops_the_arm() {
    for garbage in [700, 754, 755, 756, 757, 758, 1000, 3000] {
        a_stop_is_taken(AttackedDryRun::running(), garbage);
    }
}

/// The same by DMA: what was overwritten in its buffer is left out.
#[test]
fn a_stop_behind_a_flood_of_garbage_stops_the_arm_by_dma_too() {
    let elf = build_firmware_by_dma(&scene()).unwrap();
    for garbage in [378, 379, 700, 756, 757, 758, 759, 1000, 3000] {
        a_stop_is_taken(AttackedDryRun::over(emulator_of(&elf, Some(KEY))).arm().run(), garbage);
    }
}

fn a_stop_is_taken(mut dry_run: AttackedDryRun, garbage: usize) {
    dry_run.attack(&vec![1; garbage]);
    dry_run.attack(&[0]);
    let hold = dry_run.packet(&Frame::request(205, Request::Hold));
    dry_run.0.emulator.write(&hold).unwrap();
    let (status, refusals) = dry_run.tick_after_noise();
    let known = |refusal: &Refusal| matches!(refusal, Refusal::Undecodable(_) | Refusal::Unauthentic { .. });
    assert!(refusals.iter().all(known), "{refusals:?}");
    assert_eq!(status.state, StateCode::Holding, "{garbage} bytes of garbage");
}
