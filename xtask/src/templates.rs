//! `cargo xtask templates`: each firmware template compiles for its chip; their loop, which is the same in all, passes its tests here and runs in the
//! emulated chip.

use crate::cores::{has_targets, target};
use crate::process::{root, run as run_command};
use anyhow::{Context as _, Result, ensure};
use firmware_image::install;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Templates by folder, with the compiler's target.
const TEMPLATES: [(&str, &str); 4] = [
    ("rtic-stm32f4", "thumbv7em-none-eabihf"),
    ("embassy-stm32g4", "thumbv7em-none-eabihf"),
    ("rp2350", "thumbv8m.main-none-eabihf"),
    ("esp32c3", "riscv32imc-unknown-none-elf"),
];

/// The one whose loop is tested here and in the emulator.
const EMULATED: &str = "rtic-stm32f4";

/// Files that are the same in every template, because each template is copied alone.
const COMMON: [&str; 4] = ["src/control.rs", "src/dry_run.rs", "src/joints.rs", "tests/loop.rs"];

/// The file that is the same in every template for an Arm core.
const COMMON_ON_ARM: &str = "src/float_mode.rs";

/// Compares, builds, tests and runs.
pub(crate) fn run() -> Result<()> {
    let folder = root().join("firmware/templates");
    same_files(&folder)?;
    if !has_targets()? {
        return Ok(());
    }
    for (name, triple) in TEMPLATES {
        eprintln!("templates: {name}");
        target(triple)?;
        // In the template's folder, whose settings name target and linker script.
        let cargo = |arguments: &[&str]| {
            let mut command = firmware_image::process::cargo(arguments.iter().copied());
            command.current_dir(folder.join(name)).env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
            command
        };
        run_command(&mut cargo(&["build", "--release", "--locked", "--quiet"]))?;
        let elf = crate::process::target_directory().join(triple).join("release").join(name);
        ensure!(fs::metadata(&elf)?.len() > 10_000, "{}: the linker left out the program", elf.display());
        // The loop and its tests are the same files in every template.
        if name == EMULATED {
            run_command(&mut cargo(&["desk", "--locked", "--quiet"]))?;
            install::qemu()?;
            run_command(&mut cargo(&["run", "--release", "--locked", "--quiet", "--features", "qemu"]))?;
        }
    }
    Ok(())
}

/// Fails if a common file differs between two templates.
fn same_files(folder: &Path) -> Result<()> {
    let read = |name: &str, file: &str| {
        let path = folder.join(name).join(file);
        fs::read(&path).with_context(|| format!("{}", path.display()))
    };
    for file in COMMON.into_iter().chain([COMMON_ON_ARM]) {
        let first = read(TEMPLATES[0].0, file)?;
        for (name, _) in
            TEMPLATES.into_iter().filter(|(_, triple)| file != COMMON_ON_ARM || triple.starts_with("thumb"))
        {
            ensure!(read(name, file)? == first, "{name}/{file} differs from {}/{file}: copy it", TEMPLATES[0].0);
        }
    }
    Ok(())
}

/// Formats, for the check of the format of every template.
pub(crate) fn format() -> Result<()> {
    for (name, _) in TEMPLATES {
        let folder = root().join("firmware/templates").join(name);
        run_command(Command::new("cargo").args(["fmt", "--check"]).current_dir(folder))?;
    }
    Ok(())
}
