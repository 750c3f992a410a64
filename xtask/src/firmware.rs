//! Building the firmware for a scene and a board.

pub(crate) mod can_buses;
pub(crate) mod cost;

use crate::bad_input::BadInput;
use crate::emitted;
use crate::scene_keys::SceneKeys;
use crate::toolchain::{self, Toolchain};
use anyhow::{Context as _, Result};
use can_buses::{CanBuses, Schedule};
use robot_compiler::SceneFile;
use std::ffi::OsStr;
use std::fmt;
use std::fs::File;
use std::path::{Path, PathBuf};

/// The default scene.
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
    /// An STM32G474 with MIT-mode actuators on three CAN FD buses
    G474Fdcan,
}

impl Board {
    /// All of them.
    pub(crate) const ALL: [Self; 5] =
        [Self::Netduinoplus2, Self::OdriveV3, Self::F405Can, Self::F405Pwm, Self::G474Fdcan];

    /// The name of its Cargo feature and of the board.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Netduinoplus2 => "netduinoplus2",
            Self::OdriveV3 => "odrive-v3",
            Self::F405Can => "f405-can",
            Self::F405Pwm => "f405-pwm",
            Self::G474Fdcan => "g474-fdcan",
        }
    }

    /// The default scene of the board: its robot has drives of the kind that the board has lines for.
    pub(crate) const fn scene(self) -> &'static str {
        match self {
            Self::Netduinoplus2 | Self::OdriveV3 => SCENE_DEFAULT,
            Self::F405Can => "scenes/examples/mit6_wave.toml",
            Self::F405Pwm => "scenes/examples/pwm2_swing.toml",
            Self::G474Fdcan => "scenes/examples/mit6_fd_wave.toml",
        }
    }

    /// The kind of drives that the board has lines for, as a robot file names it. `None` for a board that only talks to
    /// its host and so takes any arm. Another kind would not compile; this check reports it before the compiler starts.
    pub(crate) const fn drives(self) -> Option<&'static str> {
        match self {
            Self::Netduinoplus2 | Self::OdriveV3 => None,
            Self::F405Can | Self::G474Fdcan => Some("mit"),
            Self::F405Pwm => Some("pwm"),
        }
    }

    /// Its CAN controllers; `None` for a board without.
    const fn can_buses(self) -> Option<CanBuses> {
        match self {
            Self::Netduinoplus2 | Self::OdriveV3 | Self::F405Pwm => None,
            Self::F405Can => Some(CanBuses { count: 2, fd: false }),
            Self::G474Fdcan => Some(CanBuses { count: 3, fd: true }),
        }
    }

    /// Its chip.
    pub(crate) const fn chip(self) -> Chip {
        match self {
            Self::Netduinoplus2 | Self::OdriveV3 | Self::F405Can | Self::F405Pwm => Chip::F405,
            Self::G474Fdcan => Chip::G474,
        }
    }
}

/// A microcontroller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Chip {
    /// STM32F405.
    F405,
    /// STM32G474.
    G474,
}

impl Chip {
    /// Its name for probe-rs.
    pub(crate) const fn probe_name(self) -> &'static str {
        match self {
            Self::F405 => "STM32F405RGTx",
            Self::G474 => "STM32G474RETx",
        }
    }

    /// Address of the link key's page, as the chip's `chip_memory.x` has it; a test compares both.
    pub(crate) const fn key_page(self) -> &'static str {
        match self {
            Self::F405 => "0x080e0000",
            Self::G474 => "0x0807f000",
        }
    }

    /// Clock of its core as the boards set it, Hz.
    pub(crate) const fn clock_hz(self) -> f64 {
        match self {
            Self::F405 => 168e6,
            Self::G474 => 170e6,
        }
    }
}

impl fmt::Display for Board {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Whom a firmware lets talk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Trust {
    /// A host with the key in the board's key page.
    #[default]
    Key,
    /// Anybody on the wire.
    Anybody,
}

impl Trust {
    /// The choice of `--insecure`.
    pub(crate) const fn insecure(insecure: bool) -> Self {
        if insecure { Self::Anybody } else { Self::Key }
    }

    /// Part of a program's file name.
    const fn suffix(self) -> &'static str {
        match self {
            Self::Key => "",
            Self::Anybody => "-insecure",
        }
    }
}

/// Builds the firmware; returns a copy that later builds for other scenes do not touch.
pub(crate) fn build(scene: &Path, board: Board) -> Result<PathBuf> {
    build_trusting(scene, board, Trust::Key)
}

/// As [`build`], for a host with the board's key or for anybody.
pub(crate) fn build_trusting(scene: &Path, board: Board, trust: Trust) -> Result<PathBuf> {
    let more = if trust == Trust::Anybody { ",insecure" } else { "" };
    build_with(scene, board, more, trust.suffix())
}

