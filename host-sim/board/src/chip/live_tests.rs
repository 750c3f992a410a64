//! Live sessions in the emulated chip, which has its own timer and its own joints (at rest at zero). The host falls silent, floods the link, or ends
//! the session with a hello.
//!
//! The emulator's serial line has no fixed rate: how many bytes it carries in a tick depends on the host machine. So times are counted from the tick
//! that a status reports as the first after a frame was taken.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

use super::{Chip, build_firmware, hello};
use dynamics_core::safety::Rules;
use link::{
    Actuation, Encoder, Frame, Hello, Pacing, Parts, Point, Reference, Refusal, Request, StateCode, Status, Verdict,
    Watch,
};
use robot_compiler::SceneFile;
use std::path::Path;

/// Returns the next status that satisfies `wanted`, and skips the others.
fn until(chip: &mut Chip, wanted: impl Fn(&Status) -> bool) -> Status {
    for _ in 0..100_000 {
        match chip.receive("a status").unwrap() {
            Frame::Status(status) if wanted(&status) => return status,
            Frame::Status(status) => assert_eq!(status.refused, None, "{status:?}"),
            Frame::Answer(_) => {}
            other => panic!("{other:?}"),
        }
    }
    panic!("100,000 ticks without it");
}

/// A chip with its host in a live session.
struct LiveChip {
    chip: Chip,
    /// The hello for lock step.
    bench: Hello,
    rules: Rules<f64, 2>,
}

impl LiveChip {
    fn start() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/planar2r_swing.toml");
        let scene = SceneFile::load(&path).unwrap();
        let model = scene.robot.model::<2>().unwrap();
        let bench = hello(&scene, &model, Pacing::LockStep);
        let mut chip = Chip::start(&build_firmware(&path).unwrap(), bench).unwrap();
        chip.change_pacing(Hello { pacing: Pacing::Live, ..bench }).unwrap();
        chip.send(&Frame::Live(link::Live::new(&scene.live::<2>(&model).cast::<f32>()).unwrap())).unwrap();
        chip.send(&Frame::Watch(Watch { every: 1, parts: Parts::TORQUE })).unwrap();
        Self { chip, bench, rules: scene.safety_rules::<2>(&model) }
    }

    /// Arms the arm. Also returns the status of the tick that took the request, the last frame that the host sent.
    fn armed() -> (Self, Status) {
        let mut live = Self::start();
        live.ask(Request::Home, |status| status.state == StateCode::Homing);
        live.ask(Request::Confirm, |status| status.state == StateCode::Idle && status.homed);
        let status = live.ask(Request::Arm, |status| status.state == StateCode::Arming);
        until(&mut live.chip, |status| status.state == StateCode::Armed);
        (live, status)
    }

    /// An arm that runs on a trajectory of one point, at its present position.
    fn running() -> Self {
        let (mut live, _) = Self::armed();
        let reference = Reference::new(&dynamics_core::Reference { q: [0.0_f32; 2], qd: [0.0; 2], qdd: [0.0; 2] });
        live.chip.send(&Frame::Point(Point { ticks: 0, reference })).unwrap();
        live.ask(Request::Run, |status| status.state == StateCode::Running);
        live
    }

    fn ask(&mut self, request: Request, wanted: impl Fn(&Status) -> bool) -> Status {
        self.chip.send(&Frame::request(request as u8, request)).unwrap();
        let status = until(&mut self.chip, wanted);
        assert_eq!(status.refused, None, "{request:?}");
        status
    }

    /// Returns the next status under a flood, and skips the refusals that the flood causes.
    fn status(&mut self) -> Status {
        loop {
            match self.chip.receive("a status").unwrap() {
                Frame::Status(status) => return status,
                Frame::Refusal(Refusal::Undecodable(_) | Refusal::Unauthentic { .. })
                | Frame::Challenge(_)
                | Frame::Answer(_) => {}
                other => panic!("{other:?}"),
            }
        }
    }
}

/// Some 100 bytes of an attacker: as many as a board's serial line carries in a tick.
type Flood = fn(&LiveChip, u32) -> Vec<u8>;

/// Bytes of which none ends a packet.
fn garbage(_: &LiveChip, seed: u32) -> Vec<u8> {
    (0..100_u32).map(|i| ((seed * 100 + i).wrapping_mul(2_654_435_761) >> 24) as u8 | 1).collect()
}

fn shortest_packets(_: &LiveChip, _: u32) -> Vec<u8> {
    [1, 0].repeat(50)
}

