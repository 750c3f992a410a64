//! Movements by hand, and readings of simulated motors.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::super::frame::CanFrame;
use super::super::robstride_motor::simulated_bus::{Bus, Motor, bus, kinds};
use super::{Movement, ShaftMotor, jumped, motors, moved, positions, still_positions, zero};
use dynamics_core::drive::Protocol;
use std::f64::consts::PI;

#[test]
fn the_motor_that_moves_alone_is_the_one_and_otherwise_nobody_guesses() {
    let before = [0.0, 1.0, -2.0];
    assert_eq!(moved(&before, &[0.15, 1.0, -2.0], &[]), Movement::None);
    let one = moved(&before, &[0.02, 1.0, -2.5], &[]);
    assert!(matches!(one, Movement::One(2, by) if (by + 0.5).abs() < 1e-12), "{one:?}");
    assert_eq!(moved(&before, &[0.3, 1.0, -2.5], &[]), Movement::Several(vec![0, 2]));
    assert_eq!(moved(&before, &[0.0, 1.0, -2.5], &[2]), Movement::Several(vec![2]), "it has a joint already");
    // A joint with a motor already hangs and swings a little.
    assert!(matches!(moved(&before, &[0.12, 1.0, -2.5], &[0]), Movement::One(2, _)));
}

#[test]
fn the_zero_is_where_the_formula_of_the_robot_file_has_it() {
    for (direction, gear, q, at_zero) in [(1.0, 1.0, 0.5, 0.2), (-1.0, 6.0, -1.2, 3.0), (-1.0, 1.0, 0.0, 0.7)] {
        let shaft = direction * gear * q + at_zero;
        assert!((zero(shaft, direction, gear, q) - at_zero).abs() < 1e-12);
    }
}

#[test]
fn a_position_that_wraps_or_begins_anew_is_no_movement() {
    assert_eq!(jumped(&[0.0, 12.4], &[0.3, 12.5]), None);
    assert_eq!(jumped(&[0.0, 12.4], &[0.0, -12.4]), Some(1), "the end of the range");
    assert_eq!(jumped(&[-0.3, 0.0], &[5.98, 0.0]), Some(0), "the power was off");
}

/// The RobStride motors of a bus, or the error.
fn found(bus: &mut Bus) -> Result<Vec<ShaftMotor>, String> {
    motors(bus, Some(Protocol::RobStride)).map_err(|why| why.to_string())
}

#[test]
fn robstride_motors_are_found_and_read_by_frames_that_change_nothing() {
    let mut bus = bus(&[3, 4]);
    bus.motors[0].parameters.insert(0x7029, [1, 7, 7, 7]);
    bus.motors[1].parameters.insert(0x7029, [0, 7, 7, 7]);
    let before = bus.motors.clone();
    let all = found(&mut bus).unwrap();
    assert_eq!(
        all.iter().map(|it| (it.id, it.ranges, it.torque_limit)).collect::<Vec<_>>(),
        [(3, None, Some(60.0)), (4, None, Some(60.0))]
    );
    assert_eq!((all[0].power_up_lowest, all[1].power_up_lowest), (Some(-PI), Some(0.0)));
    bus.sent.clear();
    assert_eq!(positions(&mut bus, &all).unwrap(), [1.25; 2]);
    assert_eq!(kinds(&bus), [17], "while a person moves the arm, nothing is written");
    bus.motors[1].turn_to(-6.5);
    let still = still_positions(&mut bus, &all).unwrap();
    assert!((still[0] - 1.25).abs() < 1e-3 && (still[1] + 6.5).abs() < 1e-3, "{still:?}");
    assert_eq!(kinds(&bus), [17, 18]);
    for (motor, before) in bus.motors.iter().zip(&before) {
        assert_eq!((motor.state, motor.parameters[&0x7028]), (0, before.parameters[&0x7028]));
    }
    bus.motors[0].parameters.remove(&0x7029);
    assert_eq!(found(&mut bus).unwrap()[0].power_up_lowest, None);
}

