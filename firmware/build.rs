//! Passes the chip's memory map to the linker.

mod link_arguments;

use std::path::Path;

fn main() {
    let manifest = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let manifest = Path::new(&manifest);
    let has = |feature: &str| std::env::var_os(format!("CARGO_FEATURE_{feature}")).is_some();
    let chip = if has("G474_FDCAN") {
        "stm32g474"
    } else if has("NETDUINOPLUS2") {
        "netduinoplus2"
    } else {
        "stm32f405"
    };
    let scripts = [manifest.join("tick.x"), manifest.join("coupled.x")];
    link_arguments::write(&manifest.join("memory").join(chip), &scripts, &["-Tdefmt.x"]);
}
