//! `motors setup` as a process, with RobStride motors.

use crate::drive::file;
use crate::motors_setup::{Motors, Served, Session};
use crate::program::new;
use board::can::frame::CanFrame;
use embedded_can::Frame as _;
use robot_compiler::Robot;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// End of the position range of their frames, rad.
const RANGE: f32 = 12.57;

/// Timeout of the motors, in units of 50 us. A zero would not show that it was overwritten.
const TIMEOUT: [u8; 4] = 12345_u32.to_le_bytes();

/// A motor, written from the maker's documents.
#[derive(Clone)]
pub(crate) struct Motor {
    id: u8,
    chip: u8,
    /// Position of its shaft, rad. It begins again at the other end of the range.
    shaft: f32,
    /// 0 off, 2 on.
    state: u32,
    /// Error bits.
    pub(crate) errors: u32,
    /// Parameter 0x700B.
    pub(crate) torque_limit: Option<f32>,
    /// Parameter 0x7029.
    power_up: Option<u8>,
}

#[derive(Default)]
pub(crate) struct Bus {
    pub(crate) motors: Vec<Motor>,
    /// Frames of another program, and replies to it.
    others: Vec<CanFrame>,
    /// Frames that could move or change a motor.
    commands: Vec<CanFrame>,
}

impl Bus {
    fn answer(&mut self, frame: &CanFrame) -> Vec<CanFrame> {
        let (id, data): (u32, [u8; 8]) = (frame.raw_id(), frame.data().try_into().unwrap());
        if !frame.is_extended() {
            return Vec::new();
        }
        let its: Vec<Motor> = self.motors.iter().filter(|motor| motor.id == id as u8).cloned().collect();
        // The motors' timeout may be written to them again.
        let is_harmless = matches!(id >> 24, 0 | 17) || id >> 24 == 18 && data == [0x28, 0x70, 0, 0, 0x39, 0x30, 0, 0];
        if !is_harmless {
            self.commands.push(*frame);
        }
        its.iter().filter_map(|motor| motor.answer(id, data)).collect()
    }
}

impl Motor {
    fn answer(&self, id: u32, data: [u8; 8]) -> Option<CanFrame> {
        let (own, host) = (u32::from(self.id), id >> 8 & 0xFF);
        match id >> 24 {
            0 => CanFrame::of(own << 8 | 0xFE, true, &[self.chip; 8]),
            17 => {
                let value = match u16::from_le_bytes([data[0], data[1]]) {
                    0x700B => self.torque_limit.map(f32::to_le_bytes),
                    0x7019 => Some(self.shaft.to_le_bytes()),
                    0x7028 => Some(TIMEOUT),
                    0x7029 => self.power_up.map(|it| [it, 7, 7, 7]),
                    _ => None,
                };
                let (failed, [a, b, c, d]) = value.map_or((1, [0; 4]), |value| (0, value));
                CanFrame::of(17 << 24 | failed << 16 | own << 8 | host, true, &[data[0], data[1], 0, 0, a, b, c, d])
            }
            18 => {
                let [high, low] = (((self.shaft / RANGE + 1.0) / 2.0 * 65535.0).round() as u16).to_be_bytes();
                let id = 2 << 24 | self.state << 22 | self.errors << 16 | own << 8 | host;
                CanFrame::of(id, true, &[high, low, 0x80, 0, 0x80, 0, 0, 0xFB])
            }
            _ => None,
        }
    }
}

/// Six motors: those of the base, shoulder and elbow are RS06, the others RS00.
pub(crate) fn bus() -> Arc<Mutex<Bus>> {
    let motor = |id: u8| Motor {
        id,
        chip: id,
        shaft: 0.0,
        state: 0,
        errors: 0,
        torque_limit: Some(if id <= 3 { 36.0 } else { 14.0 }),
        power_up: Some(1),
    };
    Arc::new(Mutex::new(Bus { motors: (1..=6).map(motor).collect(), ..Bus::default() }))
}

pub(crate) fn served(bus: &Arc<Mutex<Bus>>) -> Served {
    let bus = Arc::clone(bus);
    Served::new(move |frame| {
        let mut bus = bus.lock().unwrap();
        match frame {
            Some(frame) => bus.answer(frame),
            None => bus.others.clone(),
        }
    })
}

