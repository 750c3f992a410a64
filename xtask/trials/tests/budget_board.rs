//! `chip-budget board` against the firmware's own session at the other end of a pseudo-terminal, with a scripted counter.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use ::board::session::dry_run::{Uncounted, desk_session};
use link::{Access, BoardChannel, Cost, Fault, Frame, Pacing, Refusal};
use robot_compiler::SceneFile;
use serde_json::Value;
use serialport::{SerialPort as _, TTYPort};
use session::Reaction;
use session::black_box::Report;
use session::meter::{Counter, Meter};
use std::cell::Cell;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

const SCENE: &str = "planar2r_swing.toml";
const TICKS: u32 = 120;

fn path(scene: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(scene)
}

/// Number of readings in the firmware's test of its counter, and the cost of each.
const TRIAL: u32 = 14;
const READING: u32 = 2;

/// A counter that soon wraps around, and advances as the script gives for each tick. From the first tick without a count, it stops.
struct Scripted<const CYCLES: bool> {
    count: Cell<u32>,
    readings: Cell<u32>,
    work: fn(u32) -> Option<u32>,
}

impl<const CYCLES: bool> Scripted<CYCLES> {
    fn new(work: fn(u32) -> Option<u32>) -> Self {
        Self { count: Cell::new(u32::MAX - 2_000), readings: Cell::new(0), work }
    }
}

impl<const CYCLES: bool> Counter for Scripted<CYCLES> {
    fn now(&self) -> u32 {
        let before = self.readings.replace(self.readings.get() + 1);
        let step = match before.checked_sub(TRIAL) {
            None => Some(READING),
            // Two readings per tick, with the work before the second.
            Some(in_tick) => (self.work)(in_tick / 2).map(|work| READING + if in_tick % 2 == 1 { work } else { 0 }),
        };
        self.count.set(self.count.get().wrapping_add(step.unwrap_or(0)));
        self.count.get()
    }

    fn cost(count: u32) -> Cost {
        if CYCLES { Cost::Cycles(count) } else { Cost::Instructions(count) }
    }

    fn exercise(&self) {
        self.count.set(self.count.get().wrapping_add(100));
    }
}

/// Counts that differ in every tick and exceed the emulator's instructions.
fn as_a_chip(tick: u32) -> Option<u32> {
    Some(2_000 + tick * 79 % 101)
}

/// Answer to a tick, as the host receives it.
#[allow(clippy::large_enum_variant, reason = "made and taken apart at once")]
enum LinkInterrupts {
    Says(Frame),
    Bytes(Vec<u8>),
    Silent,
    Unplugged,
}

/// Locked while a terminal is created, and while a program is started: a program that inherits the board's end would keep it open.
static INHERITING: Mutex<()> = Mutex::new(());

/// The board's end of a terminal, and the name of the other end.
fn terminal() -> (TTYPort, String) {
    let _alone = INHERITING.lock().unwrap();
    let (board, host) = TTYPort::pair().unwrap();
    // Started programs do not inherit the copy. The host's own end is closed, because it holds the lock that excludes other users.
    (board.try_clone_native().unwrap(), host.name().unwrap())
}

/// A simulated board; dropping it ends its thread.
struct Board {
    port: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Board {
    /// Starts a board with the firmware of a scene. `way` receives each answer and the number of its tick.
    fn start<const N: usize, M: Counter + Send + 'static>(
        scene: &str,
        counter: M,
        way: impl FnMut(u32, Frame) -> LinkInterrupts + Send + 'static,
    ) -> Self {
        let scene = SceneFile::load(&path(scene)).unwrap();
        let (mut firmware, port) = terminal();
        firmware.set_timeout(Duration::from_millis(20)).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let thread = std::thread::spawn(move || run::<N, M>(&scene, firmware, counter, &flag, way));
        Self { port, stop, thread: Some(thread) }
    }

    fn counting(work: fn(u32) -> Option<u32>) -> Self {
        Self::start::<2, _>(SCENE, Scripted::<true>::new(work), |_, frame| LinkInterrupts::Says(frame))
    }

    fn on_the_way(way: impl FnMut(u32, Frame) -> LinkInterrupts + Send + 'static) -> Self {
        Self::start::<2, _>(SCENE, Scripted::<true>::new(as_a_chip), way)
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let ended = thread.join();
            assert!(ended.is_ok() || std::thread::panicking(), "the board failed");
        }
    }
}

