//! Tests that this crate produces the examples of `docs/link.md`, and reads them back from the page.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

use newtau_link::seal::{Side, Transcript};
use newtau_link::{
    Actuation, Answer, Challenge, Command, Cost, Decoder, Encoder, Frame, Hello, Joints, Key, Lines, Measurement,
    NonceSource, Pacing, Parts, Point, Reference, Refusal, Request, Sensed, Status, Trust, Verdict, Watch,
};
use std::fmt::Write as _;

const HELLO: Hello = Hello { robot: 0x0123_4567_89ab_cdef, joints: 2, rate_hz: 1000.0, pacing: Pacing::DryRun };

/// The key in the page's examples: bytes 00, 01, .. 1f. The nonces there are 16 bytes a0, and 16 bytes b0.
fn key() -> Key {
    Key::new(core::array::from_fn(|i| i as u8))
}

fn joints<T: Copy + core::fmt::Debug>(values: [T; 2]) -> Joints<T> {
    Joints::from_slice(&values).unwrap()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect()
}

/// Frames from the beginning of a dry run, each with its name on the page.
fn frames() -> [(&'static str, Frame); 9] {
    let rest = Reference { q: joints([0.5, -0.25]), qd: joints([0.0; 2]), qdd: joints([0.0; 2]) };
    let sensed = Sensed::State { q: joints([0.5, -0.25]), qd: joints([0.0; 2]) };
    [
        ("hello, dry run", Frame::Hello(HELLO)),
        ("lines, calm, 24 V", Frame::Lines(Lines { supply: Some(24.0), ..Lines::CALM })),
        ("request, home", Frame::request(1, Request::Home)),
        ("point, a start", Frame::Point(Point { ticks: 0, reference: rest })),
        ("measurement, tick 1", Frame::Measurement(Measurement { tick: 1, age_ticks: 0, sensed })),
        ("measurement, counts, tick 300", {
            let sensed = Sensed::Counts(joints([-1, 70_000]));
            Frame::Measurement(Measurement { tick: 300, age_ticks: 0, sensed })
        }),
        ("watch, every 10th tick, torques", Frame::Watch(Watch { every: 10, parts: Parts::TORQUE })),
        ("alive", Frame::Alive),
        ("request, hold", Frame::request(2, Request::Hold)),
    ]
}

/// Frames that a board sends.
fn answers() -> [(&'static str, Frame); 4] {
    let status = Status {
        tick: 1,
        taken: 5,
        state: newtau_link::StateCode::Armed,
        cause: 0,
        joint: None,
        homed: true,
        refused: None,
        kept: false,
        room: 16,
        actuation: Some(Actuation::Drive { torque: joints([1.5, -2.0]), limits: joints([0; 2]) }),
        sensed: None,
        extra: newtau_link::ExtraFields::Nothing,
        cost: None,
    };
    [
        ("hello, dry run", Frame::Hello(HELLO)),
        ("refusal, 1 packet lost", Frame::Refusal(Refusal::Lost { missed: 1 })),
        ("answer, request 1 accepted", Frame::Answer(Answer { number: 1, verdict: Verdict::Accepted })),
        ("status, armed", Frame::Status(status)),
    ]
}

/// The table of examples: frame, packet.
fn table(side: Side) -> String {
    let mut encoder = Encoder::new();
    encoder.seal_with(key().session(side, &Transcript::new(&[0xa0; 16], &[0xb0; 16])).sending);
    let frames = match side {
        Side::Host => frames().to_vec(),
        Side::Board => answers().to_vec(),
    };
    let mut text = String::new();
    for (name, frame) in frames {
        writeln!(text, "{name}\n  frame   {}\n  packet  {}", plain(&frame), hex(&encoder.encode(&frame).unwrap()))
            .unwrap();
    }
    text
}

fn plain(frame: &Frame) -> String {
    postcard::to_slice(frame, &mut [0; 128]).map(|bytes| hex(bytes)).unwrap()
}

/// The first two packets of a board that has started: its hello, and its challenge.
fn opening() -> String {
    let own = Hello { pacing: Pacing::LockStep, ..HELLO };
    let proof = key().proof(Side::Board, &Transcript::new(&[0xa0; 16], &[0xb0; 16]));
    let trust = Trust::Key { nonce: [0xb0; 16], source: NonceSource::Generator, proof };
    let mut board = Encoder::new();
    let mut text = String::new();
    for (name, gap, frame) in
        [("hello", "    ", Frame::Hello(own)), ("challenge", "", Frame::Challenge(Challenge { own, trust }))]
    {
        writeln!(text, "{name} frame {gap} {}", plain(&frame)).unwrap();
        writeln!(text, "{name} packet{gap} {}", hex(&board.encode(&frame).unwrap())).unwrap();
    }
    text
}

/// A tick in lock step.
fn bench() -> String {
    let reference = Reference { q: joints([0.5, -0.25]), qd: joints([0.0; 2]), qdd: joints([0.0; 2]) };
    let sensed = Sensed::State { q: joints([0.5, -0.25]), qd: joints([0.0; 2]) };
    let cost = Some(Cost::Instructions(1468));
    let command = Command { tick: 1, torque: joints([1.5, -2.0]), limits: joints([0; 2]), cost };
    format!(
        "reference    {}\nmeasurement  {}\ncommand      {}\n",
        plain(&Frame::Reference(reference)),
        plain(&Frame::Measurement(Measurement { tick: 1, age_ticks: 0, sensed })),
        plain(&Frame::Command(command))
    )
}

/// Numbers of a handshake, and its packets.
fn handshake() -> String {
    let transcript = Transcript::new(&[0xa0; 16], &[0xb0; 16]);
    let join = Encoder::new().encode(&Frame::Join([0xa0; 16])).unwrap();
    let proof = |side| hex(postcard::to_slice(&key().proof(side, &transcript), &mut [0; 16]).unwrap());
    let mut host = Encoder::new();
    host.encode(&Frame::Join([0xa0; 16])).unwrap();
    let answer = host.encode(&Frame::Proof(key().proof(Side::Host, &transcript))).unwrap();
    format!(
        "join packet      {}\nproof of board   {}\nproof of host    {}\nproof packet     {}\n",
        hex(&join),
        proof(Side::Board),
        proof(Side::Host),
        hex(&answer)
    )
}

fn page() -> String {
    std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/link.md")).unwrap()
}

#[test]
fn the_page_has_the_packets_that_this_crate_makes() {
    let page = page();
    let missing: String = [opening(), handshake(), bench(), table(Side::Host), table(Side::Board)]
        .into_iter()
        .filter(|block| !page.contains(block))
        .collect();
    assert!(missing.is_empty(), "docs/link.md should have\n{missing}");
}

/// Reads the bytes of the page as a board and a host would.
#[test]
fn the_page_s_own_packets_are_read_as_what_it_says() {
    let page = page();
    let packets = page.lines().filter_map(|line| line.strip_prefix("  packet  "));
    let packets: Vec<Vec<u8>> = packets.map(bytes).collect();
    assert_eq!(packets.len(), frames().len() + answers().len());
    let (sent, said) = packets.split_at(frames().len());
    let transcript = Transcript::new(&[0xa0; 16], &[0xb0; 16]);
    for (side, packets, frames) in [(Side::Board, sent, frames().to_vec()), (Side::Host, said, answers().to_vec())] {
        let mut decoder = Decoder::new();
        decoder.seal_with(key().session(side, &transcript).receiving);
        let read: Vec<Frame> =
            packets.iter().flatten().filter_map(|&byte| decoder.push(byte)).map(|read| read.unwrap().frame).collect();
        assert_eq!(read, frames.into_iter().map(|(_, frame)| frame).collect::<Vec<_>>());
    }
}

/// The page's table has every frame, with its tag.
#[test]
fn every_frame_has_its_row() {
    let page = page();
    let names = [
        "hello",
        "measurement",
        "reference",
        "command",
        "fault",
        "refusal",
        "live",
        "request",
        "lines",
        "point",
        "alive",
        "watch",
        "dump",
        "get",
        "set",
        "join",
        "proof",
        "challenge",
        "status",
        "past",
        "value",
        "answer",
    ];
    assert_eq!(names.len(), usize::from(Frame::KINDS));
    for (tag, name) in names.iter().enumerate() {
        assert!(page.contains(&format!("| {tag} | {name} |")), "{tag}: {name}");
    }
}
