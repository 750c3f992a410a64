//! Building the firmware for a scene and a board.

pub(crate) mod cost;

use crate::emitted;
use crate::toolchain::{self, Toolchain};
use anyhow::{Context as _, Result};
use std::ffi::OsStr;
use std::fmt;
use std::fs::File;
use std::path::{Path, PathBuf};

/// The scene that is built in when none is named.
pub(crate) const SCENE_DEFAULT: &str = "scenes/puma560_pick.toml";

/// A board that the firmware runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Board {
    /// The emulated one
    Netduinoplus2,
    /// ODrive v3 and its like
    OdriveV3,
    /// A bare STM32F405 with MIT-mode actuators on two CAN buses
    F405Can,
    /// A bare STM32F405 with H-bridges on PWM and magnetic encoders
    F405Pwm,
}

impl Board {
    /// All of them.
    pub(crate) const ALL: [Self; 4] = [Self::Netduinoplus2, Self::OdriveV3, Self::F405Can, Self::F405Pwm];

    /// The name of its feature, and what people call it.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Netduinoplus2 => "netduinoplus2",
            Self::OdriveV3 => "odrive-v3",
            Self::F405Can => "f405-can",
            Self::F405Pwm => "f405-pwm",
        }
    }

    /// The scene that is built in when none is named: its robot has drives of the kind that the board has lines for.
    pub(crate) const fn scene(self) -> &'static str {
        match self {
            Self::Netduinoplus2 | Self::OdriveV3 => SCENE_DEFAULT,
            Self::F405Can => "scenes/examples/mit6_wave.toml",
            Self::F405Pwm => "scenes/examples/pwm2_swing.toml",
        }
    }

    /// The kind of drives that the board has lines for, as a robot file calls it; `None` for a board that talks to its host
    /// alone and so takes any arm. Another kind does not compile either: this says it before the compiler starts.
    pub(crate) const fn drives(self) -> Option<&'static str> {
        match self {
            Self::Netduinoplus2 | Self::OdriveV3 => None,
            Self::F405Can => Some("mit"),
            Self::F405Pwm => Some("pwm"),
        }
    }
}

impl fmt::Display for Board {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Build the firmware; the answer is a copy that later builds for other scenes leave alone.
pub(crate) fn build(scene: &Path, board: Board) -> Result<PathBuf> {
    let scene = scene.canonicalize().with_context(|| format!("no scene file {}", scene.display()))?;
    let toolchain = Toolchain::find_or_install()?;
    let folder = toolchain::target_directory();
    let _lock = lock(&folder)?;
    let mut cargo = toolchain.cargo("build");
    cargo.args(["--quiet", "--package", "firmware", "--bin", "firmware", "--no-default-features"]);
    cargo.args(["--features", board.name()]).env("NEWTAU_ARM", emitted::arm(&scene)?);
    cargo.env("DEFMT_LOG", std::env::var("DEFMT_LOG").unwrap_or_else(|_| "info".into()));
    let built = toolchain::build(&mut cargo, toolchain::product("firmware"))?;
    keep(&std::fs::read(&built)?, program(&scene, board)?)
}

/// Where [`build`] leaves the program, whether it has been built or not.
pub(crate) fn program(scene: &Path, board: Board) -> Result<PathBuf> {
    let scene = scene.canonicalize().with_context(|| format!("no scene file {}", scene.display()))?;
    Ok(toolchain::target_directory().join(format!("{}-{board}.elf", scene_hash(&scene))))
}

/// Name of a scene and hash of its path, and of what the environment changes in it: for files that are made from it.
pub(crate) fn scene_hash(scene: &Path) -> String {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    format!("{stem}-{:08x}", short_hash(scene, &robot_compiler::emit::CHOICES))
}

/// Between build and copy nobody else may build: two test processes may ask for two scenes at once.
fn lock(folder: &Path) -> Result<File> {
    std::fs::create_dir_all(folder)?;
    let lock = File::create(folder.join("xtask.lock"))?;
    lock.lock()?;
    Ok(lock)
}

/// Put a program where later builds leave it alone.
fn keep(text: &[u8], copy: PathBuf) -> Result<PathBuf> {
    // A running emulator may hold the old copy open: leave it alone when nothing changed, else put a new one in its place.
    if std::fs::read(&copy).ok().as_deref() != Some(text) {
        let fresh = copy.with_extension("new");
        std::fs::write(&fresh, text)?;
        std::fs::rename(&fresh, &copy)?;
    }
    Ok(copy)
}

/// Tells apart scenes of one name in two folders, and what the environment changes in one (FNV-1a, 32 bits).
fn short_hash(path: &Path, choices: &[&str]) -> u32 {
    let add = |hash: u32, text: &OsStr| fnv1a(hash, text.as_encoded_bytes());
    let start = add(0x811c_9dc5, path.as_os_str());
    choices.iter().filter_map(std::env::var_os).fold(start, |hash, choice| add(hash, &choice))
}

fn fnv1a(hash: u32, bytes: &[u8]) -> u32 {
    bytes.iter().fold(hash, |hash, byte| (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193))
}
