//! Source of a kernel in Rust or C, with a head that names arm and scene.

use super::c::kernel_source;
pub use super::kernel::writer::Language;
use super::kernel::{Title, module};
use crate::describe::scene::SceneFile;
use crate::kernel::{Function, Level, Precision, compile};
use dynamics_core::Model;

/// Source of a function of an arm in a scene, with a head that names both. `newtau model kernel` and Python's `Arm.kernel` print it.
#[must_use]
pub fn source<const N: usize>(
    language: Language,
    file: &SceneFile,
    model: &Model<f64, N>,
    function: Function,
    level: Level,
    precision: Precision,
) -> String {
    let scene = file.scene(model);
    let title = Title { robot: &file.robot.name, scene: &file.name, hash: file.hash(model) };
    match language {
        Language::Rust => module(function, model, &scene, level, precision, &title),
        Language::C => {
            let program = compile(function, model, &scene, level, precision);
            kernel_source(function, &program, N, precision, level, &title)
        }
    }
}
