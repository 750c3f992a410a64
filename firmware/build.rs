//! Passes the chip's memory map to the linker.

mod link_arguments;

use std::path::Path;

fn main() {
    let manifest = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let chip = if std::env::var_os("CARGO_FEATURE_G474_FDCAN").is_some() { "stm32g474" } else { "stm32f405" };
    link_arguments::write(&Path::new(&manifest).join("memory").join(chip), &["-Tdefmt.x"]);
}
