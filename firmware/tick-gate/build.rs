//! Writes out the arm of the scene that `NEWTAU_SCENE` names, as the firmware's build does.

use robot_compiler::{SceneFile, with_dof};
use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error:?}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR")?).join("../..");
    let scene = root.join(std::env::var("NEWTAU_SCENE").unwrap_or_else(|_| "scenes/puma560_pick.toml".into()));
    let file = SceneFile::load(&scene)?;
    let text = with_dof!(file.robot.dof(), N => robot_compiler::emit::arm_module(&file, &file.robot.model::<N>()?));
    // The module's own documentation cannot stand in an included file.
    let out = PathBuf::from(std::env::var("OUT_DIR")?).join("arm.rs");
    std::fs::write(out, text.replacen("//!", "//", 1))?;
    println!("cargo::rerun-if-env-changed=NEWTAU_SCENE");
    println!("cargo::rerun-if-changed={}", scene.display());
    println!("cargo::rerun-if-changed={}", root.join("robots").display());
    Ok(())
}