/// Connects session, counter and link as the firmware's program does.
fn run<const N: usize, M: Counter>(
    scene: &SceneFile,
    mut port: TTYPort,
    counter: M,
    stop: &AtomicBool,
    mut way: impl FnMut(u32, Frame) -> LinkInterrupts,
) {
    let mut session = desk_session::<N>(scene, &scene.robot.model::<N>().unwrap());
    let meter = Meter::new(counter);
    // Bench mode, on a board without a key.
    let (mut channel, mut bytes) = (BoardChannel::new(Access::NoKey), [0; 512]);
    let own = ::board::chip::hello(scene, &scene.robot.model::<N>().unwrap(), Pacing::LockStep);
    while !stop.load(Ordering::Relaxed) {
        let Ok(count) = port.read(&mut bytes) else {
            // Nothing has arrived, or the other end is closed and the read returns at once.
            std::thread::sleep(Duration::from_millis(1));
            continue;
        };
        for byte in &bytes[..count] {
            let Some(received) = channel.push(*byte, &own, &mut || None, &mut |bytes| port.write_all(bytes).unwrap())
            else {
                continue;
            };
            let answers = match session.receive(received) {
                Reaction::Tick => {
                    session.tick(&meter);
                    std::iter::from_fn(|| session.say()).map(Report::frame).collect()
                }
                Reaction::Reply(frame) | Reaction::Start(_, frame) | Reaction::Resume(frame) => vec![frame],
                Reaction::Stop(hello, refusal) => vec![hello, refusal],
                Reaction::None => Vec::new(),
            };
            for frame in answers {
                let said = match frame {
                    Frame::Command(command) => way(command.tick, Frame::Command(command)),
                    other => LinkInterrupts::Says(other),
                };
                let said = match said {
                    LinkInterrupts::Says(frame) => {
                        let mut said = Vec::new();
                        channel.send(&frame, &mut |bytes| said.extend_from_slice(bytes));
                        said
                    }
                    LinkInterrupts::Bytes(bytes) => bytes,
                    LinkInterrupts::Silent => Vec::new(),
                    LinkInterrupts::Unplugged => return,
                };
                // Writing fails if the host has closed the port.
                port.write_all(&said).ok();
            }
        }
    }
}

