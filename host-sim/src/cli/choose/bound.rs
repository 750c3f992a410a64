//! `choose bound`: error of the torques in single precision, as the largest error found and a proven upper bound.

use crate::cli::chain::ChainArgs;
use clap::Args;
use sim::failure::Failure;
use sim::pages;
use sim::terminal::{print, progress_bar};
use std::path::PathBuf;
use studies::bound::{BoundRequest, answer, load, markdown, work};
use studies::robot_or_scene::RobotOrScene;

const EXAMPLE: &str = "Example:\n  newtau choose bound robots/planar2r.toml";

const EXAMPLES: &str = "\
Examples:
  newtau choose bound robots/puma560.toml
  newtau choose bound scenes/puma560_pick.toml --level regrouped
  newtau choose bound robots/ur5.toml --samples 1000000 --boxes 1000000 --json | jq .joints[0].proven
  newtau choose bound robots/planar2r.toml robots/ur5.toml --write docs/measured/bound.md

What is bounded: |tau_f32 - tau| of every joint, tau = D qdd + C qd + G - J^T w in exact arithmetic with the numbers of the robot
file, tau_f32 as the chip computes it: constants rounded, polynomial sine and cosine (their error is measured over every
float up to 8192 rad), every operation rounded. Inputs q, qd, qdd are numbers that f32 holds, everywhere in the joint
limits. Friction and the law's own arithmetic are not part of it.

With --level regrouped, constants are those that the kernel holds, and the bound is of sine, cosine and arithmetic.

Limits: position and velocity of the robot file; one turn where a revolute joint has no limits. Robot files have no limit of
acceleration: five times the speed limit a second (from rest to full speed in 0.2 s) unless --acceleration says otherwise.

found      the largest error of random states and of climbs from the worst of them, against double-double arithmetic
one state  the largest bound of a single state that was found in the same way: all roundings at their worst, in one direction
proven     no state exceeds it: the bound over boxes that together are all states
proven / one state is what boxes lose, which forget that the numbers in them depend on each other; one state / found is what
a bound loses that takes every rounding at its worst.";

/// Options of `bound`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct BoundArgs {
    /// Robot files (TOML or URDF) or scene files (TOML). For a scene, the terms of its model.
    #[arg(required = true, value_name = "ROBOT|SCENE")]
    pub files: Vec<PathBuf>,
    /// The chain of every URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// Bound to compute.
    #[command(flatten)]
    pub request: BoundRequest,
    /// Print JSON, and nothing else: an object for each file, one per line.
    #[arg(long)]
    pub json: bool,
    /// Write the table between `<!-- measured: bound -->` and `<!-- end measured: bound -->` of this file.
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    pub write: Option<PathBuf>,
}

/// Prints the errors, or writes them into a document.
///
/// # Errors
/// [`Failure::Input`] for a wrong file or option; [`Failure::Output`] if a document cannot be written.
pub fn run(args: &BoundArgs) -> Result<(), Failure> {
    let files: Vec<RobotOrScene> =
        args.files.iter().map(|path| load(path, args.chain.ends())).collect::<Result<_, _>>()?;
    let steps: u64 = files.iter().map(|file| work(file.file.robot.dof(), &args.request)).sum();
    let page = pages::document(args.write.as_deref(), &["bound"])?;
    let progress = progress_bar(Some(steps), "");
    let mut answers = Vec::new();
    for subject in &files {
        answers.push(answer(&args.request, subject, &progress)?);
    }
    progress.finish_and_clear();
    if let Some(page) = page {
        return pages::fill(page, &[("bound", markdown(&answers))]);
    }
    let mut text = String::new();
    for answer in &answers {
        if args.json {
            text += &serde_json::to_string(answer).map_err(|error| Failure::Output(error.into()))?;
            text += "\n";
        } else {
            text += &answer.table();
        }
    }
    print(&text)
}
