//! `connect replay`: replays a record of `connect` with the same session on the desk.

use board::chip::hello_of;
use board::session::frame_log::{Head, Log};
use board::session::replay::{Replay, replay_log};
use clap::Args;
use link::Pacing;
use robot_compiler::SceneFile;
use sim::failure::{self, Failure};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

const EXAMPLE: &str = "Example:\n  newtau connect replay out/session.log";

const EXAMPLES: &str = "\
Examples:
  newtau connect scenes/planar2r_swing.toml --target qemu --script session.txt --record out/session.log
  newtau connect replay out/session.log

The record, MCAP or not, holds its scene; the robot file is read from where it was, or --scene names a scene beside it. It must be the robot, scene and
controller that the board was built from, by their hash.

Exit code 1: a tick differs, or the record cannot be replayed to its end; the message says which tick and why.";

/// Options of `replay`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct ReplayArgs {
    /// The record.
    pub log: PathBuf,
    /// The scene file. Without it, the scene in the record.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Print the result as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Replays a record. Returns the exit code.
///
/// # Errors
/// A file that cannot be read, or a scene that differs from the record's.
pub fn run(args: &ReplayArgs) -> Result<u8, Failure> {
    let in_log = |problem: &dyn std::fmt::Display| Failure::Input(miette::miette!("{}: {problem}", args.log.display()));
    let bytes = std::fs::read(&args.log).map_err(|error| in_log(&error))?;
    let log = Log::new(bytes).map_err(|error| in_log(&error))?;
    let scene = match &args.scene {
        Some(path) => SceneFile::load(path),
        None => SceneFile::from_toml_str(&log.head.text, &log.head.scene),
    };
    let scene = scene.map_err(Failure::input)?;
    same(&log.head, hello_of(&scene, Pacing::LockStep)?.robot, args)?;
    let done = replay_log(&scene, &log).map_err(|error| in_log(&error))?;
    show(args, &done, &log).map_err(Failure::Output)?;
    Ok(if done.is_the_same() { 0 } else { failure::OUTSIDE })
}

/// Checks that the record was made with this robot, scene and controller.
fn same(head: &Head, found: u64, args: &ReplayArgs) -> Result<(), Failure> {
    if head.hash == found {
        return Ok(());
    }
    let scene: &Path = args.scene.as_deref().unwrap_or(&head.scene);
    Err(Failure::Input(miette::miette!(
        "{}: hash {:016x}, and {} with its robot file has {found:016x}: the record is of another robot, scene or controller",
        args.log.display(),
        head.hash,
        scene.display()
    )))
}

fn show(args: &ReplayArgs, replay: &Replay, log: &Log) -> io::Result<()> {
    let mut out = io::stdout().lock();
    if args.json {
        return writeln!(out, "{}", serde_json::to_string(replay)?);
    }
    writeln!(out, "{} ticks compared, {} differ", replay.ticks, replay.differences)?;
    if let Some(first) = &replay.first {
        writeln!(out, "first in tick {}: {}", first.tick, first.field)?;
        writeln!(out, "  recorded  {}", first.recorded)?;
        writeln!(out, "  replayed  {}", first.replayed)?;
    }
    if let Some(end) = &replay.end {
        writeln!(out, "cannot be replayed from tick {} on: {}", end.tick, end.why)?;
    }
    match log.cut() {
        0 if log.has_end() => {}
        0 => writeln!(out, "the record was not closed: its last second may be missing")?,
        cut => writeln!(out, "the record ends within an entry: its last {cut} bytes are left out")?,
    }
    Ok(())
}
