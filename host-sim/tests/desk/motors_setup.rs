//! `motors setup` as a process: a person moves the joints of an arm at an adapter on a pseudo-terminal, and types.

use crate::can_adapter::Kind;
use crate::drive::file;
use crate::program::{at_the_top, new, told};
use board::can::frame::CanFrame;
use embedded_can::Frame as _;
use firmware_image::process::line_channel;
use robot_compiler::Robot;
use serialport::{SerialPort as _, TTYPort};
use std::io::{BufReader, Read as _, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// Range of the position of these motors' frames, rad.
const RANGE: f32 = 12.5;

/// Longest silence of the program: no question takes half as long to prepare.
const SILENCE: Duration = Duration::from_secs(15);

/// Motors that are off, written from the maker's documents: shaft positions (rad) of the motors 1 to 6.
#[derive(Clone, Default)]
pub(crate) struct Motors {
    shafts: Arc<Mutex<[f32; 6]>>,
    /// True if a frame came that could move a motor.
    commanded: Arc<AtomicBool>,
}

impl Motors {
    pub(crate) fn turn(&self, motor: usize, by: f32) {
        self.shafts.lock().unwrap()[motor - 1] += by;
    }

    pub(crate) fn answer(&self, frame: &CanFrame) -> Option<CanFrame> {
        let data: [u8; 8] = frame.data().try_into().ok()?;
        // The search for RobStride motors.
        if frame.is_extended() && frame.raw_id() >> 24 == 17 {
            return None;
        }
        if frame.raw_id() != 0x7FF {
            self.commanded.store(true, Ordering::Relaxed);
            return None;
        }
        let [id @ 1..=6, 0, what, register, ..] = data else { return None };
        let reply = |data: [u8; 8]| CanFrame::of(u32::from(id) + 16, false, &data);
        match (what, register) {
            (0xCC, _) => {
                let share = self.shafts.lock().unwrap()[usize::from(id) - 1] / RANGE;
                let [high, low] = (((share + 1.0) / 2.0 * 65535.0).round() as u16).to_be_bytes();
                reply([id, high, low, 0x7F, 0xF7, 0xFF, 30, 31])
            }
            (0x33, 7..=10 | 21..=23) => {
                let value = match register {
                    7 => u32::from(id) + 16,
                    8 => u32::from(id),
                    9 => 1000,
                    10 => 1,
                    21 => RANGE.to_bits(),
                    // Those of the base, shoulder and elbow are DM4340, the others DM4310.
                    22 if id > 3 => 10.0_f32.to_bits(),
                    22 => 30.0_f32.to_bits(),
                    _ if id > 3 => 28.0_f32.to_bits(),
                    _ => 10.0_f32.to_bits(),
                };
                let [a, b, c, d] = value.to_le_bytes();
                reply([id, 0, what, register, a, b, c, d])
            }
            _ => None,
        }
    }
}

/// Serves motors at a pseudo-terminal until it is dropped. `answers` gets each frame, and `None` every millisecond or so.
pub(crate) struct Served {
    pub(crate) name: String,
    ends: Arc<AtomicBool>,
}

impl Served {
    pub(crate) fn new(answers: impl Fn(Option<&CanFrame>) -> Vec<CanFrame> + Send + 'static) -> Self {
        let (mut board, host) = TTYPort::pair().unwrap();
        board.set_timeout(Duration::from_millis(1)).unwrap();
        let name = format!("slcan:{}", host.name().unwrap());
        let ends = Arc::new(AtomicBool::new(false));
        let its_end = Arc::clone(&ends);
        thread::spawn(move || {
            let _host = host;
            let (mut bytes, mut buffer) = (Vec::new(), [0; 512]);
            while !its_end.load(Ordering::Relaxed) {
                let count = board.read(&mut buffer).unwrap_or(0);
                bytes.extend(&buffer[..count]);
                let mut frames = answers(None);
                while let Some(command) = Kind::Slcan.command(&mut bytes) {
                    frames.extend(command.iter().flat_map(|frame| answers(Some(frame))));
                }
                for frame in frames {
                    board.write_all(&Kind::Slcan.report(&frame)).unwrap();
                }
            }
        });
        Self { name, ends }
    }

    pub(crate) fn of(motors: &Motors) -> Self {
        let motors = motors.clone();
        Self::new(move |frame| frame.and_then(|frame| motors.answer(frame)).into_iter().collect())
    }

    /// Exit code, output and error of a setup without a person.
    pub(crate) fn alone(&self, robot: &Path, out: &Path, more: &[&str]) -> (i32, String, String) {
        let mut program = at_the_top();
        program.args(["motors", "setup"]).arg(robot).args(["--can", &self.name, "--out"]).arg(out).args(more);
        told(program.stdin(Stdio::null()).output().unwrap())
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
    }
}

/// A setup with a person who types.
pub(crate) struct Session {
    child: Child,
    input: Option<ChildStdin>,
    output: Receiver<String>,
    pub(crate) said: String,
}

impl Session {
    pub(crate) fn new(robot: &Path, served: &Served, out: &Path) -> Self {
        Self::with(robot, served, out, &[])
    }

    /// A setup with more options.
    pub(crate) fn with(robot: &Path, served: &Served, out: &Path, more: &[&str]) -> Self {
        new(out);
        let mut program = at_the_top();
        program.args(["motors", "setup"]).arg(robot).args(["--can", &served.name, "--out"]).arg(out).args(more);
        let mut child = program.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let (input, output) = (child.stdin.take(), line_channel(BufReader::new(child.stdout.take().unwrap())));
        Self { child, input, output, said: String::new() }
    }

    /// Reads on until a line with this text.
    pub(crate) fn until(&mut self, what: &str) {
        while let Some(line) = self.next_line(what) {
            if line.contains(what) {
                return;
            }
        }
        let mut error = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut error).unwrap();
        panic!("{what}: the program ended: {}{error}", self.said);
    }

    /// The next line; `None` at the end. A program that says nothing waits for something else than the test.
    fn next_line(&mut self, what: &str) -> Option<String> {
        match self.output.recv_timeout(SILENCE) {
            Ok(line) => {
                self.said.push_str(&line);
                self.said.push('\n');
                Some(line)
            }
            Err(RecvTimeoutError::Disconnected) => None,
            Err(RecvTimeoutError::Timeout) => {
                self.child.kill().unwrap();
                panic!("{what}: the program waits: {}", self.said);
            }
        }
    }

    pub(crate) fn line(&mut self, text: &str) {
        writeln!(self.input.as_ref().unwrap(), "{text}").unwrap();
    }

    /// Ends the input. Returns the exit code, everything that was printed, and the error.
    pub(crate) fn end(mut self) -> (i32, String, String) {
        drop(self.input.take());
        while self.next_line("the end").is_some() {}
        let Self { child, said, .. } = self;
        let (code, _, error) = told(child.wait_with_output().unwrap());
        (code, said, error)
    }
}

