//! Writes kernels of every shipped scene as modules, and the list of them as a macro.

use dynamics_core::Term;
use robot_compiler::emit::modules::Modules;
use robot_compiler::kernel::functions::Springs;
use robot_compiler::kernel::{Function, Level, Precision};
use robot_compiler::{SceneFile, with_dof};
use std::error::Error;
use std::fmt::Write;
use std::path::PathBuf;

/// Scene with a kernel of every function.
const EVERY_FUNCTION: &str = "stanford_reach";
/// Scenes with kernels for every scalar.
const EVERY_SCALAR: [&str; 4] = ["ur5_wave", "puma560_pick", "stanford_reach", "scara_pick"];
/// Scene with an additional kernel in which every term is live.
const LIVE: &str = "puma560_pick";

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR")?).join("../..");
    let folder = PathBuf::from(std::env::var("OUT_DIR")?);
    println!("cargo::rerun-if-changed={}", root.join("scenes").display());
    println!("cargo::rerun-if-changed={}", root.join("robots").display());
    let mut scenes: Vec<PathBuf> =
        std::fs::read_dir(root.join("scenes"))?.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>()?;
    scenes.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    scenes.sort();
    let (mut modules, mut list) = (Modules::new(folder), String::new());
    for (number, path) in scenes.iter().enumerate() {
        let scene = SceneFile::load(path)?;
        // Each scene gets both levels, each in one precision; the assignment alternates.
        let precisions = if number % 2 == 0 {
            [Precision::Single, Precision::Double]
        } else {
            [Precision::Double, Precision::Single]
        };
        for (level, precision) in Level::ALL.into_iter().zip(precisions) {
            let name = modules.kernel(&scene, Function::InverseDynamics, level, precision)?;
            let (joints, real) = (scene.robot.dof(), precision.name());
            writeln!(list, "        $check!({name}, {:?}, {joints}, {real}, {level:?});", scene.name)?;
        }
        if EVERY_SCALAR.contains(&scene.name.as_str()) {
            for level in Level::ALL {
                modules.generic_kernel(&scene, Function::InverseDynamics, level)?;
            }
        }
        if scene.name == LIVE {
            let scene = &all_live(scene.clone());
            for level in Level::ALL {
                modules.kernel(scene, Function::InverseDynamics, level, Precision::Single)?;
                modules.generic_kernel(scene, Function::InverseDynamics, level)?;
            }
        }
        if scene.name == EVERY_FUNCTION {
            let springs = with_dof!(scene.robot.dof(), N => {
                Springs::new(&scene.controller_config(&scene.robot.model::<N>()?).gains)
            });
            let every = Function::ALL.into_iter().chain([Function::Regressor, Function::ComputedTorque(springs)]);
            for (function, level) in every.flat_map(|f| Level::ALL.map(|level| (f, level))) {
                if function != Function::InverseDynamics {
                    modules.kernel(&scene, function, level, Precision::Double)?;
                }
            }
        }
    }
    modules.finish(&format!(
        "/// `check!(module, scene, joints, scalar, level)` for every inverse dynamics.\n\
         #[macro_export]\nmacro_rules! every_kernel {{\n    ($check:ident) => {{\n{list}    }};\n}}\n"
    ))
}

fn all_live(mut scene: SceneFile) -> SceneFile {
    scene.name = "all_live".to_owned();
    scene.model.gravity = Term::Live;
    scene.model.payload = Term::Live;
    scene.model.tip_wrench = Term::Live;
    scene.model.rotor = Term::Live;
    scene
}
