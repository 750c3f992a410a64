//! `model dynamics`: inverse and forward dynamics of states given as JSON lines.

use crate::cli::chain::ChainArgs;
use crate::cli::names::Presence;
use clap::Args;
use robot_compiler::Robot;
use robot_compiler::names::name;
use robot_compiler::scene::ScalarChoice;
use sim::failure::Failure;
use sim::terminal::{named, say_mounting};
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write, stdin, stdout};
use std::path::{Path, PathBuf};
use studies::dynamics::{Computation, answer_lines};

const EXAMPLE: &str = "Example:\n  newtau model dynamics robots/ur5.toml --input scenes/example_states.jsonl";

const EXAMPLES: &str = r#"Each input line is an object; all keys but q may be left out (zero, and gravity [0, 0, -9.81]):
  {"q":[..], "qd":[..], "qdd":[..], "tau":[..], "wrench_tip":[fx,fy,fz,mx,my,mz], "gravity":[gx,gy,gz]}
The wrench is that of the environment on the robot at the tip's origin, in tip axes. SI units, radians.

Each output line is an object, in the order of the input:
  tau          torques for q, qd, qdd under gravity and wrench:  D qdd + C qd + G - J^T w
  gravity      G(q)
  coriolis_qd  C(q, qd) qd
  mass_matrix  D(q), rows
  qdd          accelerations under the given tau (only if it was given):  D qdd = tau - C qd - G + J^T w
  tip          pose of the tip in the base: rotation (rows), position

Examples:
  echo '{"q":[0,0.5,0,0,0,0]}' | newtau model dynamics robots/puma560.toml --input -
  newtau model dynamics robots/puma560.toml --input states.jsonl --scalar f32 --rotor absent

Numbers have as many digits as they need to be read back exactly. The first bad line ends the work with exit code 2; the
lines before it have been answered. Empty lines are skipped; a line has up to 64 KiB. Friction is not part of these equations."#;

/// Options of `dynamics`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct DynamicsArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// File of JSON lines; - for standard input.
    #[arg(long, value_name = "FILE")]
    pub input: PathBuf,
    /// Floating-point type to compute in.
    #[arg(long, value_parser = named::<ScalarChoice>(), default_value = name(ScalarChoice::F64))]
    pub scalar: ScalarChoice,
    /// Include or omit the rotors of the robot file.
    #[arg(long, value_enum, default_value_t = Presence::Present)]
    pub rotor: Presence,
}

/// Prints the answer to every line of the input.
///
/// # Errors
/// [`Failure::Input`] for a wrong robot or line; the lines before it have been answered.
pub fn run(args: &DynamicsArgs) -> Result<(), Failure> {
    let robot = Robot::load_between(&args.robot, args.chain.ends()).map_err(Failure::input)?;
    say_mounting(&robot);
    let source = name_of(&args.input);
    let mut input: Box<dyn BufRead> = if args.input == Path::new("-") {
        Box::new(stdin().lock())
    } else {
        let opened = File::open(&args.input);
        let file = opened.map_err(|error| Failure::Input(miette::miette!("{source} cannot be read: {error}")))?;
        Box::new(BufReader::new(file))
    };
    let mut output = BufWriter::new(stdout().lock());
    let how = Computation { rotors: args.rotor == Presence::Present, scalar: args.scalar };
    let done = answer_lines(&robot, how, &source, &mut *input, &mut output);
    match (done, output.flush()) {
        // The reader has closed the pipe because it needs no more, as `head` does.
        (Err(Failure::Output(error)), _) | (_, Err(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        (Err(failure), _) => Err(failure),
        (Ok(()), flushed) => flushed.map_err(Failure::Output),
    }
}

fn name_of(input: &Path) -> String {
    if input == Path::new("-") { "standard input".to_owned() } else { input.display().to_string() }
}
