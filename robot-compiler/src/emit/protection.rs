//! Collision watch of the arm.

use super::fields::item;
use super::kernel::{Title, module};
use crate::describe::scene::SceneFile;
use crate::kernel::{Function, Level, Precision};
use dynamics_core::Model;

/// Rust source of a module with the arm's collision watch, for use together with [`arm_module`](super::arm_module).
///
/// | item | meaning |
/// |---|---|
/// | `Protection` | a type that implements `Protection<f32, N>`: a collision watch if the scene has one, otherwise `Unprotected` |
/// | `protection()` | its value |
#[must_use]
pub fn protection_module<const N: usize>(file: &SceneFile, model: &Model<f64, N>) -> String {
    let Some(config) = file.collision_config::<N>() else {
        return "//! Nothing watches the arm.\n\nuse dynamics_core::control::Unprotected;\n\n\
                /// No protection.\npub type Protection = Unprotected;\n\n\
                /// No protection.\npub const fn protection() -> Protection {\n    Unprotected\n}\n"
            .to_owned();
    };
    let (text, momentum, value) = match file.control.kernel.level() {
        None => (
            "//! Momentum by the recursion itself, with the model at run time.\n\nuse dynamics_core::Dynamics;\n"
                .to_owned(),
            format!("Dynamics<f32, {N}>"),
            "Dynamics::new(super::arm::model(), super::arm::scene())",
        ),
        // Exact at every level, because the desk uses the recursion.
        Some(_) => {
            let title = Title { robot: &file.robot.name, scene: &file.name, hash: file.hash(model) };
            let (scene, precision) = (file.scene(model), Precision::Single);
            let kernel = module(Function::Momentum, model, &scene, Level::Exact, precision, &title);
            (kernel, "Kernel".to_owned(), "Kernel")
        }
    };
    format!(
        "{text}\nuse dynamics_core::control::{{CollisionConfig, CollisionConfiguration, CollisionWatch, MomentumFilter, CollisionReaction}};\n\n\
         /// When something has been hit, as constants of the program.\n\
         #[derive(Clone, Copy, Debug, PartialEq, Eq)]\npub struct Thresholds;\n\n\
         impl CollisionConfiguration<f32, {N}> for Thresholds {{\n    #[inline]\n    \
         fn get(&self) -> &CollisionConfig<f32, {N}> {{\n        const {{ &{} }}\n    }}\n}}\n\n\
         /// Watch for collisions of the arm.\npub type Protection = CollisionWatch<f32, {N}, {momentum}, Thresholds>;\n\n\
         /// The watch for collisions, at its start.\npub fn protection() -> Protection {{\n    CollisionWatch::new(Thresholds, {value})\n}}\n",
        item(&config.cast::<f32>()).print(8),
    )
}
