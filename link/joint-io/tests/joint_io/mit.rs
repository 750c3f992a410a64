//! Tests of MIT-mode frames against the documented packing and against the simulated actuator.

use super::{drive, model_ranges, ranges};
use actuator_model::mit::{Actuator, Shaft};
use dynamics_core::drive::{MitRanges, Range};
use joint_io::mit::{ENTER, EXIT, FIELD_BITS, POSITION_BITS, Reply, Setpoint, ZERO};
use proptest::prelude::*;

/// Ranges equal to the range of codes, so that every value equals its code.
fn unit_ranges() -> MitRanges {
    let codes = |bits: u32| Range { min: 0.0, max: f32::from(u16::MAX >> (16 - bits)) };
    let field = codes(FIELD_BITS);
    MitRanges { position: codes(POSITION_BITS), velocity: field, kp: field, kd: field, torque: field }
}

#[test]
fn a_command_made_by_hand_has_the_documented_bytes() {
    let wanted = f32::from(0x1234_u16);
    let setpoint = Setpoint {
        position: wanted,
        velocity: f32::from(0x567_u16),
        kp: f32::from(0x89a_u16),
        kd: f32::from(0xbcd_u16),
        torque: f32::from(0xef0_u16),
    };
    assert_eq!(setpoint.pack(&unit_ranges()), Some([0x12, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0xde, 0xf0]));
}

#[test]
fn a_reply_made_by_hand_has_the_documented_fields() {
    let mut drive = drive(0, 7);
    drive.ranges = unit_ranges();
    (drive.reply_bytes, drive.temperature_offset) = (8, Some(-40.0));
    let reply = Reply::unpack(&[7, 0x12, 0x34, 0x56, 0x78, 0x9a, 60, 3], &drive).unwrap();
    assert_eq!(reply.position, f32::from(0x1234_u16));
    assert_eq!(reply.velocity, f32::from(0x567_u16));
    assert_eq!(reply.torque, f32::from(0x89a_u16));
    assert_eq!((reply.temperature, reply.error, reply.saturated), (Some(20.0), 3, false));
}

#[test]
fn a_reply_of_another_length_or_another_actuator_is_none() {
    let drive = drive(0, 7);
    let data = [7, 0, 1, 2, 3, 4, 5, 6, 7];
    for length in 0..=8 {
        assert_eq!(Reply::unpack(&data[..length], &drive).is_some(), length == 6, "{length} bytes");
    }
    assert_eq!(Reply::unpack(&[8, 0, 1, 2, 3, 4], &drive), None);
}

#[test]
fn no_torque_is_within_half_a_step_of_none() {
    let data = Setpoint::torque(0.0).pack(&ranges()).unwrap();
    let mut actuator = Actuator::new(7, model_ranges());
    actuator.receive(&data);
    let told = actuator.electronics.told();
    assert_eq!((told.kp, told.kd), (0.0, 0.0));
    assert!(told.torque.abs() <= 0.5 * 36.0 / 4095.0 * 1.0001, "{}", told.torque);
}

#[test]
fn special_frames_switch_the_actuator() {
    let mut actuator = Actuator::new(7, model_ranges());
    actuator.shaft.position = 0.5;
    actuator.receive(&ENTER);
    assert!(actuator.electronics.is_enabled());
    let drive = drive(0, 7);
    let position = |actuator: &mut Actuator| {
        Reply::unpack(&actuator.receive(&Setpoint::torque(0.0).pack(&ranges()).unwrap()).unwrap(), &drive)
            .unwrap()
            .position
    };
    assert!((position(&mut actuator) - 0.5).abs() < 1e-3);
    actuator.receive(&ZERO);
    assert!(position(&mut actuator).abs() < 1e-3);
    actuator.receive(&EXIT);
    assert!(!actuator.electronics.is_enabled());
}

#[test]
fn a_nan_never_becomes_a_frame() {
    let good = Setpoint { position: 0.0, velocity: 0.0, kp: 0.0, kd: 0.0, torque: 0.0 };
    let nan = f32::NAN;
    for bad in [
        Setpoint { position: nan, ..good },
        Setpoint { velocity: nan, ..good },
        Setpoint { kp: nan, ..good },
        Setpoint { kd: nan, ..good },
        Setpoint { torque: nan, ..good },
    ] {
        assert_eq!(bad.pack(&ranges()), None, "{bad:?}");
    }
    assert!(good.pack(&ranges()).is_some());
}

