//! Location of the chip's memory, for the build script of every program that runs on it.

use std::path::Path;

/// Give the linker its scripts, in addition to the start-up code's. Does nothing unless the program is built for a
/// chip.
///
/// `memory` is the folder of the chip's map, `chip_memory.x`, which the workspace's `memory.x` includes.
pub(crate) fn write(memory: &Path, scripts: &[&str]) {
    if std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default() != "none" {
        return;
    }
    println!("cargo::rustc-link-search={}", memory.display());
    println!("cargo::rerun-if-changed={}", memory.join("chip_memory.x").display());
    for argument in ["-Tlink.x"].iter().chain(scripts).chain(&["--nmagic"]) {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}
