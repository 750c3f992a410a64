//! Source for the chip's programs, which the robot compiler writes before cargo is started.
//!
//! A build script could run the robot compiler too, but it would be compiled once more for it, in the chip's profile.

use crate::bad_input::BadInput;
use crate::firmware::scene_hash;
use crate::toolchain::target_directory;
use anyhow::{Context as _, Result};
use robot_compiler::{FileError, emit};
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

/// Arm, kernel and controller of a scene, for the variable `NEWTAU_ARM`.
pub(crate) fn arm(scene: &Path) -> Result<PathBuf> {
    written(&format!("arm-{}", scene_hash(scene)), |folder| emit::write_firmware(scene, folder))
}

/// The controller of a scene with the ticks that it is measured in, for the variable `NEWTAU_COST`.
pub(crate) fn cost(scene: &Path) -> Result<PathBuf> {
    let scenes = [scene.to_owned()];
    written("cost", |folder| emit::cost::write_program_of(&scenes, folder))
}

/// The kernels that are counted, for the variable `NEWTAU_KERNELS`.
pub(crate) fn kernels() -> Result<PathBuf> {
    written("kernels", |folder| crate::bench::kernels::write(folder.to_owned()))
}

/// The folder of this name with what `write` writes. A file that stays the same is left alone, so that cargo builds nothing anew.
fn written(name: &str, write: impl FnOnce(&Path) -> Result<(), Box<dyn Error>>) -> Result<PathBuf> {
    let sources = target_directory().join("source");
    let (folder, fresh) = (sources.join(name), sources.join(format!("{name}.new")));
    fs::create_dir_all(&folder)?;
    fs::remove_dir_all(&fresh).ok();
    fs::create_dir_all(&fresh)?;
    // Modules name each other's files by their whole paths.
    write(&fresh).map_err(told)?;
    let (from, to) = (fresh.display().to_string(), folder.display().to_string());
    for entry in fs::read_dir(&fresh)? {
        let path = entry?.path();
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?.replace(&from, &to);
        let place = folder.join(path.file_name().unwrap_or_default());
        if fs::read_to_string(&place).ok().as_ref() != Some(&text) {
            fs::write(&place, text).with_context(|| place.display().to_string())?;
        }
    }
    fs::remove_dir_all(&fresh)?;
    Ok(folder)
}

/// A file that is wrong is the caller's to change; anything else is not.
fn told(error: Box<dyn Error>) -> anyhow::Error {
    match error.downcast_ref::<FileError>() {
        Some(file) => BadInput(format!("{file}; expected {}", file.expected())).into(),
        None => BadInput(error.to_string()).into(),
    }
}
