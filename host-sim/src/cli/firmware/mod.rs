//! `firmware`: builds and flashes the firmware, and manages the key that a host and a board share.

mod failure;
pub mod key;

use clap::{Args, Subcommand};
use failure::failure;
use firmware_image::build::schedules;
use firmware_image::{Board, Build, Trust, flash};
use sim::failure::Failure;
use sim::terminal::print;
use std::path::PathBuf;

/// Options of `firmware`.
#[derive(Clone, Debug, Args)]
#[command(after_help = "Example:\n  newtau firmware flash --board f405-can --dry-run")]
pub struct FirmwareArgs {
    /// The task.
    #[command(subcommand)]
    pub task: FirmwareTask,
}

/// The task.
#[derive(Clone, Debug, Subcommand)]
pub enum FirmwareTask {
    /// Build the firmware for a scene and a board, and print the path of the program.
    Build(BuildArgs),
    /// Build the firmware, and write it to a real board with probe-rs.
    #[command(after_help = "Example:\n  newtau firmware flash --board f405-can --dry-run")]
    Flash(flash::FlashOptions),
    /// Make the key that a host and a board share, and write it to the board.
    Key(key::KeyArgs),
}

/// Options of `firmware build`.
#[derive(Clone, Debug, Args)]
#[command(after_help = "Example:\n  newtau firmware build --board f405-can --scene scenes/examples/mit6_wave.toml")]
pub struct BuildArgs {
    /// The board.
    #[arg(long, value_enum, default_value_t = Board::Netduinoplus2)]
    pub board: Board,
    /// The scene whose arm and controller are built in. Without it, the board's example.
    #[arg(long)]
    pub scene: Option<PathBuf>,
    /// Accept every host, without a key. Only for the bench: the firmware reports this to every host.
    #[arg(long)]
    pub insecure: bool,
}

/// Does a task of the firmware. Returns the exit code.
///
/// # Errors
/// Errors of the task.
pub fn run(args: &FirmwareArgs) -> Result<u8, Failure> {
    match &args.task {
        FirmwareTask::Build(args) => build(args),
        FirmwareTask::Flash(options) => flash::flash(options).map(|()| 0).map_err(failure),
        FirmwareTask::Key(args) => key::run(args),
    }
}

fn build(args: &BuildArgs) -> Result<u8, Failure> {
    let scene = args.scene.clone().unwrap_or_else(|| firmware_image::process::root().join(args.board.scene()));
    let build = Build { trust: Trust::insecure(args.insecure), ..Build::of(&scene, args.board) };
    let program = build.run().map_err(failure)?;
    let buses: String =
        schedules(&scene, args.board).map_err(failure)?.iter().map(|schedule| format!("{schedule}\n")).collect();
    print(&format!("{buses}firmware for {} with {}: {}\n", args.board, scene.display(), program.display()))?;
    Ok(0)
}