pub(crate) fn turn(bus: &Mutex<Bus>, motor: usize, by: f32) {
    let shaft = &mut bus.lock().unwrap().motors[motor - 1].shaft;
    *shaft = (*shaft + by + RANGE).rem_euclid(2.0 * RANGE) - RANGE;
}

/// The reBot without its drives.
fn without_drives(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/rebot_b601_rs.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let mut is_drive = false;
    let kept: Vec<&str> = text
        .lines()
        .filter(|line| {
            is_drive = *line == "[joint.drive]" || is_drive && !line.is_empty();
            !is_drive
        })
        .collect();
    let path = file(name);
    std::fs::write(&path, kept.join("\n")).unwrap();
    path
}

/// Motors of the joints.
const ORDER: [usize; 6] = [1, 3, 2, 5, 4, 6];

/// Models of the motors, as a person types them.
const SIX: [&str; 6] = ["RS06", "rs06", "RS06", "RS00", "RS00", "12.5 30 14 500 5"];

#[test]
fn moving_the_joints_finds_robstride_motors_and_asks_for_their_models() {
    let (bus, out) = (bus(), file("motors_setup_robstride.toml"));
    {
        let motors = &mut bus.lock().unwrap().motors;
        (motors[0].power_up, motors[1].power_up, motors[2].shaft) = (Some(0), None, 12.45);
    }
    let served = served(&bus);
    let mut session = Session::new(&without_drives("motors_setup_robstride_arm.toml"), &served, &out);
    // Some motors are at each other's joints; the third joint's turns against it.
    for (joint, motor) in (1..).zip(ORDER) {
        session.until(&format!("joint {joint} of 6"));
        if joint == 2 {
            // The position begins again at the other end of the range: it seems to turn by -24.7 rad.
            turn(&bus, motor, 0.4);
            session.line("");
            session.until("the position of motor 3 jumped");
            session.until("joint 2 of 6");
        }
        turn(&bus, motor, if joint == 3 { -0.4 } else { 0.4 });
        session.line("");
        session.until(&format!("model of motor {motor}, as on its label: RS00, RS06"));
        if joint == 1 {
            session.line("RS99");
            session.until("model of motor 1");
        }
        if joint == 6 {
            session.line("RS06");
            session.until("the frames of RS06 have 36 N m, and the torque limit of motor 6 is 14 N m");
            session.until("model of motor 6");
        }
        if joint == 2 {
            // It contradicts the motor, and then the joint.
            for what in ["the torque limit of motor 3 is 36 N m", "the limits of shoulder are 36 N m and 3 rad/s"] {
                session.line("RS00");
                session.until(what);
                session.until("model of motor 3");
            }
        }
        session.line(SIX[motor - 1]);
    }
    session.until("a pose that is known");
    let zeros = [0.0, -0.1, -1.7, 0.1, 1.5, 0.5];
    for (motor, zero) in bus.lock().unwrap().motors.iter_mut().zip(zeros) {
        motor.shaft = zero;
    }
    session.line("z");
    let base = "base: motor 1 is at -2.80 to 2.80 rad between the joint's limits, and after power-up it shows 0.00 to 6.28 rad";
    session.until(base);
    session.until("elbow: motor 2 does not say which turn");
    session.until("wrist_roll: motor 6 is at -2.64 to 3.64 rad");
    session.until("to both of its ends");
    session.line("");
    let (code, said, error) = session.end();
    assert_eq!((code, error.as_str()), (0, ""), "{said}");
    let silent = ["shoulder: motor 3 is", "wrist_pitch: motor 5 is", "wrist_yaw: motor 4 is"];
    assert!(!silent.iter().any(|joint| said.contains(joint)), "these are within one turn: {said}");
    assert_eq!(bus.lock().unwrap().commands, []);
    let robot = Robot::load(&out).unwrap();
    for ((joint, its), motor) in (1..).zip(&robot.joints).zip(ORDER) {
        let drive = its.drive.unwrap().mit().unwrap();
        assert_eq!((its.drive.unwrap().kind(), drive.bus, drive.reply_id), ("robstride", 1, 0xFD));
        assert_eq!((usize::from(drive.id), drive.ratio < 0.0), (motor, joint == 3), "{}", its.name);
        let (torque, position) = (if motor <= 3 { 36.0 } else { 14.0 }, if motor == 6 { 12.5 } else { 12.57 });
        assert_eq!((drive.torque, drive.position), ((-torque, torque), (-position, position)));
        // The position in a frame is a share of the range that was typed.
        let zero = f64::from(zeros[motor - 1] / RANGE) * position;
        assert!((drive.zero - zero).abs() < 1e-3, "{}: {} and {zero}", its.name, drive.zero);
    }
}

