//! `choose margins`: the margin of each number of a scene before the arm is lost.

use clap::Args;
use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use sim::failure::Failure;
use sim::terminal::{json, print, progress_bar};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use studies::margins::margins;

const EXAMPLE: &str = "Example:\n  newtau choose margins scenes/puma560_pick.toml";

const EXAMPLES: &str = "\
Each number moves away from the scene's own value, alone, until the arm is lost: a fault, a diverging simulation, or a joint that leaves
its reference by more than `reach` of the scene's [safety], where the firmware would hold.
  delay of the torque      actuators.delay, later
  unknown mass at the tip  held, and not told to the controller
  masses of all links      plant.masses, heavier than the controller believes
  friction                 plant.friction, more than the controller believes
  natural frequency        control.natural_frequency, higher; a stiffness with its square
  rate                     control.rate, slower
  counts of the encoders   fewer per turn
The border is found to 3 %. A margin of the simulation is no promise for a real arm: leave room.

Example:
  newtau choose margins scenes/puma560_pick.toml

--json is an object {scene, margins: [{quantity, unit, own, kept, lost, why, missing}]}.";

/// Options of `choose margins`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct MarginsArgs {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Searches for the margins, and prints them.
///
/// # Errors
/// A wrong scene, or one in which the arm is lost without any change; an interruption.
pub fn run(args: &MarginsArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let scene = SceneFile::load(&args.scene).map_err(Failure::input)?;
    let progress = if args.json { ProgressBar::hidden() } else { progress_bar(None, "runs") };
    let found = margins(&scene, stop, &progress)?;
    progress.finish_and_clear();
    print(&if args.json { json(&found)? + "\n" } else { found.table() })
}
