//! Robot files whose ranges, identifiers or motors are not those at the adapter.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::super::adapter_name::AdapterName;
use super::super::simulated::SimulatedArm;
use super::{FrameRanges, Mismatch, MotorSettings, advice, check, mismatches};
use crate::session::drive::arm::Wiring;
use dynamics_core::drive::{MitDrive, Protocol, Range};
use robot_compiler::SceneFile;
use std::path::Path;

fn scene() -> SceneFile {
    SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/yam_one_bus.toml")).unwrap()
}

fn said(drives: &[MitDrive]) -> Vec<String> {
    let mut adapter = SimulatedArm::new(&scene()).unwrap().adapter();
    let found = check(&mut adapter, Protocol::Damiao, drives.iter().copied().enumerate()).unwrap().unwrap();
    found.iter().map(ToString::to_string).collect()
}

#[test]
fn the_motors_of_the_robot_file_fit_and_every_other_range_is_named_with_what_it_would_do() {
    let drives = scene().mit_drives();
    assert_eq!(said(&drives), [""; 0]);
    let mut other = drives;
    let halved = |range: Range| Range { min: range.min / 2.0, max: range.max / 2.0 };
    other[1].ranges.torque = halved(other[1].ranges.torque);
    other[2].ranges.position = halved(other[2].ranges.position);
    other[3].ranges.velocity.min *= 2.0;
    other[4].reply_id = 99;
    other[5].id = 100;
    assert_eq!(
        said(&other),
        [
            "joint 2: motor 2: torque: found a range of ±28 in the motor and [-14, 14] in the robot file: it would give 2.000 times the commanded torque",
            "joint 3: motor 3: position: found a range of ±12.5 in the motor and [-6.25, 6.25] in the robot file: its position would be 2.000 times what is read",
            "joint 4: motor 4: velocity: found a range of ±30 in the motor and [-60, 30] in the robot file: a motor's range is symmetric",
            "joint 5: motor 5: reply_id: found 21 in the motor and 99 in the robot file: its replies would not be heard",
            "joint 6: motor 100: does not answer",
        ]
    );
}

#[test]
fn rounding_is_no_difference_and_no_number_and_another_mode_are() {
    let drive = scene().mit_drives()[0];
    let [position, velocity, torque] =
        [drive.ranges.position, drive.ranges.velocity, drive.ranges.torque].map(|range| f64::from(range.max));
    let fits = MotorSettings {
        reply_id: drive.reply_id.into(),
        mode: Some(1),
        ranges: FrameRanges { position, velocity, torque },
    };
    assert_eq!(mismatches(&fits, &drive), []);
    let with =
        |torque| mismatches(&MotorSettings { ranges: FrameRanges { torque, ..fits.ranges }, ..fits }, &drive).len();
    assert_eq!(
        [with(torque * 1.00005), with(torque * 1.0002), with(f64::NAN), with(0.0), with(-torque)],
        [0, 1, 1, 1, 1]
    );
    assert_eq!([with(f64::INFINITY), with(f64::NEG_INFINITY)], [1, 1]);
    for mode in [Some(2), None] {
        assert_eq!(mismatches(&MotorSettings { mode, ..fits }, &drive), [Mismatch::Mode(mode)]);
    }
}

#[test]
fn motors_whose_settings_cannot_be_read_are_not_asked() {
    let mut adapter = SimulatedArm::new(&scene()).unwrap().adapter();
    let drives = scene().mit_drives();
    for kind in [Protocol::RobStride, Protocol::MiniCheetah, Protocol::MyActuator] {
        let found = check(&mut adapter, kind, drives.iter().copied().enumerate());
        assert_eq!(found.unwrap(), None, "{kind:?}");
    }
}

#[test]
fn a_session_does_not_begin_with_motors_that_do_not_fit() {
    let scene = scene();
    let wiring = Wiring::new(&scene, &[AdapterName::Simulated], false).unwrap();
    let mut adapter = SimulatedArm::new(&scene).unwrap().adapter();
    wiring.check_settings(&mut adapter, &AdapterName::Simulated, &scene).unwrap();
    let mut other = scene.clone();
    for joint in &mut other.robot.joints {
        let Some(robot_compiler::drive::JointDrive::Mit(spec)) = &mut joint.drive else { panic!("another drive") };
        spec.torque = (-2.0 * spec.torque.1, 2.0 * spec.torque.1);
    }
    let wiring = Wiring::new(&other, &[AdapterName::Simulated], false).unwrap();
    let why = format!("{:?}", wiring.check_settings(&mut adapter, &AdapterName::Simulated, &other).unwrap_err());
    assert!(
        why.contains("it would give 0.500 times the commanded torque") && why.contains("nothing was enabled"),
        "{why}"
    );
}

#[test]
fn motors_without_power_get_other_advice_than_motors_with_other_ranges() {
    let mut drive = scene().mit_drives()[0];
    let mut adapter = SimulatedArm::new(&scene()).unwrap().adapter();
    let mut of = |drive| {
        let found = check(&mut adapter, Protocol::Damiao, [(0, drive)].into_iter()).unwrap().unwrap();
        (found.len(), advice(&found).contains("power"))
    };
    drive.reply_id = 0;
    let (other, silent) = (of(drive), of(MitDrive { id: 90, ..drive }));
    assert_eq!((other, silent), ((1, false), (1, true)));
}
