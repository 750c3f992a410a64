//! `emit`: writes code for programs of other people.

use crate::force::ForceArgs;
use clap::{Args, Subcommand};
use robot_compiler::SceneFile;
use robot_compiler::emit::arm_crate;
use robot_compiler::emit::c::c_library;
use robot_compiler::emit::kernel_file::Language;
use robot_compiler::names::name;
use robot_compiler::scene::ScalarChoice;
use sim::failure::{Failure, in_file};
use sim::terminal::{named, print};
use std::fs;
use std::path::{Path, PathBuf};

const EXAMPLE: &str = "Example:\n  newtau emit arm scenes/puma560_pick.toml --out out/arm";

const EXAMPLES: &str = "\
Examples:
  newtau emit arm scenes/puma560_pick.toml --out out/arm
  newtau emit arm my_arm/move.toml --scalar f64 --out ../my_firmware/arm
  newtau emit arm my_arm/move.toml --language c --out ../my_firmware/arm

The crate is no_std and depends on dynamics-core alone. It has inverse_dynamics(q, qd, qdd), gravity(q), controller() and
safety(); a test with the torques of eight states, to the last bit; and a README. Copy it, or make it a member of your own
workspace. With a build script instead: robot_compiler::emit::build_arm(\"arm/move.toml\").

In C (--language c): C99 without dependencies, with inverse dynamics, gravity, mass matrix, forward dynamics and the law of
computed torque; a header for C++; CMake and Arduino files; and the same test. No controller and no state machine.";

/// Options of `emit`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct EmitArgs {
    /// Kind of the code.
    #[command(subcommand)]
    pub kind: EmitKind,
}

/// Kind of the code.
#[derive(Clone, Debug, Subcommand)]
pub enum EmitKind {
    /// Write a Rust crate for your own firmware (model, inverse dynamics, controller, safety state machine), or a C library (dynamics).
    Arm(ArmArgs),
}

/// Options of `emit arm`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct ArmArgs {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// Folder of the crate or library.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Programming language.
    #[arg(long, value_parser = named::<Language>(), default_value = name(Language::Rust))]
    pub language: Language,
    /// Floating-point type. Without it, the scene's.
    #[arg(long, value_parser = named::<ScalarChoice>())]
    pub scalar: Option<ScalarChoice>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
}

/// Writes the code.
///
/// # Errors
/// A wrong scene, or a folder that cannot be written.
pub fn run(args: &EmitArgs) -> Result<(), Failure> {
    match &args.kind {
        EmitKind::Arm(args) => arm(args),
    }
}

/// The folder of `dynamics-core`, if the project's sources are still where this program was built.
fn core_folder() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).parent()?.join("dynamics-core");
    folder.join("Cargo.toml").is_file().then_some(folder)
}

fn arm(args: &ArmArgs) -> Result<(), Failure> {
    let scene = SceneFile::load(&args.scene).map_err(Failure::input)?;
    let scalar = args.scalar.unwrap_or(scene.control.scalar);
    let refused = |error: Box<dyn std::error::Error>| Failure::Input(miette::miette!("{error}"));
    let out = args.out.display();
    let (files, operations, written, check): (Vec<(String, String)>, _, _, _) = match args.language {
        Language::Rust => {
            let arm = arm_crate(&scene, scalar, core_folder().as_deref()).map_err(refused)?;
            let check = format!("cargo test --manifest-path {}", args.out.join("Cargo.toml").display());
            let files = arm.files.into_iter().map(|(name, text)| (name.to_owned(), text)).collect();
            (files, arm.operations, format!("crate               {}", arm.name), check)
        }
        Language::C => {
            let library = c_library(&scene, scalar).map_err(refused)?;
            let prefix = library.prefix;
            let check = format!("cc -O2 -I{out}/src {out}/src/{prefix}.c {out}/test/golden.c -o golden && ./golden");
            (library.files, Some(library.operations), format!("C library           {prefix}"), check)
        }
    };
    let mut output = args.force.output().reads(&args.scene).reads(&scene.robot.path);
    output.folder(&args.out, &[])?;
    for (name, _) in &files {
        output.file(&args.out.join(name))?;
    }
    for (name, text) in &files {
        let path = args.out.join(name);
        fs::write(&path, text).map_err(|error| in_file(&path, &error))?;
    }
    output.finish()?;
    let cost = operations.map_or_else(String::new, |operations| {
        format!("operations          {} of one inverse dynamics\n", operations.total())
    });
    print(&format!("{written} in {out}\n{cost}check it            {check}\n"))
}
