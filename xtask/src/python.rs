//! The tests of the Python wheel: installed into an environment of its own, as a user installs it, but in the profile of the tests.

use crate::process::{root, run, target_directory};
use anyhow::Result;
use std::process::Command;

/// Installs the wheel and runs its tests. The tests of its engine are Rust's.
pub(crate) fn check() -> Result<()> {
    let environment = target_directory().join("python");
    let python = environment.join("bin/python");
    if !python.is_file() {
        run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&environment))?;
    }
    let profile = "build-args=--profile=dev";
    let install = [
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "--config-settings",
        profile,
        "./python[test]",
    ];
    run(Command::new(&python).args(install).current_dir(root()))?;
    run(Command::new(&python).args(["-m", "pytest", "--quiet", "python/tests"]).current_dir(root()))
}
