//! `explain`: the cost of each term of a scene's model, and the error without it.

use clap::Args;
use robot_compiler::SceneFile;
use sim::failure::Failure;
use sim::terminal::{json, print};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use studies::explain::explain;
use studies::trade::chip::Chip;

const EXAMPLE: &str = "Example:\n  newtau explain scenes/puma560_pick.toml";

const EXAMPLES: &str = "\
For every term of the model (gravity, payload, tip wrench, rotors, velocity terms, friction feedforward):
  is            absent, constant, live, or given up by `terms = \"auto\"`; and the line that says so
  mul add sub   operations of a tick's inverse dynamics and friction that go with it: the kernel compiled with and without, at the
                scene's level (exact where the scene runs the recursion); friction as its formula has it
  torque error  what the model leaves out without the term, on the scene's own reference motion
  tracking      greatest error of the closed loop without the term, in the scene's world, which keeps it
A term may go if its torque error stays within the tolerance on every joint: a share of the joint's torque limit or, where it has none, of its
greatest torque on the motion. With such a joint, the greatest tracking error may be at most twice the full model's, too. Which may go
together is searched over all sets, as `terms = \"auto\"` in a scene's [model] does it.

--chip builds the controller's tick with every term and without each, runs it on the emulated chip, and shows what goes with the term:
  instructions  of a tick, mean over consecutive ticks of the scene's motion
  cycles        an estimate
  flash         bytes of the tick and all that it reaches
  interrupt without, share without
                estimated cycles of the whole interrupt that the firmware runs, and their share of 168 MHz at the scene's rate

Examples:
  newtau explain scenes/puma560_pick.toml
  newtau explain scenes/puma560_pick.toml --tolerance 0.05
  newtau explain scenes/puma560_pick.toml --chip
  newtau explain scenes/puma560_auto.toml --json | jq .fewest.given_up";

/// Options of `explain`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct ExplainArgs {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// Allowed torque error, as a share of each joint's torque limit. Without it, the scene's, or 0.002.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Measure the instructions of each term on the emulated chip. Installs what this needs.
    #[arg(long)]
    pub chip: bool,
    /// Print JSON instead of tables.
    #[arg(long)]
    pub json: bool,
}

/// Explains a scene.
///
/// # Errors
/// A scene that is wrong or cannot be run; an invalid tolerance.
pub fn run(args: &ExplainArgs, chip: &dyn Chip, stop: &AtomicBool) -> Result<(), Failure> {
    let file = SceneFile::load(&args.scene).map_err(Failure::input)?;
    if let Some(tolerance) = args.tolerance.filter(|tolerance| !(0.0..=0.5).contains(tolerance)) {
        return Err(Failure::Input(miette::miette!(
            "--tolerance {tolerance}: expected a share of each joint's torque limit, 0 to 0.5"
        )));
    }
    let mut explanation = explain(&file, args.tolerance, stop)?;
    if args.chip {
        explanation.measure(&args.scene, chip, stop)?;
    }
    let text = if args.json { json(&explanation)? + "\n" } else { explanation.text() };
    print(&text)
}
