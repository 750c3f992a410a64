//! Writes the controllers that are measured, each in modules of its own.
//!
//! `NEWTAU_SCENES` names a text with the path of a scene file on each line; without it the Puma's scene is taken.

#[path = "../firmware/link_arguments.rs"]
mod link_arguments;

use robot_compiler::emit::cost::{SCENES, write_program, write_program_of};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

const SCENE_DEFAULT: &str = "scenes/puma560_pick.toml";

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR")?).join("..");
    let folder = PathBuf::from(std::env::var("OUT_DIR")?);
    link_arguments::write(&root, &[]);
    println!("cargo::rerun-if-env-changed={SCENES}");
    println!("cargo::rerun-if-changed={}", root.join("robots").display());
    let read = match std::env::var_os(SCENES) {
        Some(list) => write_program(&PathBuf::from(list), &folder)?,
        None => {
            let scene = root.join(SCENE_DEFAULT);
            write_program_of(std::slice::from_ref(&scene), &folder)?;
            vec![scene]
        }
    };
    for path in read {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    Ok(())
}
