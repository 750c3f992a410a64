//! `model contact`: the wrench at the tip from a wrench measured in the base, or the reverse.

use crate::cli::chain::ChainArgs;
use clap::Args;
use robot_compiler::Robot;
use sim::failure::Failure;
use sim::terminal::{json, print, say_mounting};
use std::path::PathBuf;
use studies::contact::{ContactRequest, answer};

const EXAMPLE: &str =
    "Example:\n  newtau model contact robots/puma560.toml --q 0,0.9,-1.6,0,0.5,0 --base-wrench 0,0,250,10,-40,0";

const EXAMPLES: &str = "\
What is computed:
  tip wrench  from the base outward, each link's own need taken off: F_i = F_{i-1} + m_i (g - a_i)   12.163-12.168, corrected
  joints      Newton's and Euler's equations of all links as one linear system                       12.1-12.6, 12.74-12.76
  residual    those equations, left side less right side

Examples:
  newtau model contact robots/planar2r.toml --q 0.4,0.9 --gravity 0,-9.81,0 --tip-wrench 5,0,0,0,0,0
  newtau model contact robots/puma560.toml --q 0,0.9,-1.6,0,0.5,0 --base-wrench 0,0,250,10,-40,0 --json | jq .tip_wrench

The base wrench is that of the base on the arm, about the base's origin and in its axes, as a sensor there reads it; the tip
wrench that of the environment on the arm, about the tip's origin and in tip axes. Rotors are in no joint's wrench.";

/// Options of `contact`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct ContactArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// State and known wrench.
    #[command(flatten)]
    pub request: ContactRequest,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Prints the answer.
///
/// # Errors
/// [`Failure::Input`] for a wrong robot or option.
pub fn run(args: &ContactArgs) -> Result<(), Failure> {
    let robot = Robot::load_between(&args.robot, args.chain.ends()).map_err(Failure::input)?;
    say_mounting(&robot);
    let wrong = |problem| Failure::Input(miette::miette!(help = "see `newtau help model contact`", "{problem}"));
    let answer = answer(&robot, &args.request).map_err(wrong)?;
    print(&if args.json { json(&answer)? + "\n" } else { answer.table() })
}
