//! Tells the linker about the chip's memory.

mod link_arguments;

use std::path::Path;

fn main() {
    let manifest = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    link_arguments::write(&Path::new(&manifest).join(".."), &["-Tdefmt.x"]);
}
