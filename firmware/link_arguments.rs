//! Linker arguments with the chip's memory map, for the build scripts of all programs that run on it.

use std::path::{Path, PathBuf};

/// Passes the start-up code's script to the linker, with own scripts before it and arguments after it. Does nothing unless the program is built for a
/// chip.
///
/// `memory` is the folder with the chip's memory map, `chip_memory.x`, which the workspace's `memory.x` includes.
pub(crate) fn write(memory: &Path, scripts: &[PathBuf], after: &[&str]) {
    if std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default() != "none" {
        return;
    }
    println!("cargo::rustc-link-search={}", memory.display());
    let map = memory.join("chip_memory.x");
    for file in scripts.iter().chain([&map]) {
        println!("cargo::rerun-if-changed={}", file.display());
    }
    for script in scripts {
        println!("cargo::rustc-link-arg-bins=-T{}", script.display());
    }
    for argument in ["-Tlink.x", "--nmagic"].iter().chain(after) {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}
