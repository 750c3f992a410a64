//! A live session with every possible event of a board is generated here. Its replay has the same bits, and any change is found.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

use super::{Replay, ReplayError, replay};
use crate::chip::hello;
use crate::session::dry_run::{Uncounted, desk_session};
use crate::session::frame_log::{Direction, Entry};
use dynamics_core::{Model, Sensed};
use link::codec::Received;
use link::{Actuation, Frame, Hello, Pacing, Parts, Point, Request, StateCode, Watch};
use robot_compiler::SceneFile;
use session::black_box::Report;
use session::meter::Meter;
use session::readings::Lines;
use session::readings::{JointFaults, Readings};
use session::{Drives, Reaction};
use std::path::Path;
use std::time::Duration;

const N: usize = 2;

fn scene() -> (SceneFile, Model<f64, N>) {
    let scene =
        SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/planar2r_swing.toml")).unwrap();
    let model = scene.robot.model::<N>().unwrap();
    (scene, model)
}

fn entry(way: Direction, frame: Frame) -> Entry {
    Entry { way, missed: 0, at: Duration::ZERO, frame }
}

/// Events of a tick on the board.
#[derive(Clone, Copy)]
struct Happens {
    tick: u32,
    asked: Option<Request>,
    faults: [JointFaults; N],
    lines: Lines,
    overrun: bool,
}

/// A session of 300 ticks with these events: armed in tick 3, running from tick 10 on. The arm is almost exactly at its reference.
fn session(happens: &[Happens], has_joints: bool) -> Vec<Entry> {
    let (scene, model) = scene();
    let mut board = desk_session(&scene, &model);
    let mut entries = Vec::new();
    let meter = Meter::new(Uncounted);
    let q = [-1.57_f32, 0.0];
    let point = |ticks, x: f32| {
        let at = dynamics_core::Reference::at_rest(q.map(|q| q + x));
        Frame::Point(Point { ticks, reference: link::Reference::new(&at) })
    };
    for tick in 1..=300 {
        let now = happens.iter().find(|happens| happens.tick == tick);
        let mut frames = match tick {
            1 => {
                let watch = Watch { every: 1, parts: Parts::SENSED.and(Parts::TORQUE) };
                let live = link::Live::new(&scene.live(&model).cast::<f32>()).unwrap();
                let hello = hello(&scene, &model, Pacing::Live);
                vec![Frame::Hello(hello), Frame::Watch(watch), Frame::Live(live), Frame::request(1, Request::Home)]
            }
            2 => vec![Frame::request(2, Request::Confirm)],
            3 => vec![Frame::request(3, Request::Arm)],
            // The second start is refused.
            10 => vec![point(0, 0.0), point(200, 0.05), Frame::request(4, Request::Run)],
            11 => vec![point(0, 0.0)],
            tick if tick % 7 == 0 => vec![Frame::Alive],
            _ => Vec::new(),
        };
        frames.extend(now.and_then(|now| now.asked).map(|request| Frame::request(tick as u8, request)));
        for frame in frames {
            entries.push(entry(Direction::Sent, frame.clone()));
            match board.receive(Ok(Received { frame, missed: 0 })) {
                Reaction::None => {}
                Reaction::Start(_, frame) | Reaction::Resume(frame) | Reaction::Reply(frame) => {
                    entries.push(entry(Direction::Received, frame))
                }
                other => panic!("{other:?}"),
            }
        }
        let wobble = 1e-4 * (tick as f32 * 0.3).sin();
        let readings = Readings {
            sensed: Sensed::State { q: q.map(|q| q + wobble), qd: [0.0; N] },
            torque: [0.0; N],
            age_ticks: [tick % 2, 0],
            faults: now.map_or([JointFaults::NONE; N], |now| now.faults),
            errors: [0; N],
            on: [true; N],
            zero_lost: false,
        };
        board.sense(has_joints.then_some(&readings), &now.map_or(Lines::NONE, |now| now.lines));
        if now.is_some_and(|now| now.overrun) {
            board.overrun();
        }
        let drives = board.tick(&meter);
        assert!(has_joints || matches!(drives, Drives::Safe(_)));
        let said: Vec<Frame> = std::iter::from_fn(|| board.say()).map(Report::frame).collect();
        entries.extend(said.into_iter().map(|frame| entry(Direction::Received, frame)));
    }
    entries
}

const QUIET: Happens =
    Happens { tick: 0, asked: None, faults: [JointFaults::NONE; N], lines: Lines::NONE, overrun: false };

/// A session with every event that ends in a fault, each fault cleared again.
fn eventful() -> Vec<Entry> {
    let (none, drive, lost) = (JointFaults::NONE, JointFaults::DRIVE, JointFaults::LOST);
    let clear = |tick| Happens { tick, asked: Some(Request::Clear), ..QUIET };
    let arm = |tick| Happens { tick, asked: Some(Request::Arm), ..QUIET };
    let measured = Lines { supply: Some(24.0), temperature: Some(31.5), ..Lines::NONE };
    session(
        &[
            Happens { tick: 40, lines: measured, ..QUIET },
            Happens { tick: 50, faults: [none, drive], ..QUIET },
            clear(52),
            arm(53),
            Happens { tick: 60, overrun: true, ..QUIET },
            clear(62),
            arm(63),
            Happens { tick: 70, lines: Lines { emergency_stop: true, ..Lines::NONE }, ..QUIET },
            clear(72),
            arm(73),
            Happens { tick: 80, lines: Lines { supply: Some(f32::NAN), ..Lines::NONE }, ..QUIET },
            clear(82),
            arm(83),
            Happens { tick: 90, faults: [lost, none], ..QUIET },
            clear(92),
            arm(93),
        ],
        true,
    )
}

