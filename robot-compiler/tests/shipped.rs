//! The shipped robots and scenes.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]
#![allow(clippy::float_cmp, reason = "numbers from a file must come through unchanged")]
#![allow(clippy::panic, reason = "a test names the file that fails")]

use dynamics_core::control::Between;
use nalgebra::Vector3;
use robot_compiler::scene::{IntegralSpec, KernelChoice};
use robot_compiler::{Robot, RobotJoint, SceneFile, emit, with_dof};

use crate::common::{compare_output, files, rustfmt, top};

fn scenes() -> Vec<SceneFile> {
    let scenes = files(&top("scenes"), &["toml"]);
    assert!(scenes.len() >= 10, "found {}", scenes.len());
    scenes.iter().map(|path| SceneFile::load(path).unwrap_or_else(|error| panic!("{error}"))).collect()
}

#[test]
fn every_robot_loads_and_names_its_source() {
    let robots = files(&top("robots"), &["toml"]);
    let names: Vec<String> = robots.iter().map(|path| path.file_stem().unwrap().to_string_lossy().into()).collect();
    assert_eq!(names, ["planar2r", "planar3r", "puma560", "rebot_b601_rs", "scara", "stanford", "ur5", "yam"]);
    for path in robots {
        let robot = Robot::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert!(robot.source.len() > 20, "{}", path.display());
        let measured = |joint: &RobotJoint| joint.encoder.is_some() || joint.has_own_loop();
        assert!(robot.joints.iter().all(measured), "{}", path.display());
        with_dof!(robot.dof(), N => { robot.model::<N>().unwrap(); });
    }
}

#[test]
fn only_the_puma_needs_leave_to_be_unphysical() {
    for path in files(&top("robots"), &["toml"]) {
        let robot = Robot::load(&path).unwrap();
        assert_eq!(robot.allow_unphysical.is_some(), robot.name == "Puma 560", "{}", robot.name);
    }
}

#[test]
fn the_reason_for_impossible_bodies_names_every_one_of_them() {
    for path in files(&top("robots"), &["toml"]) {
        let robot = Robot::load(&path).unwrap();
        let Some(reason) = &robot.allow_unphysical else { continue };
        for (index, joint) in robot.joints.iter().enumerate() {
            let mut alone = Robot { allow_unphysical: None, joints: vec![joint.clone()], ..robot.clone() };
            alone.joints[0].drive = None;
            let named = reason.contains(&format!("link {}", index + 1));
            assert_eq!(alone.model::<1>().is_err(), named, "{}: link {}: {reason}", robot.name, index + 1);
        }
    }
}

#[test]
fn every_scene_gives_a_motion_a_configuration_and_a_hash_of_its_own() {
    let (mut hashes, mut durations) = (Vec::new(), Vec::new());
    for scene in scenes() {
        with_dof!(scene.robot.dof(), N => {
            let model = scene.robot.model::<N>().unwrap();
            let motion = scene.trajectory(&model).unwrap();
            durations.push(format!("{}: {} s", scene.name, motion.duration()));
            assert_eq!(motion.start().q, <[f64; N]>::try_from(scene.motion.start()).unwrap());
            let config = scene.controller_config(&model);
            assert!(config.gains.iter().all(|gains| gains.inertia > 0.0), "{}", scene.name);
            assert!(!scene.sensors.encoder || config.encoder.iter().all(|encoder| encoder.per_count > 0.0));
            hashes.push((scene.name.clone(), scene.hash(&model)));
        });
    }
    compare_output("durations", durations.join("\n"));
    for (i, (name, hash)) in hashes.iter().enumerate() {
        for (other, same) in &hashes[..i] {
            // Same arm and controller with another motion or world: exactly the same tick.
            let alike = ["puma560_pick", "puma560_wrong_payload", "puma560_elastic"];
            assert!(
                hash != same || alike.contains(&name.as_str()) && alike.contains(&other.as_str()),
                "{name} {other}"
            );
        }
    }
}

#[test]
fn every_robot_without_a_scene_gets_one_that_works() {
    for path in files(&top("robots"), &["toml"]) {
        let scene = SceneFile::default_for(Robot::load(&path).unwrap());
        with_dof!(scene.robot.dof(), N => {
            let model = scene.robot.model::<N>().unwrap();
            let motion = scene.trajectory(&model).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
            assert!(motion.duration() >= 2.0);
        });
    }
}

fn integral(time: f64) -> IntegralSpec {
    IntegralSpec { time, torque: vec![1.0; 6], dead_band: vec![1e-4; 6] }
}

