//! `motors setup` as a process: a person moves the joints of an arm at an adapter on a pseudo-terminal, and types.

use crate::can_adapter::Kind;
use crate::drive::file;
use crate::program::{at_the_top, new, told};
use board::can::frame::CanFrame;
use embedded_can::Frame as _;
use robot_compiler::Robot;
use serialport::{SerialPort as _, TTYPort};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::path::Path;
use std::process::{ChildStdin, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// Range of the position of these motors' frames, rad.
const RANGE: f32 = 12.5;

/// Motors that are off, written from the maker's documents: shaft positions (rad) of the motors 1 to 6.
#[derive(Clone, Default)]
struct Motors {
    shafts: Arc<Mutex<[f32; 6]>>,
    /// True if a frame came that could move a motor.
    commanded: Arc<AtomicBool>,
}

impl Motors {
    fn turn(&self, motor: usize, by: f32) {
        self.shafts.lock().unwrap()[motor - 1] += by;
    }

    fn answer(&self, frame: &CanFrame) -> Option<CanFrame> {
        let data: [u8; 8] = frame.data().try_into().ok()?;
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

/// Serves the motors at a pseudo-terminal. Returns its name and the end of the service.
fn served(motors: &Motors) -> (String, Arc<AtomicBool>) {
    let (mut board, host) = TTYPort::pair().unwrap();
    board.set_timeout(Duration::from_millis(1)).unwrap();
    let name = format!("slcan:{}", host.name().unwrap());
    let ends = Arc::new(AtomicBool::new(false));
    let (motors, its_end) = (motors.clone(), Arc::clone(&ends));
    thread::spawn(move || {
        let _host = host;
        let (mut bytes, mut buffer) = (Vec::new(), [0; 512]);
        while !its_end.load(Ordering::Relaxed) {
            let Ok(count) = board.read(&mut buffer) else { continue };
            bytes.extend(&buffer[..count]);
            while let Some(command) = Kind::Slcan.command(&mut bytes) {
                let reply = command.and_then(|frame| motors.answer(&frame));
                if let Some(reply) = reply {
                    board.write_all(&Kind::Slcan.report(&reply)).unwrap();
                }
            }
        }
    });
    (name, ends)
}

fn line(input: &mut ChildStdin, text: &str) {
    writeln!(input, "{text}").unwrap();
}

#[test]
fn moving_the_joints_by_hand_gives_each_its_motor_its_direction_and_its_zero() {
    let (motors, out) = (Motors::default(), file("motors_setup.toml"));
    let (name, ends) = served(&motors);
    new(&out);
    let mut program = at_the_top();
    program.args(["motors", "setup", "robots/yam.toml", "--can", &name, "--out"]).arg(&out);
    let mut child = program.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    let mut said = String::new();
    let mut until = |what: &str, said: &mut String| {
        let mut line = String::new();
        while !line.contains(what) {
            line.clear();
            assert!(output.read_line(&mut line).unwrap() > 0, "{what}: the program ended: {said}");
            said.push_str(&line);
        }
    };
    // Motors are at the joints in reverse order; the third joint's turns against it.
    for joint in 1..=6_usize {
        let turn = if joint == 3 { -0.4 } else { 0.4 };
        until(&format!("joint {joint} of 6"), &mut said);
        if joint == 2 {
            // Nothing moves, and then two at a time.
            line(&mut input, "");
            until("no motor moved", &mut said);
            until("joint 2 of 6", &mut said);
            motors.turn(5, 0.3);
            motors.turn(6, 0.3);
            line(&mut input, "");
            until("moved: motors 5, 6", &mut said);
            until("joint 2 of 6", &mut said);
        }
        motors.turn(7 - joint, turn);
        line(&mut input, "");
    }
    until("a pose that is known", &mut said);
    let known = *motors.shafts.lock().unwrap();
    line(&mut input, "z");
    until("to both of its ends", &mut said);
    thread::sleep(Duration::from_millis(200));
    motors.turn(6, -9.0);
    thread::sleep(Duration::from_millis(300));
    line(&mut input, "");
    until("BEYOND", &mut said);
    drop(input);
    let mut rest = String::new();
    output.read_to_string(&mut rest).unwrap();
    let (code, _, error) = told(child.wait_with_output().unwrap());
    ends.store(true, Ordering::Relaxed);
    assert_eq!((code, error.as_str()), (0, ""), "{said}{rest}");
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
fn a_setup_that_ends_early_writes_nothing_and_too_few_motors_are_named() {
    let motors = Motors::default();
    let (name, ends) = served(&motors);
    let out = file("motors_setup_early.toml");
    new(&out);
    let mut program = at_the_top();
    program.args(["motors", "setup", "robots/yam.toml", "--can", &name, "--out"]).arg(&out).stdin(Stdio::null());
    let (code, _, error) = told(program.output().unwrap());
    assert!(code == 2 && error.contains("nothing was written") && !Path::new(&out).exists(), "{code}: {error}");
    // An input is never overwritten.
    let mut program = at_the_top();
    program
        .args(["motors", "setup", "robots/yam.toml", "--can", &name, "--out", "robots/yam.toml", "--force"])
        .stdin(Stdio::null());
    let (code, _, error) = told(program.output().unwrap());
    assert_eq!(code, 2, "{error}");
    ends.store(true, Ordering::Relaxed);
}
