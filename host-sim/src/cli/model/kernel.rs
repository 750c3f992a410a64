//! `model kernel`: the arm's dynamics as straight-line Rust or C, and the savings by each rewrite and each term of the scene.

use crate::cli::chain::ChainArgs;
use clap::Args;
use robot_compiler::emit::kernel_file::Language;
use robot_compiler::names::name;
use sim::failure::Failure;
use sim::terminal::{named, print};
use std::path::PathBuf;
use studies::kernel::{Form, KernelRequest, text};
use studies::robot_or_scene::scene_about;

const EXAMPLE: &str = "Example:\n  newtau model kernel robots/ur5.toml --table";

const EXAMPLES: &str = "\
Examples:
  newtau model kernel robots/puma560.toml > kernel.rs
  newtau model kernel robots/puma560.toml --scene scenes/puma560_pick.toml --level regrouped --scalar f32
  newtau model kernel robots/ur5.toml --function mass-matrix
  newtau model kernel robots/ur5.toml --language c > kernel.c
  newtau model kernel robots/ur5.toml --table
  newtau model kernel robots/ur5.toml --json | jq '.[] | select(.level == \"regrouped\")'

Without --scene: gravity on a floor, velocity terms, and the rotors of the robot file.
Levels: exact gives the very results of the recursion; regrouped needs fewer operations and rounds otherwise.

--table shows operations and values alive, then what each rewrite saves and what each term of the scene costs.
--json is an array of {function, level, mul, add, sub, neg, live_inputs, max_live}.
Both show every function and level, or those that are asked for.";

/// Options of `kernel`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct KernelArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// A scene of this robot, for the terms of its model.
    #[arg(long)]
    pub scene: Option<PathBuf>,
    /// Kernels to compile.
    #[command(flatten)]
    pub request: KernelRequest,
    /// Programming language of the source.
    #[arg(long, value_parser = named::<Language>(), default_value = name(Language::Rust), conflicts_with_all = ["json", "table"])]
    pub language: Language,
    /// Print operation counts as JSON instead of the source.
    #[arg(long, conflicts_with = "table")]
    pub json: bool,
    /// Print tables of the operations that each rule saves, instead of the source.
    #[arg(long)]
    pub table: bool,
}

/// Prints the source, the counts or the tables.
///
/// # Errors
/// A wrong robot or scene file, or a scene with another robot.
pub fn run(args: &KernelArgs) -> Result<(), Failure> {
    let file = scene_about(&args.robot, args.chain.ends(), args.scene.as_deref())?;
    let form = match (args.json, args.table) {
        (true, _) => Form::Counts,
        (false, true) => Form::Tables,
        (false, false) => Form::Source(args.language),
    };
    print(&text(&args.request, &file, form)?)
}
