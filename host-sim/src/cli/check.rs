//! `check`: checks a robot file for impossible, placeholder and missing values

use crate::cli::chain::ChainArgs;
use clap::Args;
use robot_compiler::check::{Draft, Severity};
use sim::failure::{FAULT, Failure};
use sim::terminal::{json, print};
use std::path::PathBuf;
use studies::check::answer_in;
use studies::options::GravityArgs;
use studies::robot_or_scene::scene_about;

const EXAMPLE: &str = "Example:\n  newtau check robots/ur5.toml";

const EXAMPLES: &str = "\
Examples:
  newtau check robots/ur5.toml
  newtau check arm.urdf --tip gripper_base
  newtau check robots/planar2r.toml --gravity 0,-9.81,0
  newtau check robots/yam.toml --scene scenes/yam_move.toml
  newtau check arm.urdf --json | jq '.findings[] | select(.severity == \"wrong\")'

Every finding has its place in the file, what is wrong with the number, and what to measure or write instead:
  wrong   no physics allows it, or the arm cannot hold itself
  doubt   improbable: a placeholder, a unit, a missing value
  note    missing: measure it; or a setting of the scene to think about
The rules, with their thresholds, stand in robots/README.md.

Loads are those of the worst posture: for each joint, the search of `statics --minimise` looks inside the position limits (one turn
where a joint has none) for the largest torque of gravity, and for the least and the largest inertia that the joint feels. Nothing
is held by the tip.

Below the findings stands what matters to a person near the arm: its mass, how fast and strong the limits let it be, and how far it goes before
it rests, each with its formula, beside class I of ISO 10218-1:2025. Rate, latency, deceleration, payload and the posture for the force
are those of --scene.

A file that cannot be read is bad input, exit code 2. Otherwise the exit code is 3 when a finding is `wrong`, and 0 when none is.

--json is an object {robot, gravity, wrong, doubts, notes, findings, hazard, class_i}, each finding {severity, rule, file, line, column,
field, problem, advice}.";

/// Options of `check`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct CheckArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// A scene of this robot, to check what depends on its controller: collision reaction, stopping, payload, rest pose. Without it, the robot's
    /// default scene.
    #[arg(long, value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    /// Gravity.
    #[command(flatten)]
    pub gravity: GravityArgs,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Prints the findings. Returns the exit code.
///
/// # Errors
/// [`Failure::Input`] for a file that cannot be read, or a wrong option.
pub fn run(args: &CheckArgs) -> Result<u8, Failure> {
    let draft = Draft::load_between(&args.robot, args.chain.ends()).map_err(Failure::input)?;
    let scene =
        args.scene.as_deref().map(|path| scene_about(&args.robot, args.chain.ends(), Some(path))).transpose()?;
    let gravity = args.gravity.of(&draft.robot);
    let answer = answer_in(draft, &gravity, scene)?;
    print(&if args.json { json(&answer.json())? + "\n" } else { answer.text() })?;
    Ok(if answer.count(Severity::Wrong) > 0 { FAULT } else { 0 })
}
