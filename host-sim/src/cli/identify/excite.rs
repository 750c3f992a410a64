//! `identify excite`: designs a motion for identification.

use crate::cli::chain::ChainArgs;
use crate::cli::force::ForceArgs;
use clap::Args;
use sim::failure::{Failure, in_file};
use sim::terminal::{json, print, progress_bar};
use std::path::PathBuf;
use studies::excite::{Kind, Surroundings, Wishes, design};
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
    /// Instead, slow sweeps at constant speeds, to identify friction.
    #[arg(long, conflicts_with = "static")]
    pub friction: bool,
    /// Instead, postures in which the arm rests, to identify gravity.
    #[arg(long = "static")]
    pub r#static: bool,
    /// Position about which each joint swings, rad or m. Without it, the middle of its range.
    #[arg(long, value_name = "Q1,Q2,..", value_delimiter = ',', allow_hyphen_values = true)]
    pub centre: Option<Vec<f64>>,
    /// Widest swing to either side of a joint, rad or m.
    #[arg(long, value_name = "SWING", default_value_t = 1.5, allow_negative_numbers = true)]
    pub swing: f64,
    /// Share of the speed limits.
    #[arg(long, value_name = "SHARE", default_value_t = 0.6, allow_negative_numbers = true)]
    pub speed: f64,
    /// Greatest acceleration of every joint, rad/s^2 or m/s^2. Without it, each joint reaches its speed limit in 0.4 s.
    #[arg(long, value_name = "ACCELERATION", allow_negative_numbers = true)]
    pub acceleration: Option<f64>,
    /// Share of the torque limits.
    #[arg(long, value_name = "SHARE", default_value_t = 0.7, allow_negative_numbers = true)]
    pub torque: f64,
    /// Height of a floor against gravity, in the base frame, m.
    #[arg(long, value_name = "HEIGHT", allow_hyphen_values = true)]
    pub floor: Option<f64>,
    /// A box along the axes of the base frame: its centre and its edges, m. May be given several times.
    #[arg(long = "box", value_name = "X,Y,Z,DX,DY,DZ", allow_hyphen_values = true)]
    pub boxes: Vec<String>,
    /// Smallest distance from the floor, from boxes, and between links, m.
    #[arg(long, value_name = "DISTANCE", default_value_t = 0.02, allow_hyphen_values = true)]
    pub clearance: f64,
    /// Radius of links without collision shapes, one for all or one for each, m. Without it, 6 % of the arm's length.
    #[arg(long, value_name = "R1,R2,..", value_delimiter = ',')]
    pub radius: Vec<f64>,
    /// Period of the first harmonic, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, allow_negative_numbers = true)]
    pub period: f64,
    /// Periods to record.
    #[arg(long, value_name = "NUMBER", default_value_t = 3)]
    pub periods: u32,
    /// Harmonics, 1 to 8.
    #[arg(long, value_name = "NUMBER", default_value_t = 5)]
    pub harmonics: usize,
    /// Expected standard deviation of the measured torque, as a share of each torque limit.
    #[arg(long, value_name = "SHARE", default_value_t = 0.005, allow_negative_numbers = true)]
    pub noise: f64,
    /// Motions to try.
    #[arg(long, value_name = "NUMBER", default_value_t = 1500)]
    pub tries: usize,
    /// Seed of the search.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
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
    let wrong = |expected: &str, found: String| {
        Err(Failure::Input(miette::miette!(help = format!("expected {expected}"), "{found}")))
    };
    let numbers = [
        ("--swing", Some(args.swing), 100.0),
        ("--speed", Some(args.speed), 1.0),
        ("--acceleration", args.acceleration, 1e6),
        ("--torque", Some(args.torque), 1.0),
        ("--period", Some(args.period), 1000.0),
        ("--noise", Some(args.noise), 1.0),
    ];
    for (name, value, most) in numbers {
        if let Some(value) = value.filter(|value| !(*value > 0.0 && *value <= most)) {
            return wrong(&format!("a number above zero, at most {most}"), format!("{name} {value}"));
        }
    }
    if !(1..=8).contains(&args.harmonics) || !(1..=100).contains(&args.periods) || args.tries == 0 {
        return wrong(
            "--harmonics 1 to 8, --periods 1 to 100, --tries above zero",
            "a number out of its range".to_owned(),
        );
    }
    let around = surroundings(args)?;
    let given = RobotOrScene::load(&args.file, args.chain.ends())?;
    // An error here is better before the search than after it.
    let mut output = args.force.output().reads(&args.file);
    args.out.as_deref().map_or(Ok(()), |path| output.file(path))?;
    let kind = match (args.friction, args.r#static) {
        (true, _) => Kind::Friction,
        (_, true) => Kind::Static,
        _ => Kind::Series,
    };
    let bar = progress_bar(Some(if kind == Kind::Static { 14 } else { args.tries as u64 }), "motions");
    let wishes = Wishes {
        kind,
        centre: args.centre.clone(),
        swing: args.swing,
        speed: args.speed,
        acceleration: args.acceleration,
        torque: args.torque,
        around,
        period: args.period,
        periods: args.periods,
        harmonics: args.harmonics,
        noise: args.noise,
        tries: args.tries,
        seed: args.seed,
    };
    let designed = design(&given.file, &wishes, &|| bar.inc(1))?;
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

/// Floor, boxes and radii from the options.
fn surroundings(args: &ExciteArgs) -> Result<Surroundings, Failure> {
    let wrong = |expected: &str, found: String| {
        Failure::Input(miette::miette!(help = format!("expected {expected}"), "{found}"))
    };
    if let Some(radius) = args.radius.iter().find(|radius| !(**radius > 0.0 && radius.is_finite())) {
        return Err(wrong("radii above zero, m", format!("--radius {radius}")));
    }
    if !(args.clearance >= 0.0 && args.clearance.is_finite()) {
        return Err(wrong("a distance of zero or more, m", format!("--clearance {}", args.clearance)));
    }
    if let Some(height) = args.floor.filter(|height| !height.is_finite()) {
        return Err(wrong("a finite height, m", format!("--floor {height}")));
    }
    let numbers = |text: &String| {
        let found: Option<Vec<f64>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
        let six = found.and_then(|found| <[f64; 6]>::try_from(found).ok());
        six.ok_or_else(|| wrong("six numbers X,Y,Z,DX,DY,DZ: centre and edges, m", format!("--box {text}")))
    };
    Ok(Surroundings {
        floor: args.floor,
        boxes: args.boxes.iter().map(numbers).collect::<Result<_, _>>()?,
        radius: args.radius.clone(),
        clearance: args.clearance,
        base: args.chain.base.clone(),
        tip: args.chain.tip.clone(),
    })
}