/// Valid packets from a sender without the key.
fn open_packets(live: &LiveChip, _: u32) -> Vec<u8> {
    let mut encoder = Encoder::new();
    let frames = [Frame::Alive, Frame::request(1, Request::Arm), Frame::Hello(live.bench), Frame::Join([7; 16])];
    frames.iter().flat_map(|frame| encoder.encode(frame).unwrap()).collect()
}

/// Packets of the session itself again.
fn replayed_packets(live: &LiveChip, _: u32) -> Vec<u8> {
    live.chip.sent[live.chip.sent.len() - 100..].to_vec()
}

const FLOODS: [(&str, Flood); 4] = [
    ("garbage", garbage),
    ("shortest packets", shortest_packets),
    ("open packets", open_packets),
    ("replayed packets", replayed_packets),
];

/// Bytes that do not belong to the session do not count as a sign of life: the arm holds and later stops, each in the stated tick.
#[test]
fn a_flood_does_not_pass_for_a_host() {
    for (name, flood) in FLOODS {
        let (mut live, mut last) = LiveChip::armed();
        let rules = live.rules;
        let mut holds = None;
        let mut said = 0;
        for round in 0..rules.heartbeat_max + rules.hold_max + 1000 {
            let bytes = flood(&live, round);
            live.chip.emulator.write(&bytes).unwrap();
            let status = live.status();
            said += 1;
            if status.taken != last.taken {
                assert!(holds.is_none(), "{name}: a frame was taken: {status:?}");
                last = status;
                continue;
            }
            match (status.state, holds) {
                (StateCode::Armed, None) | (StateCode::Holding | StateCode::Disarming, Some(_)) => {}
                (StateCode::Holding, None) => {
                    assert_eq!((status.tick - last.tick, status.cause), (rules.heartbeat_max + 1, 2), "{name}");
                    holds = Some(status.tick);
                }
                (StateCode::Fault, Some(tick)) => {
                    assert_eq!((status.tick - tick, status.cause), (rules.hold_max + rules.brake_delay, 10), "{name}");
                    break;
                }
                _ => panic!("{name}: {status:?}"),
            }
        }
        println!("{name}: {said} statuses");
        assert!(holds.is_some_and(|tick| said > tick - last.tick), "{name}: it never held");
    }
}

/// The tick after the one that takes a hold request is the first of the stop, whatever bytes precede or follow the request.
#[test]
fn a_hold_in_a_flood_is_honoured_in_the_tick_after_it_is_taken() {
    for (name, flood) in FLOODS {
        let mut live = LiveChip::running();
        let mut before = live.status();
        for round in 0..20 {
            let bytes = flood(&live, round);
            live.chip.emulator.write(&bytes).unwrap();
            before = live.status();
            assert_eq!(before.state, StateCode::Running, "{name}");
        }
        // A zero byte ends any half-sent packet.
        live.chip.emulator.write(&[0]).unwrap();
        live.chip.send(&Frame::request(200, Request::Hold)).unwrap();
        let sent = before.tick;
        let status = (20..2000).map(|round| {
            let bytes = flood(&live, round);
            live.chip.emulator.write(&bytes).unwrap();
            live.status()
        });
        let status = status
            .into_iter()
            .find(|status| status.taken != before.taken || status.state != StateCode::Running)
            .unwrap();
        println!("{name}: {} ticks after it was sent", status.tick - sent);
        assert_eq!(
            (status.state, status.cause, status.taken),
            (StateCode::Holding, 1, before.taken.wrapping_add(1)),
            "{name}"
        );
    }
}

/// A hello that ends the live session is answered. A status then reports that the drives do the safe action, and the watchdog resets the chip. After
/// that, a host can join again.
#[test]
fn a_hello_that_ends_a_live_session_is_followed_by_a_status_and_a_reset() {
    for pacing in [Pacing::DryRun, Pacing::LockStep, Pacing::Timer] {
        let mut live = LiveChip::running();
        let (chip, bench) = (&mut live.chip, live.bench);
        let theirs = Hello { pacing, ..bench };
        let greet = |chip: &mut Chip| {
            chip.send(&Frame::Hello(theirs)).unwrap();
            loop {
                match chip.receive("the chip's answer to a hello").unwrap() {
                    // Frames of the previous session.
                    Frame::Status(_) | Frame::Answer(_) | Frame::Fault(_) => {}
                    frame => break frame,
                }
            }
        };
        // While the arm is driven, no hello ends the session. After a stop it does, whoever requests the stop.
        assert_eq!(greet(chip), Frame::Refusal(Refusal::Driven), "{pacing:?}");
        chip.send(&Frame::request(200, Request::Stop)).unwrap();
        until(chip, |status| status.state == StateCode::Fault);
        assert_eq!(greet(chip), Frame::Hello(theirs), "{pacing:?}");
        match chip.receive("a status").unwrap() {
            Frame::Status(Status {
                tick: 0, state: StateCode::Idle, homed: false, actuation: Some(actuation), ..
            }) => {
                assert!(!matches!(actuation, Actuation::Drive { .. }), "{pacing:?}: {actuation:?}");
            }
            other => panic!("{pacing:?}: {other:?}"),
        }
        assert_eq!(
            chip.receive("the hello of a chip that has started anew").unwrap(),
            Frame::Hello(bench),
            "{pacing:?}"
        );
        chip.join_anew().unwrap();
        chip.change_pacing(Hello { pacing: Pacing::DryRun, ..bench }).unwrap();
    }
}

