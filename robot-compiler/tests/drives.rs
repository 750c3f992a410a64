//! Drives of a robot file, as numbers for the chip.
//!
//! `tests/data/emitted_mit.rs` and `emitted_pwm.rs` are the output of `emit::drives_module` for the two examples. Write
//! them again with `UPDATE_EMITTED=1 cargo test -p robot-compiler --test drives`, and check the diff.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]
#![allow(clippy::panic, reason = "a test names the file that fails")]
#![allow(clippy::float_cmp, reason = "the emitted numbers must be the very same")]

use dynamics_core::drive::{DataRate, Drives};
use proptest::prelude::*;
use robot_compiler::drive::JointDrive;
use robot_compiler::{Robot, SceneFile, emit};
use std::f64::consts::TAU;

#[path = "data/emitted_mit.rs"]
#[allow(unreachable_pub, clippy::excessive_precision, reason = "written for a crate of its own")]
mod emitted_mit;
#[path = "data/emitted_pwm.rs"]
#[allow(unreachable_pub, clippy::excessive_precision, reason = "written for a crate of its own")]
mod emitted_pwm;

use crate::common::{rustfmt, top};

fn scene(name: &str) -> SceneFile {
    SceneFile::load(&top(name)).unwrap_or_else(|error| panic!("{error}"))
}

fn mit6() -> SceneFile {
    scene("scenes/examples/mit6_wave.toml")
}

fn pwm2() -> SceneFile {
    scene("scenes/examples/pwm2_swing.toml")
}

#[test]
fn emitted_drives_hold_the_very_bits_of_the_file() {
    let (mit, pwm) = (mit6().drives::<6>(), pwm2().drives::<2>());
    for (name, text) in [("emitted_mit.rs", emit::drives_module(&mit)), ("emitted_pwm.rs", emit::drives_module(&pwm))] {
        let path = top("robot-compiler/tests/data").join(name);
        if std::env::var_os("UPDATE_EMITTED").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        assert_eq!(text, std::fs::read_to_string(&path).unwrap(), "the emitted source has changed");
    }
    assert_eq!(emitted_mit::drives(), mit);
    assert_eq!(emitted_pwm::drives(), pwm);
}

#[test]
fn drives_on_can_are_simulated_unless_the_scene_says_ideal() {
    let mut wave = mit6();
    let (specs, wires) = wave.simulated_drives::<6>().unwrap();
    assert_eq!(Drives::Mit(wires), wave.drives());
    for (spec, wire) in specs.iter().zip(&wires) {
        assert_eq!((spec.ratio as f32, spec.zero as f32), (wire.gearing.ratio, wire.gearing.zero));
    }
    wave.actuators.ideal = true;
    assert!(wave.simulated_drives::<6>().is_none());
    assert!(pwm2().simulated_drives::<2>().is_none());
    assert!(scene("scenes/puma560_pick.toml").simulated_drives::<6>().is_none());
}

#[test]
fn an_arm_without_drives_is_reached_over_the_link() {
    let puma = scene("scenes/puma560_pick.toml");
    assert_eq!(puma.drives::<6>(), Drives::Link);
    let text = emit::drives_module(&puma.drives::<6>());
    assert!(text.ends_with("pub const fn drives() -> Drives<6> {\n    Drives::Link\n}\n"), "{text}");
}

#[test]
fn a_hash_feels_every_number_of_a_drive() {
    let scene = mit6();
    let hash = |scene: &SceneFile| scene.hash(&scene.robot.model::<6>().unwrap());
    let mut all = vec![hash(&scene)];
    let mut without = scene.clone();
    without.robot.joints.iter_mut().for_each(|joint| joint.drive = None);
    all.push(hash(&without));
    let mut change = |change: &dyn Fn(&mut robot_compiler::drive::MitSpec)| {
        let mut other = scene.clone();
        let Some(JointDrive::Mit(spec)) = &mut other.robot.joints[3].drive else { panic!("an MIT actuator") };
        change(spec);
        all.push(hash(&other));
    };
    change(&|spec| spec.bus = 1);
    change(&|spec| spec.data_rate = Some(DataRate::Mbit2));
    change(&|spec| spec.data_rate = Some(DataRate::Mbit5));
    change(&|spec| spec.id = 9);
    change(&|spec| spec.reply_id = 8);
    change(&|spec| spec.reply_bytes = 8);
    change(&|spec| spec.temperature_offset = Some(0.0));
    change(&|spec| spec.temperature_offset = Some(-40.0));
    change(&|spec| spec.ratio = -spec.ratio);
    change(&|spec| spec.zero += 0.01);
    change(&|spec| spec.position.0 -= 0.5);
    change(&|spec| spec.velocity.1 += 1.0);
    change(&|spec| spec.kp.1 += 1.0);
    change(&|spec| spec.kd.1 += 1.0);
    change(&|spec| spec.torque.1 += 1.0);
    change(&|spec| spec.damping += 0.1);
    let count = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), count, "two changes gave one hash");
}

