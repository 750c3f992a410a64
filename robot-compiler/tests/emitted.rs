//! An emitted module, compiled and compared with its source.
//!
//! `tests/data/emitted_arm.rs` is the output of `emit::arm_module` for one scene. Write it again with
//! `UPDATE_EMITTED=1 cargo test -p robot-compiler --test emitted`, and check the diff.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]
#![allow(clippy::float_cmp, reason = "the emitted numbers must be the very same")]

use robot_compiler::{SceneFile, emit};

#[path = "data/emitted_arm.rs"]
#[allow(unreachable_pub, reason = "written for a crate of its own")]
mod emitted_arm;

use crate::common::top;

#[test]
fn emitted_module_holds_the_very_bits_of_the_file() {
    let scene = SceneFile::load(&top("scenes/scara_pick.toml")).unwrap();
    let model = scene.robot.model::<4>().unwrap();
    let text = emit::arm_module(&scene, &model);
    let path = top("robot-compiler/tests/data/emitted_arm.rs");
    if std::env::var_os("UPDATE_EMITTED").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    assert_eq!(text, std::fs::read_to_string(&path).unwrap(), "the emitted source has changed");
    assert_eq!(emitted_arm::N, 4);
    assert_eq!(emitted_arm::NAME, "scara_pick");
    assert_eq!(emitted_arm::ROBOT, "generic SCARA");
    assert_eq!(emitted_arm::RATE_HZ, 1000.0);
    assert_eq!(emitted_arm::HASH, scene.hash(&model));
    assert_eq!(emitted_arm::TRIG, dynamics_core::trig::Polynomial);
    assert_eq!(emitted_arm::model(), model.cast::<f32>());
    assert_eq!(emitted_arm::scene(), scene.scene(&model).cast::<f32>());
    assert_eq!(emitted_arm::config(), scene.controller_config(&model).cast::<f32>());
    assert_eq!(emitted_arm::rules(), scene.safety_rules(&model).cast::<f32>());
}
