//! Build of the firmware for a scene and a board.

use crate::bad_input::BadInput;
use crate::board::{Board, Trust};
use crate::can_buses::{self, Schedule};
use crate::emitted;
use crate::toolchain::{self, Toolchain};
use anyhow::{Context as _, Result};
use robot_compiler::SceneFile;
use robot_compiler::emit::Choices;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Settings of a program's build.
#[derive(Clone, Copy, Debug)]
pub struct Build<'a> {
    /// The scene whose arm and controller are built in.
    pub scene: &'a Path,
    /// The board.
    pub board: Board,
    /// Hosts that the firmware accepts.
    pub trust: Trust,
    /// Changes of the control law or of the sine and cosine method, relative to the scene file.
    pub choices: Choices<'a>,
    /// True if a software stand-in for DMA moves the bytes of the emulated board's link, so that it uses the driver of the other boards.
    pub dma_stand_in: bool,
    /// Additional environment variables for cargo, by name and value.
    pub environment: &'a [(&'a str, &'a str)],
}

impl<'a> Build<'a> {
    /// Settings for a scene as its file specifies it, for a host with the board's key.
    #[must_use]
    pub fn of(scene: &'a Path, board: Board) -> Self {
        Self { scene, board, trust: Trust::Key, choices: Choices::default(), dma_stand_in: false, environment: &[] }
    }

    /// Builds the program. Returns a copy that later builds for other scenes do not change. Installs a missing tool chain, and prints that.
    ///
    /// # Errors
    /// [`BadInput`]: a wrong scene, or one that does not fit the board. Others: a compiler that cannot be installed, or fails.
    pub fn run(&self) -> Result<PathBuf> {
        for_the_bench(self.scene, self.board)?;
        schedules(self.scene, self.board)?;
        let toolchain = Toolchain::find_or_install()?;
        let folder = toolchain::target_directory();
        let _lock = lock(&folder)?;
        let mut cargo = toolchain.cargo("build");
        cargo.args(["--quiet", "--package", "firmware", "--bin", "firmware", "--no-default-features"]);
        cargo.args(["--features", &self.features()]).env("NEWTAU_ARM", emitted::arm(&self.scene()?, self.choices)?);
        cargo.env("DEFMT_LOG", std::env::var("DEFMT_LOG").unwrap_or_else(|_| "info".into()));
        cargo.envs(self.environment.iter().copied());
        let built = toolchain::build(&mut cargo, toolchain::product("firmware"))?;
        keep(&std::fs::read(&built)?, self.program()?)
    }

    /// Path of the copy that [`Build::run`] returns, even before it is built.
    ///
    /// # Errors
    /// The scene file does not exist.
    pub fn program(&self) -> Result<PathBuf> {
        let stand_in = if self.dma_stand_in { "-dma" } else { "" };
        let name = emitted::scene_hash(&self.scene()?, self.choices);
        Ok(toolchain::target_directory().join(format!("{name}-{}{}{stand_in}.elf", self.board, self.trust.suffix())))
    }

    fn scene(&self) -> Result<PathBuf> {
        self.scene.canonicalize().with_context(|| format!("no scene file {}", self.scene.display()))
    }

    fn features(&self) -> String {
        let insecure = if self.trust == Trust::Anybody { ",insecure" } else { "" };
        let stand_in = if self.dma_stand_in { ",dma" } else { "" };
        format!("{}{insecure}{stand_in}", self.board)
    }
}

/// Rejects a bench-only scene on a real board, because such a scene has no limits on late ticks.
///
/// # Errors
/// [`BadInput`]: a wrong scene, or `safety.bench_only = true`, and a board other than the emulated one.
fn for_the_bench(scene: &Path, board: Board) -> Result<()> {
    if board != Board::Netduinoplus2 && load(scene)?.safety.bench_only {
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

/// Schedules of the scene's frames on the board's CAN buses; none for a board without CAN.
///
/// # Errors
/// [`BadInput`]: drives that the board cannot reach, or a rate at which the frames do not fit.
pub fn schedules(scene: &Path, board: Board) -> Result<Vec<Schedule>> {
    if board.can_buses().is_none() {
        return Ok(Vec::new());
    }
    Ok(can_buses::schedules(&load(scene)?, scene, board).map_err(BadInput)?)
}

fn load(scene: &Path) -> Result<SceneFile, BadInput> {
    SceneFile::load(scene).map_err(|error| BadInput::from(&error))
}

/// Locks build and copy against other processes, because two test processes may request two scenes at once.
pub fn lock(folder: &Path) -> Result<File> {
    std::fs::create_dir_all(folder)?;
    let lock = File::create(folder.join("firmware.lock"))?;
    lock.lock()?;
    Ok(lock)
}

/// Copies a program to a path that later builds do not change.
pub fn keep(text: &[u8], copy: PathBuf) -> Result<PathBuf> {
    // A running emulator may hold the old copy open. So an equal copy is left alone, and a different one is replaced by a new file.
    if std::fs::read(&copy).ok().as_deref() != Some(text) {
        let fresh = copy.with_extension("new");
        std::fs::write(&fresh, text)?;
        std::fs::rename(&fresh, &copy)?;
    }
    Ok(copy)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::for_the_bench;
    use crate::board::Board;
    use crate::process::root;
    use crate::scratch::ScratchFile;

    #[test]
    fn a_scene_for_the_bench_is_built_for_the_emulated_board_alone() {
        let robots = root().join("robots");
        let text = std::fs::read_to_string(root().join("scenes/planar2r_swing.toml")).unwrap();
        let text = text.replace("../robots", robots.to_str().unwrap());
        let scene = ScratchFile::new("bench.toml").unwrap();
        for (bench_only, board, is_built) in
            [(true, Board::F405Can, false), (true, Board::Netduinoplus2, true), (false, Board::F405Can, true)]
        {
            std::fs::write(scene.path(), format!("{text}\n[safety]\nbench_only = {bench_only}\n")).unwrap();
            assert_eq!(for_the_bench(scene.path(), board).is_ok(), is_built, "{bench_only} {board}");
        }
    }
}
