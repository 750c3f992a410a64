//! The controllers that are measured, each in modules of its own.
//!
//! `NEWTAU_SCENES` names a text with the path of a scene file on each line; without it the Puma's scene is taken.

use robot_compiler::emit::cost::{SCENES, write_program, write_program_of};
use std::error::Error;
use std::path::{Path, PathBuf};

const SCENE_DEFAULT: &str = "scenes/puma560_pick.toml";

/// Write the controllers of the list's scenes into a folder.
pub(crate) fn write(root: &Path, folder: &Path) -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-env-changed={SCENES}");
    let read = match std::env::var_os(SCENES) {
        Some(list) => write_program(&PathBuf::from(list), folder)?,
        None => {
            let scene = root.join(SCENE_DEFAULT);
            write_program_of(std::slice::from_ref(&scene), folder)?;
            vec![scene]
        }
    };
    for path in read {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    Ok(())
}
