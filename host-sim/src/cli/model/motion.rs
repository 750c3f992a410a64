//! `model motion`: a motion from the recorded path of a hand-guided arm.

use crate::force::ForceArgs;
use clap::Args;
use robot_compiler::SceneFile;
use sim::failure::{Failure, in_file};
use sim::terminal::print;
use std::path::PathBuf;
use studies::taught::taught_from;

const EXAMPLE: &str =
    "Example:\n  newtau model motion out/yam_teach/log.csv --scene scenes/yam_move.toml --out out/taught.toml";

const EXAMPLES: &str = "\
Examples:
  newtau run scenes/yam_teach.toml
  newtau model motion out/yam_teach/log.csv --scene scenes/yam_move.toml --out out/taught.toml
  newtau run scenes/yam_move.toml --motion out/taught.toml

A path is log.csv of `run` (columns t, q1, q2 ..), the table or the record of a session of `connect`. Rests at its ends are left
out. The motion is a quintic through as few of its samples as keep every joint within the tolerance, 16 at most, slowed down where
the arm was guided faster than its velocity limits.";

/// Options of `motion`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct MotionArgs {
    /// The path: log.csv of a run, the table or the record of a session.
    pub log: PathBuf,
    /// The scene whose arm was guided by hand.
    #[arg(long, value_name = "FILE")]
    pub scene: PathBuf,
    /// Largest distance of a joint from the path, rad or m.
    #[arg(long, value_name = "DISTANCE", default_value_t = 0.01, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// Write the motion to this file. Without it, to standard output.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
}

/// Writes the motion.
///
/// # Errors
/// [`Failure::Input`] for a wrong scene or path; [`Failure::Output`] for a file that cannot be written.
pub fn run(args: &MotionArgs) -> Result<(), Failure> {
    if !(args.tolerance > 0.0 && args.tolerance.is_finite()) {
        return Err(Failure::Input(miette::miette!(
            "--tolerance {}: expected a distance above zero, rad or m",
            args.tolerance
        )));
    }
    let scene = SceneFile::load(&args.scene).map_err(Failure::input)?;
    let mut output = args.force.output().reads(&args.log).reads(&args.scene);
    args.out.as_deref().map_or(Ok(()), |path| output.file(path))?;
    let motion = taught_from(&args.log, &scene, args.tolerance)?;
    let total: f64 = motion.durations.iter().sum();
    let text = format!(
        "# Guided by hand: {} points in {total:.2} s, every joint within {:.1e} of the path{}.\n{}",
        motion.points.len(),
        motion.error,
        if motion.slower > 1.0 { format!(", {:.2} times slower", motion.slower) } else { String::new() },
        motion.toml(),
    );
    match &args.out {
        None => print(&text),
        Some(path) => {
            std::fs::write(path, &text).map_err(|error| in_file(path, &error))?;
            output.finish()?;
            print(text.lines().next().map_or("", |line| line.trim_start_matches("# ")))?;
            print(&format!("\nwritten to {}\n", path.display()))
        }
    }
}