/// The emulated board's firmware with the boards' link by DMA, a stand-in in the place of the hardware.
pub(crate) fn build_with_stand_in(scene: &Path) -> Result<PathBuf> {
    build_with(scene, Board::Netduinoplus2, ",dma", "-dma")
}

/// Builds with more features than the board's own; the suffix is part of the program's name.
fn build_with(scene: &Path, board: Board, more: &str, suffix: &str) -> Result<PathBuf> {
    for_the_bench(scene, board)?;
    schedules(scene, board)?;
    let scene = scene.canonicalize().with_context(|| format!("no scene file {}", scene.display()))?;
    let toolchain = Toolchain::find_or_install()?;
    let folder = toolchain::target_directory();
    let _lock = lock(&folder)?;
    let mut cargo = toolchain.cargo("build");
    cargo.args(["--quiet", "--package", "firmware", "--bin", "firmware", "--no-default-features"]);
    cargo.args(["--features", &format!("{board}{more}")]).env("NEWTAU_ARM", emitted::arm(&scene)?);
    cargo.env("DEFMT_LOG", std::env::var("DEFMT_LOG").unwrap_or_else(|_| "info".into()));
    let built = toolchain::build(&mut cargo, toolchain::product("firmware"))?;
    keep(&std::fs::read(&built)?, place(&scene, board, suffix))
}

/// Rejects a scene for the bench only on a board that exists: its bounds on lateness are lifted.
///
/// # Errors
/// [`BadInput`]: `safety.bench_only = true` and a board other than the emulated one.
fn for_the_bench(scene: &Path, board: Board) -> Result<()> {
    if board != Board::Netduinoplus2 && SceneKeys::read(scene)?.bench_only() {
        let problem = format!(
            "{}: safety.bench_only: its bounds on old measurements are lifted, which no arm may be driven with; expected the emulated \
             board {}, or `bench_only = false`",
            scene.display(),
            Board::Netduinoplus2
        );
        return Err(BadInput(problem).into());
    }
    Ok(())
}

/// What the scene's frames take of the board's CAN buses; none on a board without.
///
/// # Errors
/// [`BadInput`]: drives that the board does not reach, or a rate that its buses do not hold.
pub(crate) fn schedules(scene: &Path, board: Board) -> Result<Vec<Schedule>> {
    if board.can_buses().is_none() {
        return Ok(Vec::new());
    }
    let file = SceneFile::load(scene).map_err(|error| BadInput(format!("{error}; expected {}", error.expected())))?;
    Ok(can_buses::schedules(&file, scene, board).map_err(BadInput)?)
}

/// Path where [`build_trusting`] puts the program, even before it is built.
pub(crate) fn program(scene: &Path, board: Board, trust: Trust) -> Result<PathBuf> {
    let scene = scene.canonicalize().with_context(|| format!("no scene file {}", scene.display()))?;
    Ok(place(&scene, board, trust.suffix()))
}

fn place(scene: &Path, board: Board, suffix: &str) -> PathBuf {
    toolchain::target_directory().join(format!("{}-{board}{suffix}.elf", scene_hash(scene)))
}

/// Name of a scene and hash of its path and of the environment's changes to it, for the names of generated files.
pub(crate) fn scene_hash(scene: &Path) -> String {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    format!("{stem}-{:08x}", short_hash(scene, &robot_compiler::emit::CHOICES))
}

/// Locks build and copy against other processes: two test processes may request two scenes at once.
fn lock(folder: &Path) -> Result<File> {
    std::fs::create_dir_all(folder)?;
    let lock = File::create(folder.join("xtask.lock"))?;
    lock.lock()?;
    Ok(lock)
}

/// Copies a program to a place that later builds do not touch.
fn keep(text: &[u8], copy: PathBuf) -> Result<PathBuf> {
    // A running emulator may hold the old copy open. So an equal copy is left alone, and another is replaced by a new file.
    if std::fs::read(&copy).ok().as_deref() != Some(text) {
        let fresh = copy.with_extension("new");
        std::fs::write(&fresh, text)?;
        std::fs::rename(&fresh, &copy)?;
    }
    Ok(copy)
}

/// Distinguishes scenes of one name in two folders, and the environment's changes to one (FNV-1a, 32 bits).
fn short_hash(path: &Path, choices: &[&str]) -> u32 {
    let add = |hash: u32, text: &OsStr| fnv1a(hash, text.as_encoded_bytes());
    let start = add(0x811c_9dc5, path.as_os_str());
    choices.iter().filter_map(std::env::var_os).fold(start, |hash, choice| add(hash, &choice))
}

fn fnv1a(hash: u32, bytes: &[u8]) -> u32 {
    bytes.iter().fold(hash, |hash, byte| (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193))
}
