//! `firmware flash`: builds a scene's firmware and writes it to a board.
//!
//! Everything that needs no probe is checked first: the board is a real one, it has connections for the scene's drives, the tool is installed, and
//! the log of the built program can be decoded. The tool does the rest.

pub mod key;
mod scene_choice;

use crate::bad_input::BadInput;
use crate::board::{Board, Chip, Trust};
use crate::build::Build;
use crate::log_strings;
use crate::process::{root, run, shown, which};
use anyhow::Result;
use scene_choice::Wanted;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The probe's tool, and the command that installs it.
const PROBE_TOOL: &str = "probe-rs";
const INSTALL: &str = "cargo install probe-rs-tools --locked";

/// Options of `firmware flash`.
#[derive(Clone, Debug, clap::Args)]
pub struct FlashOptions {
    /// The board that the probe is wired to
    #[arg(long, value_enum)]
    board: Board,
    /// The scene whose arm and controller are built in. Without it and without --robot, the board's example
    #[arg(long, conflicts_with = "robot")]
    scene: Option<PathBuf>,
    /// The robot. Its scene under scenes/ is used, if exactly one fits the board
    #[arg(long)]
    robot: Option<PathBuf>,
    /// Accept every host, without a key. Only for the bench: the firmware reports this to every host
    #[arg(long)]
    insecure: bool,
    /// Stay connected and print the program's log. Only with the drives' power off (docs/flash.md)
    #[arg(long)]
    log: bool,
    /// The probe, if there are several: VID:PID or VID:PID:SERIAL, as `probe-rs list` shows it
    #[arg(long, value_name = "SELECTOR")]
    probe: Option<String>,
    /// Check board and scene, and print the commands without running them
    #[arg(long)]
    dry_run: bool,
}

/// Builds the firmware for a board and a scene, and writes it through a probe.
///
/// # Errors
/// [`BadInput`] for an emulated board, a scene that does not fit, or a missing tool; a build or a tool that fails.
pub fn flash(options: &FlashOptions) -> Result<()> {
    let board = options.board;
    is_real(board)?;
    let wanted = match (&options.scene, &options.robot) {
        (Some(scene), _) => Wanted::Scene(scene.clone()),
        (None, Some(robot)) => Wanted::Robot(robot.clone()),
        (None, None) => Wanted::Scene(root().join(board.scene())),
    };
    let scene = scene_choice::choose(&wanted, board)?;
    println!("board    {board}: {}", board.chip().probe_name());
    println!("scene    {}", shown(&scene.path));
    println!("drives   {}", scene.drives);
    let build = Build { trust: Trust::insecure(options.insecure), ..Build::of(&scene.path, board) };
    let program = build.program()?;
    let steps = probe_steps(options, &program);
    let tool = which(PROBE_TOOL);
    if options.dry_run {
        let insecure = if options.insecure { " --insecure" } else { "" };
        println!("$ newtau firmware build --board {board} --scene {}{insecure}", shown(&scene.path));
        steps.iter().for_each(|step| println!("$ {PROBE_TOOL} {}", line(step)));
        if tool.is_none() {
            eprintln!("note: {PROBE_TOOL} is not on the path: `{INSTALL}`");
        }
        return Ok(());
    }
    let tool = tool.ok_or_else(no_tool)?;
    let built = build.run()?;
    println!("program  {}", shown(&built));
    println!("log      {} strings, read over RTT", log_strings::count_over_rtt(&built)?);
    run_steps(&tool, &steps)?;
    if !options.log {
        println!("flashed, and started: `newtau doctor --port PORT --scene {}` asks it who it is", shown(&scene.path));
    }
    Ok(())
}

/// Writes a built program other than the firmware to an STM32F405, and starts it.
///
/// # Errors
/// [`BadInput`] for a missing tool; a tool that fails.
pub fn write_program(program: &Path) -> Result<()> {
    let tool = which(PROBE_TOOL).ok_or_else(no_tool)?;
    run_steps(
        &tool,
        &[
            probe_call(Chip::F405, "download", None, &["--verify"], Some(program)),
            probe_call(Chip::F405, "reset", None, &[], None),
        ],
    )
}

/// Runs calls of the probe's tool one after the other, and prints each.
fn run_steps(tool: &Path, steps: &[Vec<OsString>]) -> Result<()> {
    for step in steps {
        println!("$ {PROBE_TOOL} {}", line(step));
        run(Command::new(tool).args(step))?;
    }
    Ok(())
}

fn no_tool() -> BadInput {
    BadInput(format!("{PROBE_TOOL}: found none on the path, expected it there: `{INSTALL}`"))
}

/// Returns the full path of a scene, if a real board has connections for its drives.
///
/// # Errors
/// [`BadInput`] for an emulated board, a wrong file, or drives of another kind.
pub fn fitting(scene: &Path, board: Board) -> Result<PathBuf> {
    is_real(board)?;
    Ok(scene_choice::choose(&Wanted::Scene(scene.to_owned()), board)?.path)
}

fn is_real(board: Board) -> Result<()> {
    if board != Board::Netduinoplus2 {
        return Ok(());
    }
    let real: Vec<_> = Board::ALL.into_iter().filter(|board| *board != Board::Netduinoplus2).map(Board::name).collect();
    let real = real.join(", ");
    Err(BadInput(format!("--board {board}: found the emulated board, expected one of {real}")).into())
}

/// Calls of the tool, in order. `run` resets the chip, and then keeps running to print the log.
fn probe_steps(options: &FlashOptions, program: &Path) -> Vec<Vec<OsString>> {
    let probe = options.probe.as_deref();
    let call = |subcommand: &str, more: &[&str], file: Option<&Path>| {
        probe_call(options.board.chip(), subcommand, probe, more, file)
    };
    if options.log {
        vec![call("run", &["--verify"], Some(program))]
    } else {
        vec![call("download", &["--verify"], Some(program)), call("reset", &[], None)]
    }
}

/// Arguments of one call of the tool.
fn probe_call(chip: Chip, subcommand: &str, probe: Option<&str>, more: &[&str], file: Option<&Path>) -> Vec<OsString> {
    let mut words: Vec<OsString> = [subcommand, "--chip", chip.probe_name()].map(OsString::from).into();
    if let Some(probe) = probe {
        words.extend(["--probe", probe].map(OsString::from));
    }
    words.extend(more.iter().map(OsString::from));
    words.extend(file.map(|file| file.as_os_str().to_owned()));
    words
}

/// A command line as a person would type it in the project's folder.
fn line(words: &[OsString]) -> String {
    let words: Vec<_> = words.iter().map(|word| shown(Path::new(word))).collect();
    words.join(" ")
}
