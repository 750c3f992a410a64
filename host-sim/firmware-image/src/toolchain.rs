//! Tool chain for the chip's programs.
//!
//! The preferred tool chain is rustup's, with its precompiled `core` for the target. If rustup cannot download that, Debian's rustc is used, and
//! `core` is built here from the library's sources.

use crate::board::TARGET;
use crate::process::{output, root, run, which};
use anyhow::{Result, bail};
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The Cargo profile of the chip's programs (Cargo.toml).
const PROFILE: &str = "firmware";

/// Oldest rustc that builds this workspace (`rust-version` in Cargo.toml).
const MINOR_MIN: u32 = 95;

/// Environment variable with the only allowed tool chain, `rustup` or `debian`, so that the second one can be tested.
const CHOICE: &str = "NEWTAU_TOOLCHAIN";

fn allowed(name: &str) -> bool {
    std::env::var(CHOICE).map_or(true, |choice| choice == name)
}

/// A tool chain that can build for the chip.
#[derive(Clone, Debug, PartialEq)]
pub enum Toolchain {
    /// The cargo that runs this task, with the target installed.
    Rustup,
    /// Debian's compiler, with `core` built from source.
    Debian {
        /// The linker.
        linker: PathBuf,
    },
}

impl fmt::Display for Toolchain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rustup => write!(f, "rustup's tool chain, target {TARGET} installed"),
            Self::Debian { linker } => {
                write!(f, "Debian's /usr/bin/rustc, core built from source, linked by {}", linker.display())
            }
        }
    }
}

impl Toolchain {
    /// The installed tool chain; rustup's is preferred.
    pub fn find() -> Option<Self> {
        if allowed("rustup") && has_target(&sysroot()?) {
            return Some(Self::Rustup);
        }
        (allowed("debian") && debian_is_new_enough()).then(linker).flatten().map(|linker| Self::Debian { linker })
    }

    /// The installed tool chain, or one that is installed now. Prints each step.
    pub fn find_or_install() -> Result<Self> {
        if let Some(found) = Self::find() {
            return Ok(found);
        }
        if allowed("rustup") && which("rustup").is_some() {
            eprintln!("setup: rustup target add {TARGET}");
            let added = Command::new("rustup").args(["target", "add", TARGET]).stdin(Stdio::null()).status();
            if added.is_ok_and(|status| status.success())
                && let Some(found) = Self::find()
            {
                return Ok(found);
            }
            eprintln!("setup: rustup could not; trying Debian's tool chain instead");
        }
        if !allowed("debian") {
            bail!("{CHOICE} asks for rustup's tool chain, which has no {TARGET} and cannot fetch it");
        }
        crate::install::apt(&["rustc-web", "cargo-web", "rust-web-src", "binutils-arm-none-eabi"])?;
        match Self::find() {
            Some(found) => Ok(found),
            None => bail!(
                "no tool chain for {TARGET}: either `rustup target add {TARGET}`, or Debian's rustc-web, cargo-web and \
                 rust-web-src of version 1.{MINOR_MIN} or later with binutils-arm-none-eabi"
            ),
        }
    }

    /// The linker for the chip's programs.
    pub fn linker(&self) -> Option<PathBuf> {
        match self {
            Self::Rustup => linker(),
            Self::Debian { linker } => Some(linker.clone()),
        }
    }

    /// Name and version of the compiler, such as `rustc 1.95.0`: instruction counts and sizes are valid for one compiler only.
    pub fn rustc(&self) -> Result<String> {
        rustc_version(match self {
            Self::Rustup => "rustc",
            Self::Debian { .. } => "/usr/bin/rustc",
        })
    }

    /// `cargo SUBCOMMAND` for the chip, optimised, in a separate target folder, so that the two tool chains do not disturb each other's builds.
    pub fn cargo(&self, subcommand: &str) -> Command {
        let mut command = match self {
            Self::Rustup => crate::process::cargo([]),
            Self::Debian { .. } => Command::new("/usr/bin/cargo"),
        };
        command.current_dir(root()).args([subcommand, "--profile", PROFILE, "--target", TARGET]);
        command.arg("--target-dir").arg(target_directory());
        // rustup's cargo sets the first four for its child processes; with them, the other cargo would use the wrong compiler. The last one would
        // split a crate into several units, so that the measured code would differ from the flashed code.
        for name in ["RUSTC", "RUSTUP_TOOLCHAIN", "RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_INCREMENTAL"] {
            command.env_remove(name);
        }
        if let Self::Debian { linker } = self {
            // `-Zbuild-std` needs a nightly compiler or this variable.
            command.arg("-Zbuild-std=core").env("RUSTC", "/usr/bin/rustc").env("RUSTC_BOOTSTRAP", "1");
            command.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", linker);
        }
        command
    }
}

/// Name and version of a compiler, without the hash and date of its build.
pub fn rustc_version(program: &str) -> Result<String> {
    let text = output(Command::new(program).arg("--version"));
    let Some(text) = text else { bail!("{program} --version says nothing") };
    Ok(text.split(' ').take(2).collect::<Vec<_>>().join(" "))
}

/// Target folder of builds for the chip.
pub fn target_directory() -> PathBuf {
    crate::process::target_directory().join("chip")
}

/// Path of a built program for the chip.
pub fn product(name: &str) -> PathBuf {
    target_directory().join(TARGET).join(PROFILE).join(name)
}

fn sysroot() -> Option<PathBuf> {
    output(Command::new("rustc").args(["--print", "sysroot"])).map(PathBuf::from)
}

fn has_target(sysroot: &Path) -> bool {
    sysroot.join("lib/rustlib").join(TARGET).join("lib").is_dir()
}

fn debian_is_new_enough() -> bool {
    let source = Path::new("/usr/lib/rustlib/src/rust/library/core/src/lib.rs").exists()
        || output(Command::new("/usr/bin/rustc").args(["--print", "sysroot"]))
            .is_some_and(|root| Path::new(&root).join("lib/rustlib/src/rust/library/core/src/lib.rs").exists());
    let minor = output(Command::new("/usr/bin/rustc").arg("--version"))
        .and_then(|text| text.split('.').nth(1).and_then(|minor| minor.parse::<u32>().ok()));
    source && Path::new("/usr/bin/cargo").exists() && minor.is_some_and(|minor| minor >= MINOR_MIN)
}

/// rustup's own lld if there is one, otherwise the linker of the cross binutils.
fn linker() -> Option<PathBuf> {
    let host = output(Command::new("rustc").arg("-vV"))
        .and_then(|text| text.lines().find_map(|line| line.strip_prefix("host: ").map(str::to_owned)))?;
    let lld = sysroot().map(|root| root.join("lib/rustlib").join(host).join("bin/rust-lld"));
    lld.filter(|path| path.is_file()).or_else(|| which("arm-none-eabi-ld"))
}

/// Runs a build, and checks that the linked program exists afterwards.
pub fn build(command: &mut Command, product: PathBuf) -> Result<PathBuf> {
    run(command)?;
    if !product.is_file() {
        bail!("{command:?} succeeded, but there is no {}", product.display());
    }
    Ok(product)
}
