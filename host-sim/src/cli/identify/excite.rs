//! `identify excite`: designs a motion for identification.

use crate::cli::chain::ChainArgs;
use crate::force::ForceArgs;
use clap::Args;
use sim::failure::{Failure, in_file};
use sim::terminal::{json, print, progress_bar};
use std::path::PathBuf;
use studies::excite::{ExciteRequest, design};
use studies::robot_or_scene::RobotOrScene;

const EXAMPLE: &str = "Example:\n  newtau identify excite robots/planar2r.toml --out out/excite.toml";

const EXAMPLES: &str = "\
Examples:
  newtau identify excite scenes/examples/yam_move.toml --out out/excite.toml
  newtau run scenes/examples/yam_move.toml --motion out/excite.toml --duration 33 --out out/excite
  newtau identify excite robots/ur5.toml --floor 0 --box 0.7,0,0.3,0.4,0.8,0.6 --clearance 0.05 --seed 3
  newtau identify excite robots/ur5.toml --friction > slow.toml

A finite Fourier series per joint about the centre, inside shares of the position, speed, acceleration and torque limits of the robot
file: of the series tried, the one whose log tells most of the base parameters and of friction (largest log det of the information). The
same seed gives the same motion. The file's comments give the condition number, and the deviation to be expected of every base
parameter. With --friction: slow sweeps at two steady speeds, all joints at once. With --static: postures that gravity tells most in, with
rests.

The arm keeps --clearance from itself, from --floor and from every --box, at every time: between samples a bound on the motion of every
link is used. Shapes are the convex hulls of the collision shapes of a URDF robot (mesh files in STL or OBJ), or capsules from joint
over mass centre to joint with --radius. Links that share a joint, that overlap in every posture, or in the rest pose (`rest` of the robot
file; otherwise zero), are not judged against each other; the output lists them. The clearance holds for these shapes and for the
reference motion. It does not know cables, a gripper that the shapes do not contain, or how far the arm strays from its reference: watch it.";

/// Options of `excite`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct ExciteArgs {
    /// A robot file (TOML or URDF) or a scene.
    pub file: PathBuf,
    /// Motion to design.
    #[command(flatten)]
    pub request: ExciteRequest,
    /// Write the motion to this file. Without it, to standard output.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Designs the motion and writes it.
///
/// # Errors
/// [`Failure::Input`] for a wrong file or option, or if no motion keeps the limits; [`Failure::Output`] for a file that cannot be written.
pub fn run(args: &ExciteArgs) -> Result<(), Failure> {
    args.request.check()?;
    let given = RobotOrScene::load(&args.file, args.chain.ends())?;
    // An error here is better before the search than after it.
    let mut output = args.force.output().reads(&args.file);
    args.out.as_deref().map_or(Ok(()), |path| output.file(path))?;
    let bar = progress_bar(Some(args.request.motions()), "motions");
    let designed = design(&given.file, &args.request, args.chain.ends(), &|| bar.inc(1))?;
    bar.finish_and_clear();
    if let Some(path) = &args.out {
        std::fs::write(path, &designed.toml).map_err(|error| in_file(path, &error))?;
        output.written(std::slice::from_ref(path))?;
    }
    match (args.json, &args.out) {
        (true, _) => print(&(json(&designed.json)? + "\n")),
        (false, None) => print(&designed.toml),
        (false, Some(path)) => print(&format!("{}\nwritten to {}\n", designed.line, path.display())),
    }
}
