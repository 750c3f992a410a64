//! Settings of simulated RobStride motors.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::super::frame::CanFrame;
use super::super::motor::{MotorReport, motor_with};
use super::super::motors::Value;
use super::super::robstride_parameter::POSITION;
use super::RobStrideMotor;
use super::simulated_bus::{Bus, Motor, OLD, bus, kinds};

fn show(bus: &mut Bus, id: u8) -> MotorReport {
    motor_with(bus, id, None).unwrap().report().unwrap()
}

fn stored(motor: &Motor) -> u32 {
    u32::from_le_bytes(motor.flash.1[&0x7028])
}

#[test]
fn a_motor_is_shown_by_frames_that_change_nothing() {
    let mut bus = bus(&[3, 4]);
    bus.motors[0].errors = 0b100;
    let before = bus.motors[0].clone();
    let report = show(&mut bus, 3);
    assert_eq!((report.state.as_str(), report.temperatures.as_slice()), ("off; too hot", [("motor", 25.1)].as_slice()));
    let value = |name: &str| report.readings.iter().find(|it| it.name.starts_with(name)).unwrap().value;
    assert_eq!(value("position"), Some(Value::Float(1.25)));
    assert_eq!(value("control mode"), Some(Value::Integer(0)), "one byte of four");
    assert_eq!(value("power-up range"), None, "the motor has no such parameter");
    assert_eq!(kinds(&bus), [17, 18]);
    assert_eq!((&bus.motors[0].parameters, bus.motors[0].state), (&before.parameters, before.state));
    bus.motors[1].state = 2;
    assert_eq!(show(&mut bus, 4).state, "on");
    assert_eq!(bus.motors[1].state, 2, "looking at it does not switch it off");
    bus.motors[1].parameters.remove(&0x7028);
    let report = show(&mut bus, 4);
    assert_eq!((report.state.as_str(), report.temperatures.len()), ("state not available", 0));
}

#[test]
fn a_motor_that_another_program_uses_gets_no_frame_that_writes() {
    let mut bus = bus(&[3]);
    let command = CanFrame::of(1 << 24 | 0x8000 << 8 | 3, true, &[0x80, 0, 0x80, 0, 0, 0, 0, 0]).unwrap();
    let reply = CanFrame::of(2 << 24 | 2 << 22 | 3 << 8 | 0xFD, true, &[0x90, 0, 0x80, 0, 0x80, 0, 1, 0x2C]).unwrap();
    let of_another =
        CanFrame::of(2 << 24 | 2 << 22 | 4 << 8 | 0xFD, true, &[0x90, 0, 0x80, 0, 0x80, 0, 1, 0x2C]).unwrap();
    bus.others = vec![command, of_another, reply];
    assert_eq!(show(&mut bus, 3).state, "on; another program uses it, or it reports by itself");
    let mut motor = RobStrideMotor::new(&mut bus, 3);
    for why in [motor.set_timeout(400), motor.set_id(5), motor.set_zero().map(|_| ()), motor.clear()] {
        let why = why.unwrap_err().to_string();
        assert!(
            why.starts_with("motor 3 is on; another program uses it, or it reports by itself: nothing was changed"),
            "{why}"
        );
    }
    assert_eq!(kinds(&bus), [0, 17]);
    // A motor that is off and unplugged from its supply does not reply.
    bus.others = vec![command];
    let why = RobStrideMotor::new(&mut bus, 3).clear().unwrap_err().to_string();
    assert_eq!(why, "motor 3: another program sends frames to it, and no reply was seen: nothing was changed");
    bus.others = vec![of_another];
    assert_eq!(show(&mut bus, 3).state, "off", "replies of other motors are not its own");
}

#[test]
fn a_timeout_is_read_back_and_stored() {
    let mut bus = bus(&[3, 4]);
    RobStrideMotor::new(&mut bus, 3).set_timeout(400).unwrap();
    assert_eq!((stored(&bus.motors[0]), stored(&bus.motors[1])), (400, OLD));
    let refused = |bus: &mut Bus, units| RobStrideMotor::new(bus, 4).set_timeout(units).unwrap_err().to_string();
    for (state, word) in [(1, "calibrating"), (2, "on")] {
        bus.motors[1].state = state;
        assert!(refused(&mut bus, 400).starts_with(&format!("motor 4 is {word}: nothing was changed")));
    }
    bus.motors[1].state = 0;
    assert!(refused(&mut bus, 100_001).contains("at most 5000 ms"));
    bus.motors[1].is_stubborn = true;
    let why = refused(&mut bus, 400);
    assert!(why.starts_with("motor 4: wrote 400 x 50 us, read 12345: its timeout may have changed"), "{why}");
    (bus.motors[1].is_stubborn, bus.motors[1].is_old) = (false, true);
    let why = refused(&mut bus, 400);
    assert!(
        why.starts_with("motor 4: it did not confirm that it stored anything, which old firmware cannot do: "),
        "{why}"
    );
    assert!(why.ends_with("look at it again with `motors show`"), "{why}");
    assert_eq!(stored(&bus.motors[1]), OLD);
    let why = RobStrideMotor::new(&mut bus, 9).set_timeout(400).unwrap_err().to_string();
    assert_eq!(why, "motor 9 does not say the number of its chip: nothing was changed");
}

