//! Sets the path of the measured code's source, which an xtask task has written before.

#[path = "../link_arguments.rs"]
mod link_arguments;

use std::error::Error;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let own = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR")?);
    // The tick is where the firmware has it. Kernels and stretches of instructions are measured from where their programs put them.
    let tick = std::env::var_os("CARGO_FEATURE_COST").map(|_| own.join("../tick.x"));
    link_arguments::write(&own.join("../memory/netduinoplus2"), tick.as_slice(), &[]);
    for (variable, name) in [("NEWTAU_COST", "COST"), ("NEWTAU_KERNELS", "KERNELS")] {
        println!("cargo::rerun-if-env-changed={variable}");
        let folder = std::env::var_os(variable).map_or_else(|| Path::new("").to_owned(), PathBuf::from);
        println!("cargo::rustc-env={name}={}", folder.display());
        if folder.is_dir() {
            println!("cargo::rerun-if-changed={}", folder.display());
        }
    }
    Ok(())
}
