//! `model statics`: torques that hold an arm at rest, and the posture that needs the least.

use crate::cli::chain::ChainArgs;
use crate::force::ForceArgs;
use crate::output::files;
use clap::Args;
use robot_compiler::Robot;
use sim::failure::Failure;
use sim::pages;
use sim::run::files::file_name;
use sim::terminal::{json, print, say_mounting};
use std::path::{Path, PathBuf};
use studies::statics::{StaticsRequest, WrenchFrame, answer, sweep};

const EXAMPLE: &str = "Example:\n  newtau model statics robots/ur5.toml --minimise total";

const EXAMPLES: &str = "\
What is computed, with the equations of the chapter in docs/theory/dynamics.md:
  wrench    F_{i-1} = F_i - sum F_e,  M_{i-1} = M_i - sum M_e + d x F_i, from the tip inward       12.455-12.456
            with every moment of a load moved to the joint it is felt at; 12.465 gives weight another
  torque    the component along the joint's axis, which its actuator carries: G(q) - J^T w         12.503-12.504, index i-1
  bearing   everything else: force across and along the axis, moment across and along it
  V         -sum m g . r, of the arm and its load; zero for masses at the base's origin            12.230

Examples:
  newtau model statics robots/puma560.toml --q 0,0.9,-1.6,0,0.5,0
  newtau model statics robots/puma560.toml --q 0,0.9,-1.6,0,0.5,0 --load 2,0,0,0.1 --json | jq .tau
  newtau model statics robots/planar2r.toml --gravity 0,-9.81,0 --q 0.5,0.785 --hold elbow --minimise shoulder
  newtau model statics robots/ur5.toml --minimise total --tip-wrench 0,0,-20,0,0,0
  newtau model statics robots/planar2r.toml --gravity 0,-9.81,0 --q 0,0.785 --load 2 --sweep shoulder

--sweep moves one joint from limit to limit (one turn at most), prints the least of every torque, of their sum and of V, and draws
all of them into report.html in the folder of --out.

The wrench is that of the environment on the robot at the tip's origin, in tip axes. Rotors and friction do not act at rest.

--minimise looks inside the joint limits (one turn where a revolute joint has none). From 64 starts, the given posture, the middle
of the limits and 62 points spread evenly by a fixed sequence, it goes along one joint after another by steps that halve when
none helps, to a ten-thousandth of each joint's range; the best goes on to a billionth. The same input gives the same answer.
It is the least that was found: no proof that nothing less exists.";

/// Options of `statics`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct StaticsArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// Posture and loads.
    #[command(flatten)]
    pub request: StaticsRequest,
    /// Torques and potential energy over the range of a joint (its name or number), with the others at their --q; drawn in report.html.
    #[arg(long, value_name = "JOINT", requires = "q", conflicts_with = "minimise")]
    pub sweep: Option<String>,
    /// Folder for the picture of --sweep. Without it, out/NAME with the robot's name.
    #[arg(long, value_name = "FOLDER", requires = "sweep")]
    pub out: Option<PathBuf>,
    /// Overwriting.
    #[command(flatten)]
    pub force: ForceArgs,
    /// Axes of the joints' wrenches.
    #[arg(long, value_enum, default_value_t = WrenchFrame::Link)]
    pub axes: WrenchFrame,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Prints the answer.
///
/// # Errors
/// [`Failure::Input`] for a wrong robot or option.
pub fn run(args: &StaticsArgs) -> Result<(), Failure> {
    let robot = Robot::load_between(&args.robot, args.chain.ends()).map_err(Failure::input)?;
    say_mounting(&robot);
    if let Some(joint) = &args.sweep {
        return swept(args, &robot, joint);
    }
    let answer = answer(&robot, &args.request, args.axes)?;
    let text = if args.json { json(&answer)? } else { answer.table() };
    print(&format!("{text}\n"))
}

/// Prints a sweep, and draws it into a report.
fn swept(args: &StaticsArgs, robot: &Robot, joint: &str) -> Result<(), Failure> {
    let found = sweep(robot, &args.request, joint)?;
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(file_name(&robot.name)));
    let mut output = args.force.output().reads(&args.robot);
    output.folder(&folder, &["report.html"])?;
    let report = folder.join("report.html");
    pages::write(&report, &found.page())?;
    output.written(std::slice::from_ref(&report))?;
    print(&if args.json { json(&found)? + "\n" } else { format!("{}{}", found.table(), files(&[report])) })
}