#[test]
fn moving_the_joints_by_hand_gives_each_its_motor_its_direction_and_its_zero() {
    let (motors, out) = (Motors::default(), file("motors_setup.toml"));
    let served = Served::of(&motors);
    let mut session = Session::new(Path::new("robots/yam.toml"), &served, &out);
    // Motors are at the joints in reverse order; the third joint's turns against it.
    for joint in 1..=6_usize {
        let turn = if joint == 3 { -0.4 } else { 0.4 };
        session.until(&format!("joint {joint} of 6"));
        if joint == 2 {
            // Nothing moves, and then two at a time.
            session.line("");
            session.until("no motor moved");
            session.until("joint 2 of 6");
            motors.turn(5, 0.3);
            motors.turn(6, 0.3);
            session.line("");
            session.until("moved: motors 5, 6");
            session.until("joint 2 of 6");
        }
        if joint == 4 {
            // Let go too early, it sinks to the other side.
            motors.turn(3, 0.4);
            session.line("");
            thread::sleep(Duration::from_millis(200));
            motors.turn(3, -0.9);
            session.until("the arm moved after Enter");
            session.until("joint 4 of 6");
        }
        motors.turn(7 - joint, turn);
        session.line("");
    }
    session.until("a pose that is known");
    let known = *motors.shafts.lock().unwrap();
    session.line("z");
    session.until("to both of its ends");
    for _ in 0..10 {
        thread::sleep(Duration::from_millis(50));
        motors.turn(6, -0.5);
    }
    thread::sleep(Duration::from_millis(300));
    session.line("");
    session.until("BEYOND");
    session.until("Write the file all the same?");
    session.line("yes");
    let (code, said, error) = session.end();
    assert_eq!((code, error.as_str()), (0, ""), "{said}");
    assert!(!said.contains("model") && !said.contains("power-up"), "Damiao motors say their ranges: {said}");
    assert!(!motors.commanded.load(Ordering::Relaxed), "nothing but settings and states was asked for");
    let robot = Robot::load(&out).unwrap();
    for (joint, its) in robot.joints.iter().enumerate() {
        let drive = its.drive.unwrap().mit().unwrap();
        let motor = 6 - joint;
        assert_eq!((usize::from(drive.id), usize::from(drive.reply_id)), (motor, motor + 16), "{}", its.name);
        assert_eq!(drive.ratio < 0.0, joint == 2, "{}", its.name);
        let off = drive.zero - f64::from(known[motor - 1]);
        assert!(off.abs() < 1e-3, "{}: {} and {}", its.name, drive.zero, known[motor - 1]);
    }
}

#[test]
fn a_setup_that_ends_early_or_cannot_read_a_position_writes_nothing() {
    let motors = Motors::default();
    let served = Served::of(&motors);
    let (robot, out) = (Path::new("robots/yam.toml"), file("motors_setup_early.toml"));
    new(&out);
    let (code, _, error) = served.alone(robot, &out, &[]);
    assert!(code == 2 && error.contains("nothing was written") && !out.exists(), "{code}: {error}");
    let (code, _, error) = served.alone(robot, robot, &["--force"]);
    assert_eq!(code, 2, "{error}");
    motors.turn(2, 13.0);
    let (code, said, error) = served.alone(robot, &out, &[]);
    assert!(code != 0 && error.contains("motor 2 is at the end of the position range"), "{code}: {said}{error}");
}

#[test]
fn a_position_that_jumps_while_the_ends_are_looked_for_ends_the_setup() {
    let (motors, out) = (Motors::default(), file("motors_setup_jump.toml"));
    let served = Served::of(&motors);
    let mut session = Session::new(Path::new("robots/yam.toml"), &served, &out);
    for joint in 1..=6_usize {
        session.until(&format!("joint {joint} of 6"));
        motors.turn(joint, 0.4);
        session.line("");
    }
    session.until("a pose that is known");
    session.line("z");
    session.until("to both of its ends");
    thread::sleep(Duration::from_millis(200));
    // It was without power, and shows another turn.
    motors.turn(4, std::f32::consts::TAU);
    thread::sleep(Duration::from_millis(300));
    let (code, said, error) = session.end();
    assert!(code != 0 && error.contains("motor 4: its position jumped"), "{code}: {said}{error}");
    assert!(!out.exists());
}
