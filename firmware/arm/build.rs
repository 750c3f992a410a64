//! Writes the arm out as Rust.
//!
//! `NEWTAU_SCENE` names the scene file, relative to the workspace; without it the Puma's is taken.

use std::path::PathBuf;
use std::process::ExitCode;

const SCENE_DEFAULT: &str = "scenes/puma560_pick.toml";

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
    let scene = root.join(std::env::var("NEWTAU_SCENE").unwrap_or_else(|_| SCENE_DEFAULT.into()));
    robot_compiler::emit::write_firmware(&scene, &PathBuf::from(std::env::var("OUT_DIR")?))?;
    println!("cargo::rerun-if-env-changed=NEWTAU_SCENE");
    for name in robot_compiler::emit::CHOICES {
        println!("cargo::rerun-if-env-changed={name}");
    }
    println!("cargo::rerun-if-changed={}", scene.display());
    println!("cargo::rerun-if-changed={}", root.join("robots").display());
    Ok(())
}
