//! Builds of the firmware for a scene.

use super::ChipError;
use firmware_image::{Board, Build, install};
use robot_compiler::emit::Choices;
use std::path::{Path, PathBuf};

/// Builds the emulated board's firmware with a scene's arm and controller. Returns the path of the program.
///
/// Installs missing tools for building and emulating, and reports that on standard error.
///
/// # Errors
/// A tool that cannot be installed, a wrong scene, or a failed build. The compiler prints its own messages.
pub fn build_firmware(scene: &Path) -> Result<PathBuf, ChipError> {
    build(&Build::of(scene, Board::Netduinoplus2))
}

/// As [`build_firmware`], with another law or another sine and cosine method than the scene file's.
///
/// # Errors
/// As [`build_firmware`].
pub fn build_firmware_with(scene: &Path, choices: Choices<'_>) -> Result<PathBuf, ChipError> {
    build(&Build { choices, ..Build::of(scene, Board::Netduinoplus2) })
}

/// As [`build_firmware`], with the DMA link driver of the real boards. A software stand-in moves its bytes, because the emulator has no DMA.
///
/// # Errors
/// As [`build_firmware`].
pub fn build_firmware_by_dma(scene: &Path) -> Result<PathBuf, ChipError> {
    build(&Build { dma_stand_in: true, ..Build::of(scene, Board::Netduinoplus2) })
}

fn build(program: &Build<'_>) -> Result<PathBuf, ChipError> {
    install::qemu().and_then(|()| program.run()).map_err(|error| ChipError::Build { output: format!("{error:#}") })
}
