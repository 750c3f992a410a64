//! A whole crate for one arm: model, inverse dynamics, controller and safety state machine, with a test and a README.

mod text;

use super::arm::arm_module_in;
use super::cost::{self, live_item};
use super::dynamics::dynamics_module_in;
use super::expression::{Float, Item, list};
use super::firmware::tuning_module;
use super::items::numbers;
use super::protection::protection_module;
use crate::describe::diagnostics::Message;
use crate::describe::scene::{ScalarChoice, SceneFile};
use crate::kernel::inputs::input_values;
use crate::kernel::{Function, Level, Operations, Program, compile};
use crate::with_dof;
use dynamics_core::trig::Method;
use dynamics_core::{Dynamics, InverseDynamics, Live, Model, Reference, Trig};
use std::path::{Path, PathBuf};
pub(super) use text::STATES;
use text::{ALLOWED, crate_name, head, manifest, readme, root};

/// Files of the crate, relative to its folder, with their text; and the operations of its inverse dynamics, if they are a kernel.
#[derive(Clone, Debug)]
pub struct ArmCrate {
    /// Path and text of each file.
    pub files: Vec<(&'static str, String)>,
    /// Operations of one evaluation of the inverse dynamics; `None` for the recursion.
    pub operations: Option<Operations>,
    /// The crate's name.
    pub name: String,
    /// Items of `src/lib.rs` below the declarations of its modules.
    root: String,
}

/// Writes a `no_std` crate for the arm of a scene, in this scalar. It depends on `dynamics-core` alone; `core` is that package's folder, `None` for
/// the registry's.
///
/// | file | content |
/// |---|---|
/// | `Cargo.toml` | a workspace of its own |
/// | `src/lib.rs` | `inverse_dynamics`, `gravity`, `controller`, `safety` |
/// | `src/arm.rs`, `dynamics.rs`, `protection.rs`, `tuning.rs` | numbers and kernel |
/// | `tests/golden.rs` | torques of eight states, to the last bit |
/// | `README.md` | use and cost |
///
/// # Errors
/// An impossible arm, a motion that is not possible, a scene for the bench alone, or collision detection in double precision.
// `inline`: compiled for six joint counts by the packages that use it. `newtau run`, which a new user compiles first, does not.
#[inline]
pub fn arm_crate(
    file: &SceneFile,
    scalar: ScalarChoice,
    core: Option<&Path>,
) -> Result<ArmCrate, Box<dyn std::error::Error>> {
    if file.collision.is_some() && scalar == ScalarChoice::F64 {
        let path = file.path.display();
        let problem = format!("{path}: [collision] is emitted for f32 only; expected --scalar f32, or no [collision]");
        return Err(Message(problem).into());
    }
    if file.safety.bench_only {
        let path = file.path.display();
        return Err(Message(format!(
            "{path}: safety.bench_only: its bounds on old measurements are lifted, which no arm may be driven with; expected `bench_only = false`"
        ))
        .into());
    }
    with_dof!(file.robot.dof(), N => match scalar {
        ScalarChoice::F32 => of::<f32, N>(file, scalar, core),
        ScalarChoice::F64 => of::<f64, N>(file, scalar, core),
    })
}

fn of<S: Float, const N: usize>(
    file: &SceneFile,
    scalar: ScalarChoice,
    core: Option<&Path>,
) -> Result<ArmCrate, Box<dyn std::error::Error>>
where
    Method: Trig<S>,
{
    let model = file.robot.model::<N>()?;
    let name = crate_name(&file.name);
    let compiled = |level| compile(Function::InverseDynamics, &model, &file.scene(&model), level, scalar.precision());
    let program = file.control.kernel.level().map(compiled);
    let operations = program.as_ref().map(Program::operations);
    // A regrouped kernel rounds otherwise than the recursion.
    let rounds_otherwise = program.filter(|_| file.control.kernel.level() == Some(Level::Regrouped));
    let live = (file.model.live_inputs() > 0).then(|| live_item::<S, N>(&file.live(&model)).print(4));
    let is_live = live.is_some();
    // Paths of nalgebra go through the core: the crate needs no second dependency, and gets the core's version of it.
    let through_core = |text: String| text.replace("use nalgebra::", "use dynamics_core::nalgebra::");
    let root = root(S::NAME, live.as_deref());
    let states = golden_states::<S, N>(file, &model, is_live, rounds_otherwise.as_ref())?;
    let files = vec![
        ("Cargo.toml", manifest(&name, &file.robot.name, core)),
        ("README.md", readme(file, &name, S::NAME, operations, is_live)),
        ("src/lib.rs", head(file, S::NAME) + &root),
        ("src/arm.rs", through_core(arm_module_in(file, &model, scalar))),
        ("src/dynamics.rs", through_core(dynamics_module_in(file, &model, scalar))),
        (
            "src/protection.rs",
            through_core(format!("//! Watch for collisions.\n\n{}", body(&protection_module(file, &model)))),
        ),
        (
            "src/tuning.rs",
            format!("//! Where the controller's configuration is.\n\n{}", tuning_module(file.control.tunable, S::NAME)),
        ),
        ("tests/golden.rs", golden(&states, &name, is_live)),
    ];
    Ok(ArmCrate { files, operations, name, root })
}

/// The text without the documentation of its module.
fn body(text: &str) -> String {
    text.lines()
        .filter(|line| !line.starts_with("//!"))
        .flat_map(|line| [line, "\n"])
        .collect::<String>()
        .trim_start()
        .to_owned()
}

/// States along the scene's motion and their torques, as the desk computes them, by `program` or by the recursion: position, velocity, acceleration,
/// torque.
pub(super) fn golden_states<S: Float, const N: usize>(
    file: &SceneFile,
    model: &Model<f64, N>,
    is_live: bool,
    program: Option<&Program>,
) -> Result<Vec<[[S; N]; 4]>, Box<dyn std::error::Error>>
where
    Method: Trig<S>,
{
    let rows = cost::inputs(file, model).map_err(|error| Message(format!("{}: {error}", file.path.display())))?;
    let recursion = Dynamics::new(model.cast::<S>(), file.scene(model).cast::<S>());
    let given = if is_live { file.live(model).cast() } else { Live::zero() };
    let state = |Reference { q, qd, qdd }: Reference<S, N>| {
        let turn = file.control.trig.sin_cos_all(&q);
        let tau = match program {
            Some(program) => {
                let outputs = program.evaluate(&input_values(&turn, &q, &qd, &qdd, &given));
                core::array::from_fn(|joint| outputs[joint])
            }
            None => recursion.inverse_dynamics(&turn, &q, &qd, &qdd, &given),
        };
        [q, qd, qdd, tau]
    };
    let every = rows.len().div_ceil(STATES);
    Ok(rows.iter().step_by(every).map(|row| state(row.reference.cast::<S>())).collect())
}

/// The test: states and their torques.
fn golden<S: Float, const N: usize>(states: &[[[S; N]; 4]], name: &str, is_live: bool) -> String {
    let items: Vec<Item> = states.iter().map(|state| list(state.iter().map(|row| numbers(row)).collect())).collect();
    let (count, real, module) = (states.len(), S::NAME, name.replace('-', "_"));
    let pass = if is_live { ", &live()" } else { "" };
    let also = if is_live { ", live" } else { "" };
    format!(
        "//! Torques of {count} states, as the desk computed them when this crate was written.\n#![allow(clippy::excessive_precision, clippy::approx_constant, reason = \"generated numbers\")]\n\n\
         use {module}::{{N, inverse_dynamics{also}}};\n\n\
         /// Position, velocity, acceleration, and the torque that they need.\nconst STATES: [[[{real}; N]; 4]; {count}] = {};\n\n\
         #[test]\nfn torques_are_those_of_the_desk() {{\n    for [q, qd, qdd, tau] in STATES {{\n        \
         assert_eq!(inverse_dynamics(&q, &qd, &qdd{pass}), tau);\n    }}\n}}\n",
        list(items).print(0)
    )
}

/// Writes the same modules for the crate that is being built: call it in `build.rs`, and include `arm.rs` of `OUT_DIR`.
///
/// ```no_run
/// // build.rs
/// robot_compiler::emit::build_arm("arm/move.toml");
/// ```
/// ```ignore
/// // src/main.rs
/// include!(concat!(env!("OUT_DIR"), "/arm.rs")); // modules arm, dynamics, ...; inverse_dynamics(), controller(), safety()
/// ```
///
/// Cargo builds again if the scene or its robot file changes. A mistake in them ends the build with a message that names file, line and key.
pub fn build_arm(scene: impl AsRef<Path>) {
    let scene = scene.as_ref();
    // Also after a mistake: a corrected file is read again.
    println!("cargo::rerun-if-changed={}", scene.display());
    let written = match std::env::var_os("OUT_DIR") {
        Some(folder) => write_arm(scene, Path::new(&folder)),
        None => Err("OUT_DIR is not set: call this in a build script".into()),
    };
    match written {
        Ok(read) => read.iter().for_each(|file| println!("cargo::rerun-if-changed={}", file.display())),
        Err(error) => {
            for line in error.to_string().lines() {
                println!("cargo::error={line}");
            }
            std::process::exit(1);
        }
    }
}

/// Writes `arm.rs` and its modules for a scene into a folder, and returns the files that were read. [`build_arm`] does this in a build script.
///
/// # Errors
/// As [`arm_crate`]; a scene that cannot be read, with file, line and key; a folder that cannot be written to.
pub fn write_arm(scene: &Path, folder: &Path) -> Result<Vec<PathBuf>, Box<dyn std::error::Error>> {
    let file = SceneFile::load(scene).map_err(|error| Message(format!("{error}; expected {}", error.expected())))?;
    write_arm_of(&file, folder)?;
    Ok(vec![scene.to_owned(), file.robot.path])
}

/// As [`write_arm`], for a scene that was read before.
///
/// # Errors
/// As [`arm_crate`]; a folder that cannot be written to.
pub fn write_arm_of(file: &SceneFile, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let arm = arm_crate(file, file.control.scalar, None)?;
    let mut root_text = String::new();
    for (name, text) in &arm.files {
        let Some(module) = name.strip_prefix("src/") else { continue };
        if module == "lib.rs" {
            continue;
        }
        let path = folder.join(format!("newtau_{module}"));
        super::changed::write_changed(&path, text)?;
        root_text += &format!("{ALLOWED}#[path = {path:?}]\npub mod {};\n", module.trim_end_matches(".rs"));
    }
    root_text += &format!("\n{}", arm.root);
    super::changed::write_changed(&folder.join("arm.rs"), &root_text)?;
    Ok(())
}