/// The chip arms by its own timer and joints. After its host falls silent, it holds and later stops, each in the stated tick.
#[test]
fn a_live_arm_whose_host_falls_silent_holds_and_then_stops_in_the_stated_ticks() {
    // The silence is counted from the tick that took the host's last frame.
    let (mut live, armed) = LiveChip::armed();
    let holds = until(&mut live.chip, |status| status.state == StateCode::Holding);
    assert_eq!((holds.tick - armed.tick, holds.cause), (live.rules.heartbeat_max + 1, 2));
    let stops = until(&mut live.chip, |status| status.state == StateCode::Fault);
    // The brakes engage before the torque ends.
    assert!(live.rules.brake_delay > 0);
    assert_eq!((stops.tick - holds.tick, stops.cause), (live.rules.hold_max + live.rules.brake_delay, 10));
}

/// Requests that arrive together: whichever ticks they fall into, the stop acts, and each request is answered once.
#[test]
fn of_requests_that_come_together_the_stop_acts_and_each_is_answered_once() {
    let mut live = LiveChip::running();
    let asked = [Request::Run, Request::Disarm, Request::Hold, Request::Stop, Request::Run, Request::Hold];
    for (number, request) in (100..).zip(asked) {
        live.chip.send(&Frame::request(number, request)).unwrap();
    }
    let (mut answers, mut stopped) = (Vec::new(), 0);
    // Some more ticks: no answer may come twice.
    while answers.len() < asked.len() || stopped < 50 {
        match live.chip.receive("answers").unwrap() {
            Frame::Answer(answer) => answers.push((answer.number, answer.verdict)),
            Frame::Status(status) if stopped > 0 || status.state == StateCode::Fault => {
                assert_eq!((status.state, status.cause), (StateCode::Fault, 9));
                assert!(!matches!(status.actuation, Some(Actuation::Drive { .. })), "{status:?}");
                stopped += 1;
            }
            Frame::Status(_) => {}
            other => panic!("{other:?}"),
        }
        assert!(stopped < 1000, "{answers:?}");
    }
    answers.sort_by_key(|(number, _)| *number);
    let numbers: Vec<u8> = answers.iter().map(|(number, _)| *number).collect();
    assert_eq!(numbers, [100, 101, 102, 103, 104, 105], "{answers:?}");
    assert_eq!(answers[3].1, Verdict::Accepted, "the stop");
    assert!(answers[4..].iter().all(|(_, verdict)| *verdict != Verdict::Accepted), "{answers:?}");
}

/// The last point has a velocity, and no other point follows: the arm holds in the tick after it.
#[test]
fn a_live_arm_whose_points_run_out_in_motion_holds() {
    let (mut live, _) = LiveChip::armed();
    let point = |ticks, q: f32, qd: f32| {
        let reference = Reference::new(&dynamics_core::Reference { q: [q, 0.0], qd: [qd, 0.0], qdd: [0.0; 2] });
        Frame::Point(Point { ticks, reference })
    };
    let (ticks, speed) = (20_u16, 0.02);
    let way = 0.5 * speed * f32::from(ticks) / live.bench.rate_hz;
    live.chip.send(&point(0, 0.0, 0.0)).unwrap();
    live.chip.send(&point(ticks, way, speed)).unwrap();
    let running = live.ask(Request::Run, |status| status.state == StateCode::Running);
    let holds = until(&mut live.chip, |status| status.state != StateCode::Running);
    assert_eq!((holds.state, holds.cause), (StateCode::Holding, 3));
    // The first tick of the run is at the first point, `ticks` later one is at the last.
    assert_eq!(holds.tick - running.tick, u32::from(ticks) + 1, "{holds:?}");
}