#[test]
fn values_beyond_a_range_take_its_end() {
    let span = Range { min: -18.0, max: 18.0 };
    for (x, code) in [
        (18.0, 4095),
        (18.1, 4095),
        (1e30, 4095),
        (f32::INFINITY, 4095),
        (-18.0, 0),
        (-1e30, 0),
        (f32::NEG_INFINITY, 0),
    ] {
        assert_eq!(span.code(x, FIELD_BITS), Some(code), "{x}");
    }
}

/// Half a step, and three roundings in single precision (difference, scale, product), each at most `2^-24` of 65,535 steps.
const HALF_STEP: f64 = 0.5 + 3.0 * 65_535.0 / 16_777_216.0;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn what_was_packed_arrives_within_half_a_step(
        position in -12.5..12.5_f32, velocity in -65.0..65.0_f32, kp in 0.0..500.0_f32, kd in 0.0..5.0_f32,
        torque in -18.0..18.0_f32,
    ) {
        let setpoint = Setpoint { position, velocity, kp, kd, torque };
        let mut actuator = Actuator::new(7, model_ranges());
        actuator.receive(&setpoint.pack(&ranges()).unwrap());
        let told = actuator.electronics.told();
        let r = ranges();
        for (sent, got, range, bits) in [
            (position, told.position, r.position, POSITION_BITS),
            (velocity, told.velocity, r.velocity, FIELD_BITS),
            (kp, told.kp, r.kp, FIELD_BITS),
            (kd, told.kd, r.kd, FIELD_BITS),
            (torque, told.torque, r.torque, FIELD_BITS),
        ] {
            let steps = (f64::from(sent) - got).abs() / f64::from(range.step(bits));
            prop_assert!(steps <= HALF_STEP, "{sent} arrived as {got}: {steps} steps");
        }
    }

    /// The actuator truncates: its reply is up to a whole step below the true value.
    #[test]
    fn what_an_actuator_says_arrives_within_its_step(position in -12.5..12.5_f64, velocity in -65.0..65.0_f64) {
        let mut actuator = Actuator::new(7, model_ranges());
        actuator.shaft = Shaft { position, velocity };
        let data = actuator.receive(&EXIT).unwrap();
        let reply = Reply::unpack(&data, &drive(0, 7)).unwrap();
        let r = ranges();
        let below = (position - f64::from(reply.position)) / f64::from(r.position.step(POSITION_BITS));
        prop_assert!((-0.02..=1.02).contains(&below), "{below} steps");
        let below = (velocity - f64::from(reply.velocity)) / f64::from(r.velocity.step(FIELD_BITS));
        prop_assert!((-0.02..=1.02).contains(&below), "{below} steps");
    }

    #[test]
    fn every_code_comes_back_as_itself(code in any::<u16>(), min in -200.0..-0.1_f32, max in 0.1..200.0_f32) {
        let range = Range { min, max };
        prop_assert_eq!(range.code(range.value(code, POSITION_BITS), POSITION_BITS), Some(code));
        let code = code >> 4;
        prop_assert_eq!(range.code(range.value(code, FIELD_BITS), FIELD_BITS), Some(code));
    }

    #[test]
    fn any_bits_become_a_frame_inside_the_ranges_or_none(bits in any::<[u32; 5]>()) {
        let [position, velocity, kp, kd, torque] = bits.map(f32::from_bits);
        let packed = Setpoint { position, velocity, kp, kd, torque }.pack(&ranges());
        prop_assert_eq!(packed.is_none(), [position, velocity, kp, kd, torque].iter().any(|x| x.is_nan()));
    }

    #[test]
    fn any_bytes_become_a_reply_of_finite_numbers_or_none(data in proptest::collection::vec(any::<u8>(), 0..9)) {
        if let Some(reply) = Reply::unpack(&data, &drive(0, 7)) {
            prop_assert!(reply.position.abs() <= 12.6 && reply.velocity.abs() <= 65.1 && reply.torque.abs() <= 18.1);
        }
    }
}
