//! Source for the chip's programs, written by the robot compiler before cargo starts.
//!
//! A build script could run the robot compiler too, but would compile it once more, in the chip's profile.

use crate::bad_input::BadInput;
use crate::firmware::scene_hash;
use crate::toolchain::target_directory;
use anyhow::{Context as _, Result};
use robot_compiler::{FileError, emit};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Arm, kernel and controller of a scene, for the variable `NEWTAU_ARM`.
pub(crate) fn arm(scene: &Path) -> Result<PathBuf> {
    written(&format!("arm-{}", scene_hash(scene)), |folder| emit::write_firmware(scene, folder))
}

/// The controller of a scene with the ticks for its measurement, for the variable `NEWTAU_COST`.
pub(crate) fn cost(scene: &Path) -> Result<PathBuf> {
    let scenes = [scene.to_owned()];
    written("cost", |folder| emit::cost::write_program_of(&scenes, folder))
}

/// The counted kernels, for the variable `NEWTAU_KERNELS`.
pub(crate) fn kernels() -> Result<PathBuf> {
    written("kernels", |folder| crate::bench::kernels::write(folder.to_owned()))
}

/// The folder of this name, filled by `write`.
fn written(name: &str, write: impl FnOnce(&Path) -> Result<(), Box<dyn Error>>) -> Result<PathBuf> {
    let folder = target_directory().join("source").join(name);
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    write(&folder).map_err(told)?;
    Ok(folder)
}

/// A wrong scene is an error of the caller's; a folder that cannot be written to is not.
fn told(error: Box<dyn Error>) -> anyhow::Error {
    let error = match error.downcast::<std::io::Error>() {
        Ok(outside) => return (*outside).into(),
        Err(error) => error,
    };
    BadInput(match error.downcast_ref::<FileError>() {
        Some(file) => format!("{file}; expected {}", file.expected()),
        None => error.to_string(),
    })
    .into()
}
