//! The firmware for a scene.

use super::ChipError;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Build the firmware with a scene's arm and controller, and say where the program lies.
///
/// # Errors
/// cargo cannot be started, or the build fails; the error holds what it said.
pub fn build_firmware(scene: &Path) -> Result<PathBuf, ChipError> {
    let cargo = PathBuf::from(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let scene = scene.canonicalize().unwrap_or_else(|_| scene.to_owned());
    let output = Command::new(&cargo)
        .args(["run", "--quiet", "--package", "xtask", "--", "firmware", "build", "--message-path", "--scene"])
        .arg(&scene)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .stdin(Stdio::null())
        .output()
        .map_err(|source| ChipError::CannotStart { program: cargo, source })?;
    let text = String::from_utf8_lossy(&output.stdout);
    match text.lines().last() {
        Some(path) if output.status.success() => Ok(PathBuf::from(path)),
        _ => Err(ChipError::Build { output: String::from_utf8_lossy(&output.stderr).trim_end().to_owned() }),
    }
}
