//! `import`: converts an arm of a URDF file to a TOML robot file.

use crate::cli::chain::ChainArgs;
use crate::force::ForceArgs;
use clap::Args;
use robot_compiler::UrdfArm;
use robot_compiler::check::Draft;
use robot_compiler::emit::{first_scene, robot_file};
use sim::failure::{Failure, in_file};
use sim::terminal::print;
use std::path::{Path, PathBuf};

const EXAMPLE: &str = "Example:\n  newtau import arm.urdf --out arm.toml --scene move.toml";

const EXAMPLES: &str = "\
Examples:
  newtau import arm.urdf > robots/arm.toml
  newtau import arm.urdf --out arm.toml --scene move.toml && newtau run move.toml
  newtau import arm.urdf --tip gripper_base --out robots/arm.toml
  newtau import two_arms.urdf --base left_base --tip left_flange > robots/left.toml

The first gap does not stop it: all that the URDF says is written, and each gap is marked `# ?` with its reason. `newtau check`
reports a gap until it is filled, or declared ideal (rotor = { inertia = 0, gear = 1 }, friction = {}, a limit of inf). With --base, the
turn of the base against the root is written as `mounting`, and gravity turns with it.

Written are name, placement, axis, mass, inertia, limits, friction and Drake's rotor of every joint and its link, and the tip frame. Fixed links
are merged into the moving link that carries them; moving joints beside the chain are held at zero, or where they are when the joint that
they mimic is at zero. Numbers read back exactly;
rotations are roll, pitch and yaw, exact to rounding. A reduction of a <transmission> is
written into the `# ?` of the rotor.

--scene writes a first scene for `run`: every joint moves a little and comes back.

A file that exists is not overwritten by --out or --scene, unless --force is given: what was filled in by hand would be lost.";

/// Options of `import`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct ImportArgs {
    /// The URDF file.
    pub urdf: PathBuf,
    /// The chain.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// A file for the robot; standard output otherwise.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// A file for a first scene of the arm.
    #[arg(long, value_name = "FILE", requires = "out")]
    pub scene: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
}

/// Writes the robot file.
///
/// # Errors
/// [`Failure::Input`] for a wrong URDF file or link, or for an output file that exists; [`Failure::Output`] for a file that cannot be written.
pub fn run(args: &ImportArgs) -> Result<(), Failure> {
    let arm = UrdfArm::load(&args.urdf, args.chain.ends()).map_err(Failure::input)?;
    let text = robot_file(&arm);
    // XML allows names that a robot file does not. The error is better here than when the file is used.
    Draft::from_toml_str(&text, "the imported robot").map_err(Failure::input)?;
    let Some(out) = &args.out else { return print(&text) };
    let mut output = args.force.output().reads(&args.urdf);
    let scene = args.scene.as_ref().map(|scene| (scene, first_scene(&arm.robot, &seen_from(scene, out))));
    let files: Vec<_> = [(out, text)].into_iter().chain(scene).collect();
    // All files are claimed before the first one is written.
    files.iter().try_for_each(|(path, _)| output.file(path))?;
    files.iter().try_for_each(|(path, text)| std::fs::write(path, text).map_err(|error| in_file(path, &error)))?;
    output.finish()
}

/// The path with which a scene in this file refers to the robot file: without folders if both are in the same folder, otherwise absolute.
fn seen_from(scene: &Path, robot: &Path) -> String {
    let name = robot.file_name().map(Path::new).filter(|_| scene.parent() == robot.parent());
    let path = name.map_or_else(|| std::path::absolute(robot).unwrap_or_else(|_| robot.to_owned()), Path::to_owned);
    path.display().to_string()
}
