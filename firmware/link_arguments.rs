//! Linker arguments with the chip's memory map, for the build scripts of all programs that run on it.

use std::path::Path;

/// Passes scripts to the linker, in addition to that of the start-up code. Does nothing unless the program is built for a chip.
///
/// `memory` is the folder with the chip's memory map, `chip_memory.x`, which the workspace's `memory.x` includes.
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
