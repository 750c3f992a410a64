//! Tells the linker about the chip's memory.

use std::path::Path;

fn main() {
    let variable = |name| std::env::var(name).unwrap_or_default();
    if variable("CARGO_CFG_TARGET_OS") != "none" {
        return;
    }
    // `memory.x` stands at the top of the workspace.
    let manifest = variable("CARGO_MANIFEST_DIR");
    let root = Path::new(&manifest).join("..");
    println!("cargo::rustc-link-search={}", root.display());
    println!("cargo::rerun-if-changed={}", root.join("memory.x").display());
    for argument in ["-Tlink.x", "-Tdefmt.x", "--nmagic"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}
