//! A whole crate for one arm: model, inverse dynamics, controller and safety state machine, with a test and a README.

use super::arm::arm_module_in;
use super::cost::{self, live_item};
use super::dynamics::dynamics_module_in;
use super::expression::{Float, Item, list};
use super::firmware::tuning_module;
use super::items::numbers;
use super::protection::protection_module;
use crate::describe::scene::{KernelMemory, ScalarChoice, SceneFile};
use crate::kernel::inputs::input_values;
use crate::kernel::{Function, Level, Operations, compile};
use crate::with_dof;
use dynamics_core::trig::Method;
use dynamics_core::{Dynamics, InverseDynamics, Live, Model, Reference, Trig};
use std::path::{Path, PathBuf};

/// Number of states in the emitted test.
const STATES: usize = 8;

/// Everything that the emitted modules may import without use.
const ALLOWED: &str = "#[allow(\n    unused_imports,\n    clippy::approx_constant,\n    clippy::excessive_precision,\n    \
                       reason = \"generated: holds what any scene may need\"\n)]\n";

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
pub fn arm_crate(
    file: &SceneFile,
    scalar: ScalarChoice,
    core: Option<&Path>,
) -> Result<ArmCrate, Box<dyn std::error::Error>> {
    if file.collision.is_some() && scalar == ScalarChoice::F64 {
        let path = file.path.display();
        return Err(
            format!("{path}: [collision] is emitted for f32 only; expected --scalar f32, or no [collision]").into()
        );
    }
    if file.safety.bench_only {
        let path = file.path.display();
        return Err(format!(
            "{path}: safety.bench_only: its bounds on old measurements are lifted, which no arm may be driven with; expected `bench_only = false`"
        )
        .into());
    }
    // Which memory the kernel runs from is for the linker script of the firmware that uses the crate.
    let mut file = file.clone();
    file.control.kernel_memory = KernelMemory::Flash;
    with_dof!(file.robot.dof(), N => match scalar {
        ScalarChoice::F32 => of::<f32, N>(&file, scalar, core),
        ScalarChoice::F64 => of::<f64, N>(&file, scalar, core),
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
    let operations = file.control.kernel.level().map(|level| {
        compile(Function::InverseDynamics, &model, &file.scene(&model), level, scalar.precision()).operations()
    });
    let live = (file.model.live_inputs() > 0).then(|| live_item::<S, N>(&file.live(&model)).print(4));
    let is_live = live.is_some();
    // Paths of nalgebra go through the core: the crate needs no second dependency, and gets the core's version of it.
    let through_core = |text: String| text.replace("use nalgebra::", "use dynamics_core::nalgebra::");
    let root = root(S::NAME, live.as_deref());
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
        ("tests/golden.rs", golden::<S, N>(file, &model, &name, is_live)?),
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

/// A name that cargo accepts: letters, digits and hyphens, not starting with a digit.
fn crate_name(scene: &str) -> String {
    let clean: String =
        scene.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect();
    let clean = clean.trim_matches('-');
    if clean.starts_with(|c: char| c.is_ascii_alphabetic()) { format!("{clean}-arm") } else { format!("arm-{clean}") }
}

fn manifest(name: &str, robot: &str, core: Option<&Path>) -> String {
    let version = env!("CARGO_PKG_VERSION");
    // As TOML writes a string, which is not as Rust does.
    let quoted = |text: String| toml_edit::Value::from(text).to_string();
    let path = core.map_or(String::new(), |path| format!(", path = {}", quoted(path.display().to_string())));
    format!(
        "# Generated by `newtau emit arm`.\n[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\npublish = false\n\
         description = {}\n\n[dependencies]\n\
         # If this folder moves to another computer, give the path of dynamics-core there.\ndynamics-core = {{ version = \"{version}\"{path} }}\n\n\
         # A workspace of its own: delete this line to make it a member of yours.\n[workspace]\n",
        quoted(format!("Dynamics and control of {robot}")),
    )
}

/// Head of `lib.rs`: documentation and modules.
fn head(file: &SceneFile, real: &str) -> String {
    let (robot, scene) = (&file.robot.name, &file.name);
    format!(
        "//! {robot} in the scene {scene}, in `{real}`: inverse dynamics, controller and safety state machine.\n//!\n\
         //! Generated by `newtau emit arm`. Do not edit: change the robot and scene files, and emit it again.\n\
         #![no_std]\n#![forbid(unsafe_code)]\n\n{ALLOWED}pub mod arm;\n{ALLOWED}pub mod dynamics;\n{ALLOWED}pub mod protection;\n\
         {ALLOWED}pub mod tuning;\n\n"
    )
}

/// The items that use the modules `arm`, `dynamics`, `protection` and `tuning` of the same parent.
fn root(real: &str, live: Option<&str>) -> String {
    let (argument, value, told) = if live.is_some() {
        (
            format!(", live: &Live<{real}, N>"),
            "live",
            "/// `live` holds the loads that the scene calls live: what the arm carries, gravity, the wrench at the tip, rotors.\n",
        )
    } else {
        (String::new(), "&Live::zero()", "")
    };
    let pass = if live.is_some() { ", live" } else { "" };
    let (live_imports, live_function, start) = match live {
        Some(value) => (
            "#[allow(unused_imports, reason = \"generated: holds what any scene may need\")]\n\
             use dynamics_core::nalgebra::{Matrix3, Vector3};\n\
             #[allow(unused_imports, reason = \"generated: holds what any scene may need\")]\n\
             use dynamics_core::{Inertia, Wrench};\n",
            format!(
                "/// Loads that the scene calls live, as its simulated arm has them. Change what changes on your arm: what it carries, the direction of gravity.\n\
                 #[must_use]\npub fn live() -> Live<{real}, N> {{\n    {value}\n}}\n\n"
            ),
            "let mut controller = Controller::built(tuning::tuning(), dynamics::arm(), TRIG, protection::protection());\n    \
             *controller.live_mut() = live();\n    controller",
        ),
        None => {
            ("", String::new(), "Controller::built(tuning::tuning(), dynamics::arm(), TRIG, protection::protection())")
        }
    };
    format!(
        "use dynamics_core::control::{{ArmBuild, Configuration, Controller, ControllerConfig}};\n\
         use dynamics_core::safety::{{Rules, Safety, SafetyConfiguration}};\n\
         use dynamics_core::{{InverseDynamics, Live, Trig as _}};\n{live_imports}\n\
         pub use arm::{{N, NAME, RATE_HZ, ROBOT, TRIG}};\n\n\
         {live_function}/// Torque of each joint for a motion, N m (N for a prismatic joint): `D(q) qdd + C(q, qd) qd + G(q)`, with the terms and loads of the scene's `[model]`.\n\
         /// Without the friction of the joints. `q`, `qd`, `qdd` in rad, rad/s, rad/s^2, or m, m/s, m/s^2.\n{told}\
         #[must_use]\n\
         pub fn inverse_dynamics(q: &[{real}; N], qd: &[{real}; N], qdd: &[{real}; N]{argument}) -> [{real}; N] {{\n    \
         dynamics::arm().inverse_dynamics(&TRIG.sin_cos_all(q), q, qd, qdd, {value})\n}}\n\n\
         /// Torque of each joint that holds the arm at rest, N m (N for a prismatic joint), as far as the scene's `[model]` has gravity and loads.\n#[must_use]\n\
         pub fn gravity(q: &[{real}; N]{argument}) -> [{real}; N] {{\n    \
         inverse_dynamics(q, &[0.0; N], &[0.0; N]{pass})\n}}\n\n\
         /// Configuration of the controller and of the safety state machine, as constants of the program.\n\
         #[derive(Clone, Copy, Debug, PartialEq, Eq)]\npub struct Settings;\n\n\
         impl Configuration<{real}, N> for Settings {{\n    #[inline]\n    fn get(&self) -> &ControllerConfig<{real}, N> {{\n        \
         const {{ &arm::config() }}\n    }}\n}}\n\n\
         impl SafetyConfiguration<{real}, N> for Settings {{\n    #[inline]\n    fn rules(&self) -> &Rules<{real}, N> {{\n        \
         const {{ &arm::rules() }}\n    }}\n}}\n\n\
         /// Parts of this arm's controller.\n#[derive(Clone, Copy, Debug, PartialEq, Eq)]\npub struct Build;\n\n\
         impl ArmBuild<{real}, N> for Build {{\n    type Dynamics = dynamics::Arm;\n    type Trig = arm::Trig;\n    \
         type Tuning = tuning::Tuning;\n    type Protection = protection::Protection;\n    type Settings = Settings;\n}}\n\n\
         /// The controller of this arm: call its `tick` at [`RATE_HZ`].\npub type ArmController = Controller<{real}, N, Build>;\n\n\
         /// A controller at rest.\n#[must_use]\npub fn controller() -> ArmController {{\n    {start}\n}}\n\n\
         /// The safety state machine around the controller: it decides in every tick whether torque acts.\n\
         pub type ArmSafety = Safety<{real}, N, Settings>;\n\n\
         /// A safety state machine, idle.\n#[must_use]\npub fn safety() -> ArmSafety {{\n    Safety::new(Settings)\n}}\n"
    )
}

/// The test: torques of states along the scene's motion, as the desk computes them.
fn golden<S: Float, const N: usize>(
    file: &SceneFile,
    model: &Model<f64, N>,
    name: &str,
    is_live: bool,
) -> Result<String, Box<dyn std::error::Error>>
where
    Method: Trig<S>,
{
    let rows = cost::inputs(file, model).map_err(|error| format!("{}: {error}", file.path.display()))?;
    let scene = file.scene(model);
    let live = file.live(model);
    let (recursion, cast) = (Dynamics::new(model.cast::<S>(), scene.cast::<S>()), live.cast::<S>());
    let given = if is_live { cast } else { Live::zero() };
    let program = (file.control.kernel.level() == Some(Level::Regrouped))
        .then(|| compile(Function::InverseDynamics, model, &scene, Level::Regrouped, file_precision::<S>()));
    let state = |reference: Reference<S, N>| -> Item {
        let Reference { q, qd, qdd } = reference;
        let turn = file.control.trig.sin_cos_all(&q);
        let tau = match &program {
            // A regrouped kernel rounds otherwise than the recursion.
            Some(program) => {
                let outputs = program.evaluate(&input_values(&turn, &q, &qd, &qdd, &given));
                core::array::from_fn(|joint| outputs[joint])
            }
            None => recursion.inverse_dynamics(&turn, &q, &qd, &qdd, &given),
        };
        list([q, qd, qdd, tau].iter().map(|row| numbers(row)).collect())
    };
    let every = rows.len().div_ceil(STATES);
    let states: Vec<Item> = rows.iter().step_by(every).map(|row| state(row.reference.cast::<S>())).collect();
    let (count, real, module) = (states.len(), S::NAME, name.replace('-', "_"));
    let pass = if is_live { ", &live()" } else { "" };
    let also = if is_live { ", live" } else { "" };
    Ok(format!(
        "//! Torques of {count} states, as the desk computed them when this crate was written.\n#![allow(clippy::excessive_precision, clippy::approx_constant, reason = \"generated numbers\")]\n\n\
         use {module}::{{N, inverse_dynamics{also}}};\n\n\
         /// Position, velocity, acceleration, and the torque that they need.\nconst STATES: [[[{real}; N]; 4]; {count}] = {};\n\n\
         #[test]\nfn torques_are_those_of_the_desk() {{\n    for [q, qd, qdd, tau] in STATES {{\n        \
         assert_eq!(inverse_dynamics(&q, &qd, &qdd{pass}), tau);\n    }}\n}}\n",
        list(states).print(0)
    ))
}

fn file_precision<S: Float>() -> crate::kernel::Precision {
    if S::NAME == "f32" { ScalarChoice::F32.precision() } else { ScalarChoice::F64.precision() }
}

fn readme(file: &SceneFile, name: &str, real: &str, operations: Option<Operations>, is_live: bool) -> String {
    let module = name.replace('-', "_");
    let (robot, scene, joints) = (&file.robot.name, &file.name, file.robot.dof());
    let live = if is_live { ", &live" } else { "" };
    let told = if is_live {
        format!("let live = {module}::live(); // the scene's; change what changes on your arm\n")
    } else {
        String::new()
    };
    let set = if is_live { "*controller.live_mut() = live; // whenever it changes\n" } else { "" };
    let cost = match operations {
        Some(operations) => format!(
            "One call of `inverse_dynamics` takes {} multiplications, {} additions and {} subtractions, and the sine and cosine of {joints} angles. \
             `newtau run SCENE --target qemu` counts the instructions of a whole control tick on a Cortex-M4F, and `newtau choose trade SCENE` compares the alternatives.",
            operations.mul, operations.add, operations.sub
        ),
        None => "The inverse dynamics are the recursion itself. A kernel is faster: set `kernel = \"exact\"` in the scene's `[control]`.".to_owned(),
    };
    format!(
        "# {name}\n\nInverse dynamics and control of {robot} ({joints} joints) in the scene {scene}, `no_std`, in `{real}`. Generated by `newtau emit arm`; \
         change the robot and scene files instead of this crate.\n\n\
         ## One function\n\n```rust\n{told}let tau = {module}::inverse_dynamics(&q, &qd, &qdd{live});\nlet hold = {module}::gravity(&q{live});\n```\n\n\
         Positions, velocities and accelerations are in rad, rad/s and rad/s^2 (m for a prismatic joint); torques in N m (N).\n\n\
         ## A control loop\n\n```rust\nlet mut controller = {module}::controller();\n// At {rate} Hz:\n\
         {set}match controller.tick(&reference, &measurement) {{\n    \
         Command::Drive {{ torque, .. }} => drives.set(torque), // N m\n    \
         Command::Brake(fault) => drives.brake(fault), // release the drives, engage the brakes\n}}\n```\n\n\
         `{module}::safety()` is the state machine that decides when torque may act. It is software, and no safety device: a person may be near the arm only with an emergency stop \
         that cuts the drives' power without it.\n\n\
         ## Cost\n\n{cost}\n\n\
         ## Check\n\n`cargo test` compares the torques of {STATES} states with those of the desk, to the last bit. On every core that rounds as IEEE 754 says the bits are the same; \
         the README of `dynamics-core` names the conditions.\n",
        rate = file.control.rate,
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
    let file = SceneFile::load(scene).map_err(|error| format!("{error}; expected {}", error.expected()))?;
    let arm = arm_crate(&file, file.control.scalar, None)?;
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
    Ok(vec![scene.to_owned(), file.robot.path])
}
