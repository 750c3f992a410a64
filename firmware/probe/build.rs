//! Writes what the program of the chosen feature measures.

#[cfg(feature = "cost")]
#[path = "build/cost.rs"]
mod cost;
#[cfg(feature = "kernels")]
#[path = "build/kernels.rs"]
mod kernels;
#[path = "../link_arguments.rs"]
mod link_arguments;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR")?).join("../..");
    link_arguments::write(&root, &[]);
    println!("cargo::rerun-if-changed={}", root.join("robots").display());
    #[cfg(feature = "cost")]
    cost::write(&root, &folder("cost")?)?;
    #[cfg(feature = "kernels")]
    kernels::write(folder("kernels")?)?;
    Ok(())
}

/// A folder of a program's own.
#[cfg(any(feature = "cost", feature = "kernels"))]
fn folder(program: &str) -> Result<PathBuf, Box<dyn Error>> {
    let folder = PathBuf::from(std::env::var("OUT_DIR")?).join(program);
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}
