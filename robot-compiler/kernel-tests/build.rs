//! Writes kernels of every shipped scene as modules, and the list of them as a macro.

use dynamics_core::Term;
use robot_compiler::kernel::source::{Title, module};
use robot_compiler::kernel::{Function, Level, Precision};
use robot_compiler::{SceneFile, with_dof};
use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The scene of which every function is written.
const EVERY_FUNCTION: &str = "stanford_reach";
/// The scene of which a kernel is written with everything live.
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
    let (mut modules, mut list) = (String::new(), String::new());
    for (number, path) in scenes.iter().enumerate() {
        let scene = SceneFile::load(path)?;
        // Both levels in both precisions, one of each pair for every scene.
        let precisions = if number % 2 == 0 {
            [Precision::Single, Precision::Double]
        } else {
            [Precision::Double, Precision::Single]
        };
        for (level, precision) in Level::ALL.into_iter().zip(precisions) {
            let kernel = Kernel { scene: &scene, function: Function::InverseDynamics, level, precision };
            let name = kernel.write(&folder, &mut modules)?;
            let (joints, real) = (scene.robot.dof(), real(precision));
            writeln!(list, "        $check!({name}, {:?}, {joints}, {real}, {level:?});", scene.name)?;
        }
        if scene.name == LIVE {
            let scene = &all_live(scene.clone());
            for level in Level::ALL {
                let precision = Precision::Single;
                Kernel { scene, function: Function::InverseDynamics, level, precision }.write(&folder, &mut modules)?;
            }
        }
        if scene.name == EVERY_FUNCTION {
            for (function, level) in Function::ALL.into_iter().flat_map(|f| Level::ALL.map(|level| (f, level))) {
                if function != Function::InverseDynamics {
                    Kernel { scene: &scene, function, level, precision: Precision::Double }
                        .write(&folder, &mut modules)?;
                }
            }
        }
    }
    let text = format!(
        "{modules}\n/// `check!(module, scene, joints, scalar, level)` for every inverse dynamics.\n\
         #[macro_export]\nmacro_rules! every_kernel {{\n    ($check:ident) => {{\n{list}    }};\n}}\n"
    );
    std::fs::write(folder.join("kernels.rs"), text)?;
    Ok(())
}

fn all_live(mut scene: SceneFile) -> SceneFile {
    scene.name = "all_live".to_owned();
    scene.model.gravity = Term::Live;
    scene.model.payload = Term::Live;
    scene.model.tip_wrench = Term::Live;
    scene.model.rotor = Term::Live;
    scene
}

/// What is written into one module.
struct Kernel<'a> {
    scene: &'a SceneFile,
    function: Function,
    level: Level,
    precision: Precision,
}

impl Kernel<'_> {
    /// Write the module's file, declare the module, and give its name.
    fn write(&self, folder: &Path, modules: &mut String) -> Result<String, Box<dyn Error>> {
        let Self { scene, function, level, precision } = *self;
        let text = with_dof!(scene.robot.dof(), N => {
            let model = scene.robot.model::<N>()?;
            let title = Title { robot: &scene.robot.name, scene: &scene.name, hash: scene.hash(&model) };
            module(function, &model, &scene.scene(&model), level, precision, &title)
        });
        let name = format!("{}_{}_{}_{}", scene.name, function.name().replace('-', "_"), level.name(), real(precision));
        let path = folder.join(format!("{name}.rs"));
        std::fs::write(&path, text)?;
        writeln!(modules, "#[path = {path:?}]\npub mod {name};")?;
        Ok(name)
    }
}

const fn real(precision: Precision) -> &'static str {
    match precision {
        Precision::Single => "f32",
        Precision::Double => "f64",
    }
}