#[test]
fn an_identifier_is_given_only_if_it_is_free_and_the_motor_takes_it() {
    let mut bus = bus(&[127, 2]);
    motor_with(&mut bus, 127, None).unwrap().set_id(1).unwrap();
    assert_eq!((bus.motors[0].id, bus.motors[0].flash.0), (1, 1));
    let refused = |bus: &mut Bus, id, new| RobStrideMotor::new(bus, id).set_id(new).unwrap_err().to_string();
    assert_eq!(refused(&mut bus, 1, 2), "motor 2 is on this bus already: nothing was changed");
    assert_eq!(refused(&mut bus, 1, 1), "motor 1 has this identifier: nothing was changed");
    bus.motors[1].parameters.remove(&0x7028);
    assert_eq!(
        refused(&mut bus, 1, 2),
        "motor 2 is on this bus already: nothing was changed",
        "without a timeout, too"
    );
    bus.motors[1] = Motor::new(2);
    bus.motors[1].is_stubborn = true;
    let why = refused(&mut bus, 2, 5);
    let wanted = "motor 2: motor 5 does not say the number of its chip: its identifier may have changed, and may not be stored: switch ";
    assert!(why.starts_with(wanted), "{why}");
    bus.motors[0].state = 2;
    assert!(refused(&mut bus, 1, 7).starts_with("motor 1 is on: nothing was changed"));
    assert_eq!(bus.motors[0].id, 1);
    (bus.motors[0].state, bus.motors[0].is_old) = (0, true);
    assert!(refused(&mut bus, 1, 7).contains("did not confirm that it stored"));
}

#[test]
fn of_two_motors_with_one_identifier_none_is_changed() {
    let mut bus = bus(&[127, 127]);
    bus.motors[1].chip = [9; 8];
    let both = "2 RobStride motors have the identifier 127; connect one at a time: nothing was changed";
    assert_eq!(RobStrideMotor::new(&mut bus, 127).set_id(1).unwrap_err().to_string(), both);
    assert_eq!(RobStrideMotor::new(&mut bus, 127).set_zero().unwrap_err().to_string(), both);
    // One has tripped and the other is on: what is sent to one would switch off the other.
    bus.motors[1].state = 2;
    bus.lost = vec![0];
    assert_eq!(RobStrideMotor::new(&mut bus, 127).clear().unwrap_err().to_string(), both);
    assert_eq!(RobStrideMotor::new(&mut bus, 127).set_timeout(400).unwrap_err().to_string(), both);
    assert_eq!(kinds(&bus), [0, 17]);
    assert_eq!(bus.motors[1].state, 2);
}

#[test]
fn a_zero_is_stored_once_the_position_is_zero() {
    let mut bus = bus(&[3]);
    bus.motors[0].parameters.insert(0x7029, [0, 7, 7, 7]);
    let zero = motor_with(&mut bus, 3, None).unwrap().set_zero().unwrap();
    assert!((zero.before - 1.25).abs() < 1e-6 && (zero.after - 0.001).abs() < 1e-6);
    assert!(zero.note.contains("nearly a whole turn"), "{}", zero.note);
    assert_eq!(bus.motors[0].flash.1[&POSITION.index], 0.001_f32.to_le_bytes());
    let at = |bus: &mut Bus, position: f32| bus.motors[0].turn_to(position);
    let refused = |bus: &mut Bus| RobStrideMotor::new(bus, 3).set_zero().unwrap_err().to_string();
    at(&mut bus, 1.0);
    bus.motors[0].state = 2;
    assert!(refused(&mut bus).starts_with("motor 3 is on: nothing was changed"));
    bus.motors[0].state = 0;
    bus.motors[0].is_stubborn = true;
    let why = refused(&mut bus);
    assert!(why.starts_with("motor 3: its position is 1.0000 rad and not 0: its zero may have changed"), "{why}");
    bus.motors[0].is_stubborn = false;
    bus.lost = vec![6];
    let why = refused(&mut bus);
    assert!(why.starts_with("motor 3: it did not confirm the zero: its zero may have changed"), "{why}");
    at(&mut bus, 1.0);
    bus.motors[0].is_old = true;
    assert!(refused(&mut bus).contains("did not confirm that it stored"));
    bus.motors[0].is_old = false;
    for wrong in [f32::NAN, f32::INFINITY] {
        bus.sent.clear();
        at(&mut bus, wrong);
        assert_eq!(refused(&mut bus), "motor 3 does not say its position");
        assert!(!kinds(&bus).contains(&6));
    }
}

#[test]
fn errors_are_cleared_and_the_motor_stays_off() {
    let mut bus = bus(&[3]);
    bus.motors[0].errors = 0b1;
    motor_with(&mut bus, 3, None).unwrap().clear().unwrap();
    assert_eq!(show(&mut bus, 3).state, "off");
    assert!(!kinds(&bus).contains(&3), "nothing enables it");
    bus.motors[0].state = 2;
    assert!(RobStrideMotor::new(&mut bus, 3).clear().is_err());
    assert_eq!(bus.motors[0].state, 2, "a motor that is on is not switched off");
}

#[test]
fn lost_answers_are_asked_for_again_and_late_ones_confirm_nothing_later() {
    let mut bus = bus(&[3]);
    bus.lost = vec![17, 17];
    assert_eq!(show(&mut bus, 3).state, "off");
    // The answer to the written state arrives while the frame that stores has none.
    bus.motors[0].is_old = true;
    bus.late = vec![18];
    let why = RobStrideMotor::new(&mut bus, 3).set_timeout(400).unwrap_err().to_string();
    assert!(why.starts_with("motor 3 does not say its state: nothing was changed"), "{why}");
    assert_eq!(stored(&bus.motors[0]), OLD);
}