#[test]
fn a_robstride_motor_that_is_on_or_silent_is_rejected() {
    let mut bus = bus(&[3, 4]);
    let all = found(&mut bus).unwrap();
    let still = |bus: &mut Bus| still_positions(bus, &all).unwrap_err().to_string();
    for (state, text) in [(1, "calibrating"), (2, "on")] {
        bus.motors[1].state = state;
        let wanted = format!("motor 4 is {text}: expected motors that are off, and no other program on the bus");
        assert_eq!((still(&mut bus), found(&mut bus).unwrap_err()), (wanted.clone(), wanted));
        assert_eq!(bus.motors[1].state, state, "it is not switched off");
    }
    bus.motors[1].state = 0;
    // As many lost answers as one request survives.
    for (lost, times) in [(17, 8), (18, 2)] {
        bus.lost = vec![lost; times];
        still_positions(&mut bus, &all).unwrap();
    }
    bus.lost = vec![18; 3];
    assert_eq!(still(&mut bus), "motor 3 does not answer");
    bus.motors.pop();
    assert_eq!(still(&mut bus), "motor 4 does not say its position");
}

#[test]
fn a_robstride_motor_with_an_error_is_rejected() {
    let mut bus = bus(&[3, 4]);
    let all = found(&mut bus).unwrap();
    bus.motors[1].errors = 1 << 3;
    let wanted = "motor 4: off; its encoder fails: expected a motor without an error (newtau motors clear)";
    assert_eq!(still_positions(&mut bus, &all).unwrap_err().to_string(), wanted);
    assert_eq!(bus.motors[1].errors, 1 << 3, "it is not cleared");
}

#[test]
fn a_torque_limit_that_is_missing_or_no_number_is_unknown() {
    let mut bus = bus(&[3]);
    bus.motors[0].parameters.insert(0x700B, f32::NAN.to_le_bytes());
    assert_eq!(found(&mut bus).unwrap()[0].torque_limit, None);
    bus.motors[0].parameters.remove(&0x700B);
    assert_eq!(found(&mut bus).unwrap()[0].torque_limit, None);
}

#[test]
fn nothing_is_written_to_robstride_motors_that_another_program_uses() {
    let mut bus = bus(&[3, 4]);
    let all = found(&mut bus).unwrap();
    bus.sent.clear();
    let command = CanFrame::of(1 << 24 | 0x8000 << 8 | 4, true, &[0x80, 0, 0x80, 0, 0, 0, 0, 0]).unwrap();
    let reply = CanFrame::of(2 << 24 | 2 << 22 | 4 << 8 | 0xFD, true, &[0x90, 0, 0x80, 0, 0x80, 0, 1, 0x2C]).unwrap();
    bus.others = vec![command, reply];
    let wanted = "motor 4 is on; another program uses it, or it reports by itself: expected motors that are off, and no other program on the bus";
    assert_eq!(still_positions(&mut bus, &all).unwrap_err().to_string(), wanted);
    assert_eq!(found(&mut bus).unwrap_err(), wanted);
    bus.others = vec![command];
    assert!(found(&mut bus).unwrap_err().starts_with("motor 4: another program sends frames to it"));
    assert_eq!(kinds(&bus), [17]);
}

#[test]
fn two_robstride_motors_with_one_identifier_are_not_taken_for_one() {
    let mut bus = bus(&[127, 127]);
    bus.motors[1].chip = [9; 8];
    assert_eq!(found(&mut bus).unwrap_err(), "2 RobStride motors have the identifier 127; connect one at a time");
    assert_eq!(kinds(&bus), [0, 17]);
}

#[test]
fn a_robstride_motor_past_the_end_of_its_frames_is_rejected() {
    let mut bus = bus(&[3]);
    let all = found(&mut bus).unwrap();
    let still = |bus: &mut Bus| still_positions(bus, &all).map_err(|why| why.to_string());
    bus.motors[0].turn_to(12.5);
    assert!((still(&mut bus).unwrap()[0] - 12.5).abs() < 1e-3);
    bus.motors[0].turn_to(12.7);
    assert!(still(&mut bus).unwrap_err().starts_with("motor 3 is at the end of the position range"));
    bus.motors[0] = Motor { wraps: true, ..bus.motors[0].clone() };
    let why = still(&mut bus).unwrap_err();
    assert!(why.contains("-12.44 rad in its frames and 12.70 rad in its parameter 0x7019"), "{why}");
}
