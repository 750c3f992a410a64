//! Source for the chip's programs, written by the robot compiler before cargo starts.
//!
//! A build script could run the robot compiler too. But then cargo would compile the robot compiler once more, in the chip's profile.

use crate::bad_input::BadInput;
use crate::toolchain::target_directory;
use anyhow::{Context as _, Result};
use robot_compiler::FileError;
use robot_compiler::emit::{self, Choices};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Writes arm, kernel and controller of a scene. Returns the folder for the variable `NEWTAU_ARM`.
///
/// # Errors
/// A wrong scene, or a folder that cannot be written to.
pub fn arm(scene: &Path, choices: Choices<'_>) -> Result<PathBuf> {
    written(&format!("arm-{}", scene_hash(scene, choices)), |folder| emit::write_firmware(scene, choices, folder))
}

/// The folder of this name below the chip's target folder, filled by `write`.
///
/// # Errors
/// As [`arm`].
pub fn written(name: &str, write: impl FnOnce(&Path) -> Result<(), Box<dyn Error>>) -> Result<PathBuf> {
    let folder = target_directory().join("source").join(name);
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    write(&folder).map_err(told)?;
    Ok(folder)
}

/// Converts an error: a wrong scene is the caller's mistake, a folder that cannot be written to is not.
fn told(error: Box<dyn Error>) -> anyhow::Error {
    let error = match error.downcast::<std::io::Error>() {
        Ok(outside) => return (*outside).into(),
        Err(error) => error,
    };
    error.downcast_ref().map_or_else(|| BadInput(error.to_string()), |file: &FileError| BadInput::from(file)).into()
}

/// Name of a scene with a hash of its path and of the changed choices, for the names of generated files.
pub(crate) fn scene_hash(scene: &Path, choices: Choices<'_>) -> String {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    let start = fnv1a(0x811c_9dc5, scene.as_os_str().as_encoded_bytes());
    let hash = [choices.law, choices.trig].into_iter().flatten().fold(start, |hash, name| fnv1a(hash, name.as_bytes()));
    format!("{stem}-{hash:08x}")
}

/// Continues the 32-bit FNV-1a hash.
#[must_use]
pub fn fnv1a(hash: u32, bytes: &[u8]) -> u32 {
    bytes.iter().fold(hash, |hash, byte| (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193))
}
