//! Controllers written out in the scene's own scalar, and many of them in one program.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]

use dynamics_core::Sensed;
use robot_compiler::SceneFile;
use robot_compiler::emit::cost::{COUNTED, RUN_UP, difference, inputs, write_program_of};
use robot_compiler::emit::{arm_module, arm_module_in, dynamics_module, dynamics_module_in};
use robot_compiler::scene::ScalarChoice;
use std::path::PathBuf;

use crate::common::top;

fn puma() -> SceneFile {
    SceneFile::load(&top("scenes/puma560_pick.toml")).unwrap()
}

/// The numbers in a text, as text.
fn numbers(text: &str) -> Vec<&str> {
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || ".-_".contains(c)));
    words.filter(|word| word.contains(['.', 'e']) && word.parse::<f64>().is_ok()).collect()
}

#[test]
fn a_controller_in_f64_has_the_numbers_of_the_file_and_nothing_of_f32() {
    let scene = puma();
    let model = scene.robot.model::<6>().unwrap();
    assert_eq!(arm_module_in(&scene, &model, ScalarChoice::F32), arm_module(&scene, &model));
    assert_eq!(dynamics_module_in(&scene, &model, ScalarChoice::F32), dynamics_module(&scene, &model));
    let arm = arm_module_in(&scene, &model, ScalarChoice::F64);
    let dynamics = dynamics_module_in(&scene, &model, ScalarChoice::F64);
    assert!(!arm.contains("f32") && !dynamics.contains("f32"));
    assert!(arm.contains("Model<f64, N>") && dynamics.contains("InverseDynamics<f64, 6> for Kernel"));
    let written: Vec<f64> = numbers(&arm).iter().map(|word| word.parse().unwrap()).collect();
    for link in model.links() {
        for x in link.rotation.iter().chain(&link.inertia.about_origin).chain([&link.inertia.mass, &link.rotor]) {
            assert!(written.iter().any(|read| read.to_bits() == x.to_bits()), "{x} is not in the text");
        }
    }
    // The reverse: in f32 some numbers of the same file would lose bits.
    assert!(written.iter().any(|x| f64::from(*x as f32).to_bits() != x.to_bits()));
}

#[test]
fn the_ticks_follow_the_motion_to_where_it_is_fastest() {
    let scene = puma();
    let model = scene.robot.model::<6>().unwrap();
    let ticks = inputs(&scene, &model).unwrap();
    assert_eq!(ticks.len(), RUN_UP + COUNTED);
    let per_count = scene.controller_config(&model).encoder.map(|encoder| encoder.per_count);
    let shares = |velocity: &[f64; 6]| -> f64 {
        let limits = model.links().map(|link| link.limits.velocity);
        velocity.iter().zip(limits).map(|(v, limit)| (v / limit).powi(2)).sum()
    };
    for pair in ticks.windows(2) {
        assert!(shares(&pair[0].reference.qd) < shares(&pair[1].reference.qd));
        for i in 0..6 {
            let moved = pair[1].reference.q[i] - pair[0].reference.q[i];
            let mean = (pair[1].reference.qd[i] + pair[0].reference.qd[i]) / 2.0;
            assert!((moved - mean * scene.period()).abs() < 1e-6, "consecutive ticks");
        }
    }
    for tick in &ticks {
        let Sensed::Counts(counts) = tick.measurement::<f32>().sensed else { unreachable!("the scene has encoders") };
        for i in 0..6 {
            let off = tick.reference.q[i] - f64::from(counts[i]) * per_count[i];
            assert!(off.abs() <= 0.5001 * per_count[i]);
        }
    }
    let mut exact = puma();
    exact.sensors.encoder = false;
    let tick = inputs(&exact, &model).unwrap()[0];
    assert_eq!(tick.measurement::<f64>().sensed, Sensed::State { q: tick.reference.q, qd: tick.reference.qd });
}

#[test]
fn scenes_that_cannot_share_their_ticks_are_refused_by_name() {
    let paths: Vec<PathBuf> =
        ["puma560_pick", "puma560_ideal", "planar2r_swing"].map(|n| top(&format!("scenes/{n}.toml"))).into();
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("emitted_scalars");
    std::fs::create_dir_all(&folder).unwrap();
    let refused = |paths: &[PathBuf]| write_program_of(paths, &folder).unwrap_err().to_string();
    let said = refused(&[paths[0].clone(), paths[2].clone()]);
    assert!(said.contains("planar2r_swing.toml: robot: not that of ") && said.contains("puma560_pick.toml"), "{said}");
    assert!(refused(&[]).contains("no scene"));
    assert!(refused(&[folder.join("none.toml")]).contains("none.toml"));

    let one = puma();
    assert_eq!(difference(&one, &one), None);
    let mut other = puma();
    other.control.rate = 500.0;
    assert_eq!(difference(&one, &other), Some("control.rate"));
    let mut other = puma();
    other.sensors.encoder = false;
    assert_eq!(difference(&one, &other), Some("sensors"));
    assert_eq!(difference(&one, &SceneFile { duration: Some(0.5), ..puma() }), Some("duration"));

    // The settings that a trade-off varies do not count as differences.
    let mut other = puma();
    other.control.scalar = ScalarChoice::F64;
    other.model.friction = false;
    assert_eq!(difference(&one, &other), None);
    write_program_of(&paths[..1], &folder).unwrap();
    let text = std::fs::read_to_string(folder.join("kernels.rs")).unwrap();
    assert_eq!(text.matches("Row {").count(), RUN_UP + COUNTED);
    assert!(text.contains("scene!(0, tick_0, f32);"));
}