#[test]
fn a_hash_feels_what_a_tick_reads_and_nothing_else() {
    let scene = SceneFile::load(&top("scenes/puma560_pick.toml")).unwrap();
    let hash = |scene: &SceneFile| scene.hash(&scene.robot.model::<6>().unwrap());
    let changed = |change: &dyn Fn(&mut SceneFile)| {
        let mut other = scene.clone();
        change(&mut other);
        hash(&other)
    };
    let same = hash(&scene);
    let mut felt = vec![
        changed(&|s| s.control.law = dynamics_core::control::ControlLaw::Pd),
        changed(&|s| s.control.law = dynamics_core::control::ControlLaw::DiagonalInertia),
        changed(&|s| s.control.model_every = 2),
        changed(&|s| s.control.model_every = 4),
        changed(&|s| (s.control.model_every, s.control.model_between) = (4, Between::Extrapolate)),
        changed(&|s| s.control.trig = dynamics_core::trig::Method::Libm),
        changed(&|s| s.control.rate = 2000.0),
        changed(&|s| s.control.damping[3] = 0.9),
        changed(&|s| s.control.age_max = 3),
        changed(&|s| s.control.observer_bandwidth = 601.0),
        changed(&|s| s.control.integral = Some(integral(0.3))),
        changed(&|s| s.control.integral = Some(integral(0.4))),
        changed(&|s| s.model.friction = false),
        changed(&|s| s.model.rotor = dynamics_core::Term::Live),
        changed(&|s| s.model.gravity = dynamics_core::Term::Constant(Vector3::new(0.0, 0.0, -9.810_001))),
        changed(&|s| s.robot.joints[5].spec.body.mass = 0.090_000_01),
        changed(&|s| s.robot.joints[0].spec.limits.torque = 97.7),
        changed(&|s| s.robot.joints[2].encoder = None),
    ];
    felt.push(same);
    felt.sort_unstable();
    felt.dedup();
    assert_eq!(felt.len(), 19, "two changes gave one hash");
    let unfelt = [
        changed(&|s| s.name = "other".to_owned()),
        changed(&|s| s.seed = 7),
        changed(&|s| s.plant.payload = None),
        changed(&|s| s.sensors.position_noise = 1.0),
        changed(&|s| s.control.scalar = robot_compiler::scene::ScalarChoice::F64),
        // Without ticks between evaluations, this setting has no effect.
        changed(&|s| s.control.model_between = Between::Extrapolate),
        // Below the resolution of single precision.
        changed(&|s| s.robot.joints[5].spec.body.mass = 0.09 + 1e-13),
    ];
    assert_eq!(unfelt, [same; 7]);
}

#[test]
fn firmware_is_wrapped_where_the_model_is_evaluated_in_some_ticks_and_nowhere_else() {
    let scene = SceneFile::load(&top("scenes/puma560_slow_model.toml")).unwrap();
    let model = scene.robot.model::<6>().unwrap();
    let emitted = |change: &dyn Fn(&mut SceneFile)| {
        let mut other = scene.clone();
        change(&mut other);
        emit::dynamics_module(&other, &model)
    };
    let ends = |text: &str, end: &str| assert!(text.ends_with(end), "{}", &text[text.len().saturating_sub(500)..]);
    let value = "    EveryNth::new(inner, 4, Between::Extrapolate, &const { super::arm::config().gains })\n}\n";
    for (kernel, inner) in [
        (KernelChoice::Exact, "Kernel"),
        (KernelChoice::Regrouped, "Kernel"),
        (KernelChoice::Generic, "Dynamics<f32, 6>"),
    ] {
        let choose = |s: &mut SceneFile| s.control.kernel = kernel;
        let slow = emitted(&choose);
        assert!(slow.contains(&format!("pub type Arm = EveryNth<{inner}, f32, 6>;")), "{kernel:?}");
        ends(&slow, value);
        let plain = emitted(&|s| {
            choose(s);
            s.control.model_every = 1;
        });
        assert!(plain.contains(&format!("pub type Arm = {inner};")) && !plain.contains("EveryNth"), "{kernel:?}");
    }
}

#[test]
fn mass_in_the_gains_is_that_of_the_start() {
    let scene = SceneFile::load(&top("scenes/planar2r_swing.toml")).unwrap();
    let config = scene.controller_config(&scene.robot.model::<2>().unwrap());
    // Two rods stretched out: m1 l1^2/3 + m2 (l1^2 + l1 l2 + l2^2/3), and m2 l2^2/3.
    let outer = 1.5 * 0.8 * 0.8 / 3.0;
    let inner = 2.0 / 3.0 + 1.5 * (1.0 + 0.8) + outer;
    assert!((config.gains[0].inertia - inner).abs() < 1e-12 && (config.gains[1].inertia - outer).abs() < 1e-12);
    assert_eq!(config.gains[0].position, 900.0);
}

#[test]
fn emitted_source_is_as_rustfmt_would_leave_it() {
    let folder = std::env::temp_dir().join(format!("newtau-emit-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for scene in scenes() {
        let text = with_dof!(scene.robot.dof(), N => emit::arm_module(&scene, &scene.robot.model::<N>().unwrap()));
        let path = folder.join(format!("{}.rs", scene.name));
        std::fs::write(&path, &text).unwrap();
        let Some(status) = rustfmt(&[], [&path]) else { return };
        assert!(status.success(), "{}", path.display());
        let formatted = std::fs::read_to_string(&path).unwrap();
        for (number, (ours, theirs)) in text.lines().zip(formatted.lines()).enumerate() {
            assert_eq!(ours, theirs, "{} line {}", scene.name, number + 1);
        }
        assert_eq!(text, formatted, "{}", scene.name);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn the_arm_of_a_firmware_without_a_scene_is_what_is_written_from_the_pumas() {
    let folder = std::env::temp_dir().join(format!("newtau-arm-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    emit::write_firmware(&top("scenes/puma560_pick.toml"), emit::Choices::default(), &folder).unwrap();
    for name in ["arm.rs", "drives.rs", "dynamics.rs", "protection.rs", "tuning.rs"] {
        let shipped = std::fs::read_to_string(top("firmware/arm/puma560_pick").join(name)).unwrap();
        let written = std::fs::read_to_string(folder.join(name)).unwrap();
        assert_eq!(
            shipped, written,
            "{name}: `cargo newtau firmware build` leaves the right one below target/chip/source; copy it to firmware/arm/puma560_pick"
        );
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