#[test]
fn models_of_the_robot_file_are_kept_unless_a_motor_contradicts_them() {
    let (bus, out) = (bus(), file("motors_setup_robstride_kept.toml"));
    bus.lock().unwrap().motors[3].torque_limit = Some(36.0);
    let served = served(&bus);
    let mut session = Session::new(Path::new("robots/rebot_b601_rs.toml"), &served, &out);
    for joint in 1..=6 {
        session.until(&format!("joint {joint} of 6"));
        turn(&bus, joint, 0.4);
        session.line("");
        if joint == 4 {
            session.until("the frames of the robot file have 14 N m, and the torque limit of motor 4 is 36 N m");
            session.line("RS06");
        }
    }
    session.until("a pose that is known");
    session.line("r");
    session.until("to both of its ends");
    session.line("");
    let (code, said, error) = session.end();
    assert_eq!((code, error.as_str()), (0, ""), "{said}");
    assert_eq!(said.matches("model of motor").count(), 1, "{said}");
    let text = std::fs::read_to_string(out).unwrap();
    assert_eq!((text.matches("\"RS06\"").count(), text.matches("\"RS00\"").count()), (4, 2), "{text}");
}

#[test]
fn robstride_motors_that_are_on_used_or_not_told_apart_are_rejected() {
    let rebot = Path::new("robots/rebot_b601_rs.toml");
    let out = file("motors_setup_robstride_bad.toml");
    new(&out);
    let rejected = |change: &dyn Fn(&mut Bus), text: &str| {
        let bus = bus();
        change(&mut bus.lock().unwrap());
        let (code, said, error) = served(&bus).alone(rebot, &out, &[]);
        assert!(code != 0 && error.replace("\n  │ ", " ").contains(text), "{text}: {said}{error}");
        assert!(said.is_empty() && !out.exists(), "{said}");
        assert_eq!(bus.lock().unwrap().commands, []);
    };
    rejected(&|bus| bus.motors[2].state = 2, "motor 3 is on: expected motors that are off");
    rejected(&|bus| bus.motors[5].id = 5, "2 RobStride motors have the identifier 5");
    rejected(&|bus| bus.motors.truncate(5), "5 motors answer");
    let reply = CanFrame::of(2 << 24 | 4 << 8 | 0xFE, true, &[0x90, 0, 0x80, 0, 0x80, 0, 1, 0x2C]).unwrap();
    rejected(&|bus| bus.others = vec![reply], "motor 4 is off; another program uses it");
}

#[test]
fn motors_of_two_kinds_need_a_choice_that_the_robot_file_does_not_contradict() {
    let (robstride, damiao) = (bus(), Motors::default());
    let served = {
        let (robstride, damiao) = (Arc::clone(&robstride), damiao);
        Served::new(move |frame| {
            let Some(frame) = frame else { return Vec::new() };
            let mut answers = robstride.lock().unwrap().answer(frame);
            answers.extend(damiao.answer(frame));
            answers
        })
    };
    let out = file("motors_setup_two_kinds.toml");
    new(&out);
    let setup = |robot: &str, more: &[&str]| {
        let (code, said, error) = served.alone(Path::new(robot), &out, more);
        assert!(code != 0 && !out.exists());
        (said, error.replace("\n  │ ", " "))
    };
    let (said, error) = setup("robots/yam.toml", &[]);
    assert!(
        error.contains("damiao motors (1, 2, 3, 4, 5, 6) and robstride motors (1, 2, 3, 4, 5, 6) answer"),
        "{error}"
    );
    assert!(said.is_empty() && error.contains("--kind robstride"), "{error}");
    for (robot, kind) in [("robots/yam.toml", "damiao"), ("robots/rebot_b601_rs.toml", "robstride")] {
        let (said, error) = setup(robot, &["--kind", kind]);
        assert!(said.contains("joint 1 of 6") && error.contains("the input ended"), "{said}{error}");
    }
    let (said, error) = setup("robots/yam.toml", &["--kind", "robstride"]);
    assert!(said.is_empty() && error.contains("kind damiao in the file, and robstride motors on the bus"), "{error}");
}
