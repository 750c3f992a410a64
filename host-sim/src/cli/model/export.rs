//! `model export`: writes an arm in a format of other programs.

use crate::cli::chain::ChainArgs;
use crate::force::ForceArgs;
use clap::Args;
use robot_compiler::Robot;
use robot_compiler::emit::urdf;
use sim::failure::Failure;
use sim::terminal::print;
use std::path::PathBuf;

const EXAMPLE: &str = "Example:\n  newtau model export robots/puma560.toml --urdf --out out/puma560.urdf";

const EXAMPLES: &str = "\
Examples:
  newtau model export robots/puma560.toml --urdf --out out/puma560.urdf
  newtau model export two_arms.urdf --base left_base --tip left_flange --urdf > left.urdf

Written are origins, axes, masses, inertias, limits and friction; rotors and gears as Drake reads them, in a <transmission>. Links are
named base, JOINT_link and tip; run --mcap names its frames so too. The shapes are drawn from the geometry alone. A URDF has no
word for torque rates, encoders and drives. `newtau import` of the file gives an arm with the same torques.";

/// Options of `export`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct ExportArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// Write a URDF.
    #[arg(long, required = true)]
    pub urdf: bool,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// File for the result. Without it, standard output.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
}

/// Writes the arm.
///
/// # Errors
/// [`Failure::Input`] for a wrong robot file; [`Failure::Output`] for a file that cannot be written.
pub fn run(args: &ExportArgs) -> Result<(), Failure> {
    let robot = Robot::load_between(&args.robot, args.chain.ends()).map_err(Failure::input)?;
    let text = urdf(&robot);
    let write = |path: &PathBuf| args.force.output().reads(&args.robot).write(path, &text);
    args.out.as_ref().map_or_else(|| print(&text), write)
}
