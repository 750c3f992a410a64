//! Installation of missing tools. Every step prints its action.

use crate::process::{output, root, run, target_directory, which};
use crate::toolchain::Toolchain;
use anyhow::{Context as _, Result};
use firmware_image::install;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Installs everything.
pub(crate) fn all() -> Result<()> {
    components()?;
    let toolchain = Toolchain::find_or_install()?;
    eprintln!("setup: firmware is built by {toolchain}");
    install::qemu()?;
    eprintln!("setup: qemu-system-arm is there");
    chromium()?;
    nextest()
}

/// Installs the components that rustup's minimal profile leaves out. Rustup's proxies are on the path even without them, so the check is to run them.
fn components() -> Result<()> {
    for (component, subcommand) in [("rustfmt", "fmt"), ("clippy", "clippy")] {
        if output(Command::new("cargo").args([subcommand, "--version"])).is_none() {
            eprintln!("setup: rustup component add {component}");
            run(Command::new("rustup").args(["component", "add", component]))?;
        }
    }
    eprintln!("setup: rustfmt and clippy are there");
    Ok(())
}

/// Installs the browser in which reports are tested, if it is missing. Without the right to install it, those tests are skipped with a message; in
/// continuous integration that is an error.
pub(crate) fn chromium() -> Result<()> {
    if which("chromium").is_none() {
        if !required() && !install::is_possible() {
            eprintln!("setup: no chromium here, and no right to install it: reports are not tested in a browser");
            return Ok(());
        }
        install::apt(&["chromium"])?;
    }
    eprintln!("setup: chromium is there");
    Ok(())
}

/// Installs Node.js and npm, which bundle the scripts of the report.
pub(crate) fn npm() -> Result<()> {
    if which("npm").is_some() && which("node").is_some() { Ok(()) } else { install::apt(&["nodejs", "npm"]) }
}

/// True if nothing may be skipped for lack of a tool.
pub(crate) fn required() -> bool {
    ["CI", "NEWTAU_CI"].iter().any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()))
}

/// Installs the test runner.
pub(crate) fn nextest() -> Result<()> {
    if which("cargo-nextest").is_none() {
        eprintln!("setup: cargo install --locked cargo-nextest");
        run(Command::new("cargo").args(["install", "--locked", "cargo-nextest"]))?;
    }
    eprintln!("setup: cargo-nextest is there");
    Ok(())
}

/// Installs callgrind, and gungraun's runner in the version of `bench/Cargo.lock`; gungraun rejects any other version.
pub(crate) fn gungraun() -> Result<()> {
    if which("valgrind").is_none() {
        install::apt(&["valgrind"])?;
    }
    let wanted = locked_version("gungraun-runner")?;
    let found = output(Command::new("gungraun-runner").arg("--version"));
    if !found.is_some_and(|text| text.split(' ').any(|word| word == wanted)) {
        // A debug build: the runner only starts the counted program, and this installs in half the time.
        let install = ["install", "--locked", "--debug", "gungraun-runner", "--version", &wanted];
        eprintln!("setup: cargo {}", install.join(" "));
        run(Command::new("cargo").args(install))?;
    }
    eprintln!("setup: valgrind and gungraun-runner are there");
    Ok(())
}

/// Creates a virtual environment with these packages and returns its Python. The environment counts as complete if it contains a copy of the list.
pub(crate) fn python(folder: &Path, list: &Path) -> Result<PathBuf> {
    let (python, stamp) = (folder.join("bin/python"), folder.join("requirements.txt"));
    let wanted = std::fs::read_to_string(list).with_context(|| list.display().to_string())?;
    if python.is_file() && std::fs::read_to_string(&stamp).is_ok_and(|found| found == wanted) {
        return Ok(python);
    }
    let packages: Vec<&str> = wanted.lines().filter(|line| line.contains("==")).collect();
    eprintln!("setup: {} from PyPI, into {}", packages.join(", "), folder.display());
    let made = (|| {
        run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(folder))?;
        let mut pip = Command::new(&python);
        run(pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"]).arg(list))
    })();
    if made.is_err() {
        // Remove it, because a partial environment would look complete.
        std::fs::remove_dir_all(folder).ok();
    }
    made.with_context(|| format!("could not install from PyPI: {}", packages.join(", ")))?;
    std::fs::write(&stamp, wanted)?;
    Ok(python)
}

/// Python with the packages that read the files for viewers. If it cannot be installed, the tests that need it are skipped with a message.
pub(crate) fn viewers() -> Option<PathBuf> {
    let list = root().join("host-sim/tests/viewers/requirements.txt");
    let made = python(&target_directory().join("viewers"), &list);
    made.inspect_err(|why| eprintln!("setup: {why:#}; the tests that need these packages are skipped")).ok()
}

/// The version of a package in `bench/Cargo.lock`.
fn locked_version(package: &str) -> Result<String> {
    let path = root().join("bench/Cargo.lock");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let mut lines = text.lines().skip_while(|line| *line != format!("name = {package:?}"));
    let version = lines.nth(1).and_then(|line| line.strip_prefix("version = \"")?.strip_suffix('"'));
    version.map(str::to_owned).with_context(|| format!("{} has no {package}", path.display()))
}