#[test]
fn a_motor_speed_and_the_encoders_reach_follow_from_the_file() {
    let scene = pwm2();
    let Drives::Pwm([shoulder, elbow]) = scene.drives::<2>() else { panic!("PWM drives") };
    // One count per tick of 1 ms is TAU / 16384 * 1000 rad/s at the joint, and 50 times that at the motor.
    assert_eq!(shoulder.speed_per_count, (50.0 * TAU / 16384.0 * 1000.0) as f32);
    assert_eq!(elbow.speed_per_count, -shoulder.speed_per_count);
    // The guard's speed, 5 rad/s times its factor, in counts per tick, rounded up, plus one.
    let reach = (scene.control.velocity_factor * 5.0 * 16384.0 / TAU / 1000.0).ceil() + 1.0;
    assert_eq!(f64::from(shoulder.jump_max), reach);
    assert_eq!((shoulder.channel, elbow.channel), (0, 1));
    assert_eq!((shoulder.encoder_reversed, elbow.encoder_reversed), (false, false));
    assert_eq!(scene.too_fast_for_its_encoder(), None);
}

#[test]
fn a_rate_at_which_turns_cannot_be_counted_is_found() {
    let mut scene = pwm2();
    scene.control.rate = 8.0;
    let (joint, jump) = scene.too_fast_for_its_encoder().unwrap();
    assert_eq!(joint, 0);
    assert!(jump >= 2048, "{jump}");
}

#[test]
fn a_gear_is_the_rotors_where_the_file_gives_no_other() {
    let robot = Robot::load(&top("robots/examples/pwm2.toml")).unwrap();
    let ratios: Vec<f64> = robot
        .joints
        .iter()
        .map(|joint| match joint.drive {
            Some(JointDrive::Pwm(spec)) => spec.ratio,
            _ => panic!("a PWM drive"),
        })
        .collect();
    assert_eq!(ratios, [50.0, -50.0]);
}

#[test]
fn emitted_source_is_as_rustfmt_would_leave_it() {
    for name in ["emitted_mit.rs", "emitted_pwm.rs"] {
        let path = top("robot-compiler/tests/data").join(name);
        let Some(status) = rustfmt(&["--check"], [&path]) else { return };
        assert!(status.success(), "{name}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// From joint radians to the actuator's and back, and the same for N m, through the numbers for the chip.
    #[test]
    fn calibration_of_a_file_goes_both_ways(
        joint in 0..6_usize, gear in 0.5..20.0_f64, reversed in any::<bool>(), zero in -3.0..3.0_f64,
        q in -3.0..3.0_f64, torque in -40.0..40.0_f64,
    ) {
        let mut scene = mit6();
        let Some(JointDrive::Mit(spec)) = &mut scene.robot.joints[joint].drive else { panic!("an MIT actuator") };
        (spec.ratio, spec.zero) = (if reversed { -gear } else { gear }, zero);
        let ratio = spec.ratio;
        let Drives::Mit(drives) = scene.drives::<6>() else { panic!("MIT actuators") };
        let gearing = drives[joint].gearing;
        let shaft = gearing.drive_position(q as f32);
        // f32 rounds ratio, zero, product and sum.
        let span = f64::from(f32::EPSILON) * (gear * q.abs() + zero.abs());
        prop_assert!((f64::from(shaft) - (ratio * q + zero)).abs() <= 2.0 * span);
        prop_assert!((f64::from(gearing.joint_position(shaft)) - q).abs() <= 3.0 * span / gear + f64::from(f32::EPSILON) * q.abs());
        let shaft = gearing.drive_torque(torque as f32);
        prop_assert!((f64::from(shaft) - torque / ratio).abs() <= 2.0 * f64::from(f32::EPSILON) * (torque / ratio).abs());
        prop_assert!((f64::from(gearing.joint_torque(shaft)) - torque).abs() <= 4.0 * f64::from(f32::EPSILON) * torque.abs());
    }
}