/// Exit code, report, and error message.
fn measured(port: &str, scene: &str, more: &[&str]) -> (i32, Value, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chip-budget"));
    command.args(["board", "--port", port, "--ticks", &TICKS.to_string(), "--scene"]).arg(path(scene)).args(more);
    let started = {
        let _alone = INHERITING.lock().unwrap();
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let output = started.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let (printed, error) = (text(output.stdout), text(output.stderr));
    let report = if printed.is_empty() { Value::Null } else { serde_json::from_str(&printed).unwrap() };
    (output.status.code().unwrap(), report, error)
}

/// Exit code and error message, if there is no report.
fn refused(board: &Board, more: &[&str]) -> (i32, String) {
    let (code, report, error) = measured(&board.port, SCENE, more);
    assert!(report.is_null(), "{report}");
    (code, error)
}

#[test]
fn every_ticks_cycles_count_in_fewest_most_and_mean() {
    let board = Board::counting(as_a_chip);
    let counts: Vec<u32> = (0..TICKS).filter_map(as_a_chip).collect();
    let (code, report, error) = measured(&board.port, SCENE, &["--instructions", "2000"]);
    assert_eq!((code, error.as_str()), (0, ""));
    let cycles = &report["cycles_per_tick"];
    assert_eq!(cycles["min"].as_u64(), counts.iter().min().map(|min| u64::from(*min)));
    assert_eq!(cycles["max"].as_u64(), counts.iter().max().map(|max| u64::from(*max)));
    let mean = f64::from(counts.iter().sum::<u32>()) / f64::from(TICKS);
    assert!((cycles["mean"].as_f64().unwrap() - mean).abs() < 1e-9, "{cycles} and {mean}");
    assert_eq!((report["ticks"].as_u64(), report["bits_differ"].as_u64()), (Some(u64::from(TICKS)), Some(0)));
    let scene = SceneFile::load(&path(SCENE)).unwrap();
    let hash = format!("{:016x}", scene.hash(&scene.robot.model::<2>().unwrap()));
    assert_eq!((report["hash"].as_str(), report["rate_hz"].as_f64()), (Some(hash.as_str()), Some(scene.control.rate)));
}

#[test]
fn a_port_that_another_program_has_had_gives_the_same() {
    // The packet numbers of an earlier user continue, and the last answers to that user may still arrive.
    let board = Board::start::<6, _>("puma560_pick.toml", Scripted::<true>::new(|_| Some(2_805)), |_, frame| {
        LinkInterrupts::Says(frame)
    });
    let of = |(code, report, error): (i32, Value, String)| {
        assert_eq!(code, 0, "{error}");
        (report["cycles_per_tick"]["min"].as_u64(), report["cycles_per_tick"]["max"].as_u64())
    };
    for _ in 0..2 {
        assert_eq!(of(measured(&board.port, "puma560_pick.toml", &[])), (Some(2_805), Some(2_805)));
    }
}

#[test]
fn a_counter_that_counts_no_cycles_is_refused_with_what_to_look_for() {
    let says = |_, frame| LinkInterrupts::Says(frame);
    let cases: [(&str, Board, &[&str], [&str; 2]); 5] = [
        ("never counted", Board::start::<2, _>(SCENE, Uncounted, says), &[], ["tick 1 has no cost", "TRCENA"]),
        (
            "stops later",
            Board::counting(|tick| (tick < 40).then_some(2_000)),
            &[],
            ["tick 41 took -2 cycles", "TRCENA"],
        ),
        ("zero", Board::counting(|_| Some(0)), &[], ["tick 1 took 0 cycles: the counter stands still", "TRCENA"]),
        (
            "one value that cannot be",
            Board::counting(|_| Some(300)),
            &["--instructions", "301"],
            ["tick 1 took 300 cycles, and the emulator counts at least 301 instructions", "TRCENA"],
        ),
        (
            "an emulator",
            Board::start::<2, _>(SCENE, Scripted::<false>::new(as_a_chip), says),
            &[],
            ["tick 1 is counted in instructions, not in cycles", "without --port"],
        ),
    ];
    for (name, board, more, expected) in cases {
        let (code, error) = refused(&board, more);
        assert_eq!(code, 2, "{name}: {error}");
        assert!(expected.iter().all(|part| error.contains(part)), "{name}: {error}");
    }
}

#[test]
fn one_bit_that_is_not_the_desks_is_told_with_its_tick() {
    let board = Board::on_the_way(|tick, frame| match frame {
        Frame::Command(mut command) if tick == 17 || tick == 90 => {
            command.torque[1] = f32::from_bits(command.torque[1].to_bits() ^ 1);
            LinkInterrupts::Says(Frame::Command(command))
        }
        other => LinkInterrupts::Says(other),
    });
    let (code, error) = refused(&board, &[]);
    assert_eq!(code, 1, "{error}");
    assert!(error.contains(&format!("2 of {TICKS} ticks differ from the desk in some bit, tick 17 first")), "{error}");
}

#[test]
fn a_board_that_fails_meanwhile_ends_the_measurement_with_code_1() {
    type OnItsWay = fn(u32, Frame) -> LinkInterrupts;
    let cases: [(OnItsWay, &str); 6] = [
        (
            |tick, frame| if tick < 9 { LinkInterrupts::Says(frame) } else { LinkInterrupts::Unplugged },
            "the other end is gone",
        ),
        (
            |tick, frame| if tick < 9 { LinkInterrupts::Says(frame) } else { LinkInterrupts::Silent },
            "silent: the answer to a measurement did not come within 3s",
        ),
        (
            |tick, frame| if tick < 9 { LinkInterrupts::Says(frame) } else { LinkInterrupts::Bytes(vec![3, 7, 7, 0]) },
            "from the board: ",
        ),
        (
            |_, _| LinkInterrupts::Says(Frame::Refusal(Refusal::NoReference)),
            "refused: a measurement came before any reference",
        ),
        (
            |tick, frame| {
                if tick < 9 {
                    LinkInterrupts::Says(frame)
                } else {
                    LinkInterrupts::Says(Frame::Fault(Fault { tick, code: 6, joint: None }))
                }
            },
            "a torque in tick 9: the board brakes, ",
        ),
        (
            |tick, frame| match frame {
                Frame::Command(command) if tick == 9 => {
                    LinkInterrupts::Says(Frame::Command(link::Command { tick: 8, ..command }))
                }
                other => LinkInterrupts::Says(other),
            },
            "answered tick 8, expected 9",
        ),
    ];
    for (way, expected) in cases {
        let (code, error) = refused(&Board::on_the_way(way), &[]);
        assert!(code == 1 && error.contains(expected), "{code}: {error}");
    }
}

#[test]
fn a_port_without_this_scenes_firmware_is_refused_before_the_first_tick() {
    let other = Board::start::<2, _>("planar2r_sine.toml", Uncounted, |_, _| panic!("a tick was asked for"));
    let (code, error) = refused(&other, &[]);
    assert_eq!(code, 2, "{error}");
    assert!(error.contains("the firmware has hash") && error.contains("flash this scene"), "{error}");

    let (silent, port) = terminal();
    for (port, expected) in [
        (port.as_str(), ["does not answer", "is the board powered and flashed"]),
        ("/dev/no-such-port", ["serial port /dev/no-such-port", "is it plugged in"]),
    ] {
        let (code, report, error) = measured(port, SCENE, &[]);
        assert!(code == 2 && report.is_null(), "{code}: {error}");
        assert!(expected.iter().all(|part| error.contains(part)), "{error}");
    }
    drop(silent);
}

#[test]
fn a_scene_that_is_not_there_is_named() {
    let (code, report, error) = measured("/dev/no-such-port", "nowhere.toml", &[]);
    assert!(code == 2 && report.is_null() && error.contains("nowhere.toml"), "{code}: {error}");
}
