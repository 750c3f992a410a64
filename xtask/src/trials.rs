//! Programs of the package `trials`, which contain the simulator. They are built only for tasks that need them.

use crate::process::cargo;
use std::process::Command;

/// `cargo run` for one of them, in the tasks' own profile.
pub(crate) fn program(name: &str) -> Command {
    cargo(["run", "--quiet", "--locked", "--release", "--package", "trials", "--bin", name, "--"])
}
