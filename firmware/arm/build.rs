//! Sets the path of the arm's source.
//!
//! `NEWTAU_ARM` names the folder that `cargo newtau firmware build` has written from a scene file. Without it the build
//! takes the Puma's source, `puma560_pick/` beside this file. Nothing is compiled here: the robot compiler runs once,
//! in the task.

use std::error::Error;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-env-changed=NEWTAU_ARM");
    let own = Path::new(&std::env::var("CARGO_MANIFEST_DIR")?).join("puma560_pick");
    let folder = std::env::var_os("NEWTAU_ARM").map_or(own, PathBuf::from);
    println!("cargo::rerun-if-changed={}", folder.display());
    println!("cargo::rustc-env=ARM={}", folder.display());
    Ok(())
}
