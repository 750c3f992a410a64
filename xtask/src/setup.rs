//! Installation of the project's tools where they are missing. Every step prints its action.

use crate::process::{output, root, run, target_directory, which};
use crate::toolchain::Toolchain;
use anyhow::{Context as _, Result};
use std::path::{Path, PathBuf};
use std::process::{Command, exit};

/// Installs everything.
pub(crate) fn all() -> Result<()> {
    components()?;
    let toolchain = Toolchain::find_or_install()?;
    eprintln!("setup: firmware is built by {toolchain}");
    qemu()?;
    eprintln!("setup: qemu-system-arm is there");
    chromium()?;
    nextest()
}

/// Components that rustup's minimal profile leaves out. Their stand-ins are on the path anyway, so the check is to run
/// them.
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

/// The emulator.
pub(crate) fn qemu() -> Result<()> {
    if which("qemu-system-arm").is_some() { Ok(()) } else { apt_install(&["qemu-system-arm"]) }
}

/// The browser that reports are tested in. Without it, where nothing can be installed, those tests say that they are skipped.
pub(crate) fn chromium() -> Result<()> {
    if which("chromium").is_none() {
        if !required() && installer().is_none() {
            eprintln!("setup: no chromium here, and no right to install it: reports are not tested in a browser");
            return Ok(());
        }
        apt_install(&["chromium"])?;
    }
    eprintln!("setup: chromium is there");
    Ok(())
}

/// Node.js and its package manager, which bundle the scripts of the report.
pub(crate) fn npm() -> Result<()> {
    if which("npm").is_some() && which("node").is_some() { Ok(()) } else { apt_install(&["nodejs", "npm"]) }
}

/// Whether nothing may be skipped for lack of a tool.
pub(crate) fn required() -> bool {
    ["CI", "NEWTAU_CI"].iter().any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()))
}

/// How Debian packages are installed here.
enum Installer {
    Root,
    Sudo,
}

/// `None` where Debian packages cannot be installed.
fn installer() -> Option<Installer> {
    let root = output(Command::new("id").arg("-u")).as_deref() == Some("0");
    let sudo = || {
        which("sudo").is_some_and(|sudo| Command::new(sudo).args(["-n", "true"]).status().is_ok_and(|s| s.success()))
    };
    match Path::new("/usr/bin/apt-get").exists() {
        true if root => Some(Installer::Root),
        true if sudo() => Some(Installer::Sudo),
        _ => None,
    }
}

/// The test runner.
pub(crate) fn nextest() -> Result<()> {
    if which("cargo-nextest").is_none() {
        eprintln!("setup: cargo install --locked cargo-nextest");
        run(Command::new("cargo").args(["install", "--locked", "cargo-nextest"]))?;
    }
    eprintln!("setup: cargo-nextest is there");
    Ok(())
}

/// Callgrind, and gungraun's runner in the version of `Cargo.lock`; gungraun refuses any other.
pub(crate) fn gungraun() -> Result<()> {
    if which("valgrind").is_none() {
        apt_install(&["valgrind"])?;
    }
    let wanted = locked_version("gungraun-runner")?;
    let found = output(Command::new("gungraun-runner").arg("--version"));
    if !found.is_some_and(|text| text.split(' ').any(|word| word == wanted)) {
        // Not optimised: the runner only starts the counted program, and installs in half the time.
        let install = ["install", "--locked", "--debug", "gungraun-runner", "--version", &wanted];
        eprintln!("setup: cargo {}", install.join(" "));
        run(Command::new("cargo").args(install))?;
    }
    eprintln!("setup: valgrind and gungraun-runner are there");
    Ok(())
}

/// The Python of a virtual environment with these packages. It counts as complete if it holds a copy of the list.
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
        // A partial environment would look complete.
        std::fs::remove_dir_all(folder).ok();
    }
    made.with_context(|| format!("could not install from PyPI: {}", packages.join(", ")))?;
    std::fs::write(&stamp, wanted)?;
    Ok(python)
}

/// A Python that reads the files for viewers; the tests that need it say that they are skipped where it cannot be had.
pub(crate) fn viewers() -> Option<PathBuf> {
    let list = root().join("host-sim/tests/viewers/requirements.txt");
    let made = python(&target_directory().join("viewers"), &list);
    made.inspect_err(|why| eprintln!("setup: {why:#}; the tests that need these packages are skipped")).ok()
}

/// The version of a package in `Cargo.lock`.
fn locked_version(package: &str) -> Result<String> {
    let path = root().join("Cargo.lock");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let mut lines = text.lines().skip_while(|line| *line != format!("name = {package:?}"));
    let version = lines.nth(1).and_then(|line| line.strip_prefix("version = \"")?.strip_suffix('"'));
    version.map(str::to_owned).with_context(|| format!("{} has no {package}", path.display()))
}

/// Installs Debian packages. If that is not possible, prints exactly what to install, and exits with code 2.
pub(crate) fn apt_install(packages: &[&str]) -> Result<()> {
    let list = packages.join(" ");
    let Some(installer) = installer() else {
        eprintln!("setup: missing here: {list}");
        eprintln!("setup: this is no Debian-like system, or there is no right to install. Install these yourself:");
        eprintln!("         the Rust target   rustup target add {}", crate::toolchain::TARGET);
        eprintln!(
            "         QEMU for Arm      Debian, Ubuntu: apt-get install qemu-system-arm; macOS: brew install qemu"
        );
        exit(2);
    };
    let apt = |arguments: &[&str]| {
        let mut command = match installer {
            Installer::Root => Command::new("apt-get"),
            Installer::Sudo => Command::new("sudo"),
        };
        if let Installer::Sudo = installer {
            command.args(["-n", "apt-get"]);
        }
        command.env("DEBIAN_FRONTEND", "noninteractive").args(arguments);
        eprintln!("setup: apt-get {}", arguments.join(" "));
        run(&mut command)
    };
    apt(&["update", "--quiet"])?;
    let mut install = vec!["install", "--quiet", "--yes", "--no-install-recommends"];
    install.extend(packages);
    apt(&install)
}