fn again(entries: &[Entry]) -> Replay {
    let (scene, model) = scene();
    replay(&scene, &model, entries.iter().cloned().map(Ok)).unwrap()
}

/// Index of the entry with the status of a tick, and the status.
fn of_tick(entries: &mut [Entry], tick: u32) -> (usize, &mut link::Status) {
    let found = entries.iter_mut().enumerate().find_map(|(index, entry)| match &mut entry.frame {
        Frame::Status(status) if status.tick == tick => Some((index, status)),
        _ => None,
    });
    found.unwrap()
}

#[test]
fn whatever_happened_to_a_board_happens_again_with_the_same_bits() {
    let mut entries = eventful();
    for (tick, cause) in [(50, 11), (60, 6), (70, 9), (80, 12), (90, 11)] {
        assert_eq!(of_tick(&mut entries, tick).1.cause, cause, "tick {tick}");
    }
    let drove = |entry: &&Entry| matches!(&entry.frame, Frame::Status(s) if matches!(s.actuation, Some(Actuation::Drive { .. })));
    assert!(entries.iter().filter(drove).count() > 200);
    let same = again(&entries);
    assert_eq!((same.ticks, same.differences, &same.end), (300, 0, &None), "{same:?}");
    assert!(same.is_the_same());
}

#[test]
fn a_board_without_joints_is_replayed_too() {
    let same = again(&session(&[], false));
    assert_eq!((same.ticks, same.differences), (300, 0), "{same:?}");
}

#[test]
fn one_bit_is_found_in_its_tick_with_both_values() {
    let mut entries = eventful();
    let (_, status) = of_tick(&mut entries, 30);
    let Some(Actuation::Drive { torque, .. }) = &mut status.actuation else { panic!("no torque in tick 30") };
    let before = torque[1];
    torque[1] = f32::from_bits(before.to_bits() ^ 1);
    let other = again(&entries);
    let first = other.first.unwrap();
    assert_eq!((other.differences, first.tick, first.field.as_str()), (1, 30, "actuation"));
    assert!(first.replayed.contains(&format!("{:#010x}", before.to_bits())), "{first:?}");
    assert!(first.recorded.contains(&format!("{:#010x}", before.to_bits() ^ 1)), "{first:?}");
}

#[test]
fn every_other_field_of_a_status_is_compared() {
    type Change = (&'static str, fn(&mut link::Status));
    let changes: [Change; 6] = [
        ("state", |status| status.state = StateCode::Idle),
        ("cause", |status| status.cause = 1),
        ("joint", |status| status.joint = Some(0)),
        ("homed", |status| status.homed = false),
        ("refused", |status| status.refused = Some(link::Denial { code: 1, fault: 0, joint: None, input: 0 })),
        ("reference", |status| {
            let at = dynamics_core::Reference::at_rest([0.0_f32; N]);
            status.extra = link::ExtraFields::Reference(link::Reference::new(&at));
        }),
    ];
    for (field, change) in changes {
        let mut entries = eventful();
        change(of_tick(&mut entries, 30).1);
        let first = again(&entries).first.unwrap();
        assert_eq!((first.tick, first.field.as_str()), (30, field));
    }
}

#[test]
fn a_tick_whose_status_is_missing_is_named_and_nothing_behind_it_is_replayed() {
    let mut entries = eventful();
    let (index, _) = of_tick(&mut entries, 100);
    entries.remove(index);
    let cut = again(&entries);
    let end = cut.end.unwrap();
    assert_eq!((cut.ticks, cut.differences, end.tick), (99, 0, 100));
    assert_eq!(end.why, "its status is missing; the next one is that of tick 101");
}

#[test]
fn a_status_that_says_too_little_or_frames_that_did_not_arrive_end_a_replay() {
    let mut entries = eventful();
    of_tick(&mut entries, 100).1.sensed = None;
    let end = again(&entries).end.unwrap();
    assert_eq!((end.tick, end.why.as_str()), (100, "its status does not say what was sensed, or what the drives did"));

    let mut entries = eventful();
    let lost = entry(Direction::Received, Frame::Refusal(link::Refusal::Lost { missed: 2 }));
    let (index, _) = of_tick(&mut entries, 100);
    entries.insert(index, lost);
    let end = again(&entries).end.unwrap();
    assert_eq!((end.tick, end.why.as_str()), (100, "what was sent did not all arrive: Lost { missed: 2 }"));

    let mut entries = eventful();
    let (_, status) = of_tick(&mut entries, 100);
    status.taken += 1;
    assert!(again(&entries).end.is_some_and(|end| end.why.starts_with("it had taken")));
}

#[test]
fn what_another_session_left_on_the_line_is_not_replayed() {
    let mut entries = eventful();
    let (index, _) = of_tick(&mut entries, 200);
    let stray = entries[index].clone();
    // Insert it before the hello, and between the hello and its answer.
    entries.insert(1, stray.clone());
    entries.insert(0, stray);
    assert!(again(&entries).is_the_same());
}

#[test]
fn a_record_of_something_else_is_refused() {
    let (scene, model) = scene();
    let bench = Hello { pacing: Pacing::LockStep, ..hello(&scene, &model, Pacing::DryRun) };
    for frames in [vec![], vec![Frame::Alive], vec![Frame::Hello(bench)]] {
        let entries = frames.into_iter().map(|frame| Ok(entry(Direction::Sent, frame)));
        assert_eq!(replay(&scene, &model, entries).unwrap_err(), ReplayError::NoHello(1));
    }
}
