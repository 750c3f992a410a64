//! Arms and file locations of the harness.

use crate::process::{root, target_directory};
use std::path::PathBuf;

/// The arms, by the names of their files.
pub(super) const ARMS: [&str; 2] = ["ur5", "puma560"];

/// Joints of every arm that is measured.
pub(super) const JOINTS: usize = 6;

/// Folder of all generated files.
pub(super) fn folder() -> PathBuf {
    target_directory().join("peers")
}

/// A file of the harness.
pub(super) fn source(name: &str) -> PathBuf {
    root().join("bench/peers").join(name)
}
