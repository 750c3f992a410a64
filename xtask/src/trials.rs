//! Programs of the package `trials`, which run the simulator: built where a task needs them.

use crate::process::cargo;
use std::process::Command;

/// `cargo run` of one of them, in the tasks' own profile.
pub(crate) fn program(name: &str) -> Command {
    cargo(["run", "--quiet", "--locked", "--release", "--package", "trials", "--bin", name, "--"])
}
