//! Programs of the package `trials`, which contain the simulator. They are built only for tasks that need them.

use crate::process::cargo;
use std::process::Command;

/// `cargo run` for one of them, in the profile of the tests.
pub(crate) fn program(name: &str) -> Command {
    cargo(["run", "--quiet", "--locked", "--package", "trials", "--bin", name, "--"])
}

/// `cargo run` for one of them that computes for minutes.
pub(crate) fn fast_program(name: &str) -> Command {
    cargo(["run", "--quiet", "--locked", "--release", "--package", "trials", "--bin", name, "--"])
}
