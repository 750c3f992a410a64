//! The kernels' source: its contents, and that rustfmt does not change it.
#![allow(clippy::unwrap_used, reason = "a broken shipped file should stop the test")]

use dynamics_core::Term;
use robot_compiler::emit::kernel::{Title, generic_module, module};
use robot_compiler::kernel::{Function, Level, Precision};
use robot_compiler::{Robot, SceneFile, with_dof};

use std::collections::BTreeSet;

use crate::common::{compare_output, files, rustfmt, top};

fn text(file: &SceneFile, function: Function, level: Level, precision: Precision) -> String {
    with_dof!(file.robot.dof(), N => {
        let model = file.robot.model::<N>().unwrap();
        let title = Title { robot: &file.robot.name, scene: &file.name, hash: 0x0123_4567_89ab_cdef };
        module(function, &model, &file.scene(&model), level, precision, &title)
    })
}

fn generic_text(file: &SceneFile, function: Function, level: Level, precision: Precision) -> String {
    with_dof!(file.robot.dof(), N => {
        let model = file.robot.model::<N>().unwrap();
        let title = Title { robot: &file.robot.name, scene: &file.name, hash: 0x0123_4567_89ab_cdef };
        generic_module(function, &model, &file.scene(&model), level, precision, &title)
    })
}

fn default_scene(robot: &str) -> SceneFile {
    SceneFile::default_for(Robot::load(&top(&format!("robots/{robot}.toml"))).unwrap())
}

#[test]
fn planar_arm_as_an_exact_kernel() {
    let text = text(&default_scene("planar2r"), Function::InverseDynamics, Level::Exact, Precision::Single);
    compare_output("planar_arm_as_an_exact_kernel", text);
}

#[test]
fn scara_as_a_regrouped_kernel() {
    let text = text(&default_scene("scara"), Function::InverseDynamics, Level::Regrouped, Precision::Double);
    compare_output("scara_as_a_regrouped_kernel", text);
}

#[test]
fn mass_matrix_of_the_planar_arm() {
    let text = text(&default_scene("planar2r"), Function::MassMatrix, Level::Exact, Precision::Single);
    compare_output("mass_matrix_of_the_planar_arm", text);
}

#[test]
fn planar_arm_as_a_regrouped_kernel_for_every_scalar() {
    let text = generic_text(&default_scene("planar2r"), Function::InverseDynamics, Level::Regrouped, Precision::Double);
    compare_output("planar_arm_as_a_regrouped_kernel_for_every_scalar", text);
}

/// A shipped scene of each robot, and a copy of each with every term live. Tracing takes most of the time, and the other scenes of a robot have
/// nearly the same source.
fn scenes() -> Vec<SceneFile> {
    let mut shipped: Vec<_> =
        files(&top("scenes"), &["toml"]).iter().map(|path| SceneFile::load(path).unwrap()).collect();
    let mut robots = BTreeSet::new();
    shipped.retain(|file| robots.insert(file.robot.name.clone()));
    assert!(shipped.len() >= 8);
    let live = shipped.iter().cloned().map(|mut file| {
        file.name += "_live";
        let terms = &mut file.model;
        (terms.gravity, terms.payload, terms.tip_wrench) = (Term::Live, Term::Live, Term::Live);
        terms.rotor = Term::Live;
        file
    });
    shipped.iter().cloned().chain(live).collect()
}

#[test]
fn kernels_are_as_rustfmt_would_leave_them() {
    let folder = std::env::temp_dir().join(format!("newtau-kernels-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut written = Vec::new();
    for (number, file) in scenes().iter().enumerate() {
        for function in Function::ALL {
            for level in Level::ALL {
                let precision = if number % 2 == 0 { Precision::Single } else { Precision::Double };
                let name = format!("{}_{}_{}", file.name, function.name(), level.name());
                let texts = [
                    ("", text(file, function, level, precision)),
                    ("_generic", generic_text(file, function, level, precision)),
                ];
                for (kind, text) in texts {
                    let path = folder.join(format!("{name}{kind}.rs"));
                    std::fs::write(&path, &text).unwrap();
                    written.push((path, text));
                }
            }
        }
    }
    let Some(status) = rustfmt(&[], written.iter().map(|(path, _)| path)) else { return };
    assert!(status.success());
    for (path, text) in &written {
        let formatted = std::fs::read_to_string(path).unwrap();
        for (number, (ours, theirs)) in text.lines().zip(formatted.lines()).enumerate() {
            assert_eq!(ours, theirs, "{} line {}", path.display(), number + 1);
        }
        assert_eq!(*text, formatted, "{}", path.display());
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
