//! Installation of the missing peers.

use super::harness::{folder, source};
use crate::process::{output, which};
use anyhow::{Context as _, Result};
use firmware_image::install;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Compiler and package: the newest clang in Debian's stable release. Its code is faster than that of the release's default clang.
pub(super) const CLANG: &str = "clang-19";

/// Installs Debian's packages and the virtual environment; returns its Python.
pub(super) fn all() -> Result<PathBuf> {
    debian()?;
    install::qemu()?;
    python()
}

/// Installs the compilers and KDL.
fn debian() -> Result<()> {
    let program = |name: &str| which(name).is_some();
    // The compiler prints an absolute path only if it has the library.
    let newlib = output(Command::new("arm-none-eabi-gcc").arg("-print-file-name=libm.a"))
        .is_some_and(|path| Path::new(&path).is_absolute());
    let venv = output(Command::new("python3").args(["-c", "import ensurepip, venv"])).is_some();
    let wanted = [
        (program("g++"), "g++"),
        (program("clang++"), "clang"),
        (program(CLANG), CLANG),
        (Path::new("/usr/include/kdl/chain.hpp").exists(), "liborocos-kdl-dev"),
        (program("arm-none-eabi-gcc"), "gcc-arm-none-eabi"),
        (newlib, "libnewlib-arm-none-eabi"),
        (venv, "python3-venv"),
    ];
    let missing: Vec<&str> = wanted.into_iter().filter(|(there, _)| !there).map(|(_, package)| package).collect();
    if missing.is_empty() { Ok(()) } else { install::apt(&missing) }
}

/// A virtual environment with the packages of `requirements.txt`.
fn python() -> Result<PathBuf> {
    crate::setup::python(&folder().join("venv"), &source("requirements.txt"))
}

/// Folder of the virtual environment's packages.
pub(super) fn site_packages(python: &Path) -> Result<PathBuf> {
    let code = "import sysconfig; print(sysconfig.get_path('purelib'))";
    let path =
        output(Command::new(python).args(["-c", code])).context("the virtual environment's Python does not run")?;
    Ok(PathBuf::from(path))
}
