//! Installation of missing system packages. Every step is printed.

use crate::bad_input::BadInput;
use crate::board::TARGET;
use crate::process::{output, run, which};
use anyhow::Result;
use std::path::Path;
use std::process::Command;

/// Installs the emulator if it is missing.
///
/// # Errors
/// As [`apt`].
pub fn qemu() -> Result<()> {
    if which("qemu-system-arm").is_some() { Ok(()) } else { apt(&["qemu-system-arm"]) }
}

/// Method of installing Debian packages here.
enum Installer {
    Root,
    Sudo,
}

/// True if Debian packages can be installed here.
#[must_use]
pub fn is_possible() -> bool {
    installer().is_some()
}

/// Returns the method; `None` if Debian packages cannot be installed.
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

/// Installs Debian packages.
///
/// # Errors
/// [`BadInput`]: installation is not possible here; the message names the packages.
pub fn apt(packages: &[&str]) -> Result<()> {
    let list = packages.join(" ");
    let Some(installer) = installer() else {
        return Err(BadInput(format!(
            "missing here: {list}; this is no Debian-like system, or there is no right to install. Install these yourself: the Rust target \
             (`rustup target add {}`) and QEMU for Arm (Debian, Ubuntu: `apt-get install qemu-system-arm`; macOS: `brew install qemu`)",
            TARGET
        ))
        .into());
    };
    let run_apt = |arguments: &[&str]| {
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
    run_apt(&["update", "--quiet"])?;
    let mut install = vec!["install", "--quiet", "--yes", "--no-install-recommends"];
    install.extend(packages);
    run_apt(&install)
}
