//! The command line.

pub mod bound;
pub mod campaign;
pub mod connect;
pub mod doctor;
mod document;
pub mod dynamics;
pub mod energy;
pub mod explain;
pub mod extremes;
pub mod info;
pub mod kernel;
pub mod linkage;
mod progress;
pub mod replay;
pub mod run;
pub mod statics;
pub mod terms;
pub mod trade;

use crate::cli::connect::ConnectArgs;
use crate::cli::doctor::DoctorArgs;
use crate::cli::replay::ReplayArgs;
use crate::study::trade::choice::{Every, TermSet};
use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use dynamics_core::control::Law;
use dynamics_core::linkage::Branch;
use robot_compiler::kernel::functions::Springs;
use robot_compiler::kernel::{Function, Level, Precision};
use robot_compiler::scene::{ControlSpec, ScalarChoice};
use std::path::PathBuf;
use std::str::FromStr;

/// Simulate a robot arm under computed-torque control, on the desk or with the chip's own firmware in the loop.
#[derive(Clone, Debug, Parser)]
#[command(name = "host-sim", version, after_long_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "\
Exit codes:
  0    done
  1    something outside failed: a file could not be written, the target died; a replay that differs, or ends before its record
  2    bad input: a file, a line or an option; the message says where and what was expected
  3    the run ended in a fault, a command of a session was refused, the simulated arm ran away, the simulated linkage came to a dead
       point, or a campaign found an unsafe command; everything recorded was written
  4    chip and desk differed in some tick
  130  interrupted; everything recorded until then was written";

/// What to do.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// Close the loop of a scene: table, CSV log, plots.
    Run(RunArgs),
    /// Inverse and forward dynamics of states given as JSON lines.
    Dynamics(DynamicsArgs),
    /// Show the matrices of the equations of motion at one posture.
    Terms(TermsArgs),
    /// Torques that hold an arm at rest, what its joints carry, and the posture that takes least.
    Statics(StaticsArgs),
    /// Run a scene and account for the energy: work of every joint, friction, what is left over.
    Energy(EnergyArgs),
    /// Explain a scene's model: what each term costs, and what goes wrong without it.
    Explain(ExplainArgs),
    /// Show what a robot file holds.
    Info(InfoArgs),
    /// Print the arm's dynamics as straight-line Rust, or what that saves.
    Kernel(KernelArgs),
    /// Drive a four-bar linkage or a slider-crank round, or let it run.
    Linkage(LinkageArgs),
    /// How wrong the torques of single precision are: a proven bound, and the worst that was found.
    Bound(BoundArgs),
    /// What every choice of accuracy costs on the chip: the ones that nothing beats.
    Trade(TradeArgs),
    /// The cheapest choice that meets a request, as a scene.
    Choose(ChooseArgs),
    /// What happens at the edges: masses, numbers, integrators, time, gains; pass or fail, cell by cell.
    Extremes(ExtremesArgs),
    /// Inject every fault in every state of the safety state machine, and judge every tick.
    Campaign(CampaignArgs),
    /// Is everything there: tool chain, emulator, probe, serial port, the firmware on a board; and what to do.
    Doctor(DoctorArgs),
    /// Operate the arm at a board on a serial port, or in a drill: status, arm, jog, run the motion, record.
    Connect(ConnectArgs),
    /// Run a record of `connect` again on the desk, and demand the very same bits.
    Replay(ReplayArgs),
}

const RUN_EXAMPLES: &str = "\
Examples:
  host-sim run scenes/puma560_pick.toml
  host-sim run scenes/puma560_pick.toml --target qemu
  host-sim run scenes/puma560_pick.toml --law pd --scalar f64 --out out/pd
  host-sim run scenes/puma560_pick.toml --json | jq .tracking_max

Files, in the folder given by --out:
  log.csv       every tick: time, and per joint reference and actual position and velocity, torque, limits; the fault
  summary.json  what --json prints
  *.svg         position, velocity, error and torque of every joint over time

Terms that the scene's model calls live are fed from its [plant], to the desk's controller and to the chip's alike.

A fault brakes the arm (drives released, brakes engaged); the run goes on to its end and exits with 3.";

/// Options of `run`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = RUN_EXAMPLES)]
pub struct RunArgs {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// Who computes the torques: this program, or the firmware in an emulated STM32F405.
    #[arg(long, value_enum, default_value_t = Target::Desk)]
    pub target: Target,
    /// Floating-point type of the controller; the scene's otherwise. The chip has f32 only.
    #[arg(long, value_enum)]
    pub scalar: Option<RunScalar>,
    /// Sine and cosine of the controller; the scene's otherwise.
    #[arg(long, value_parser = PossibleValuesParser::new(ControlSpec::trig_names()))]
    pub trig: Option<String>,
    /// The control law; the scene's otherwise.
    #[arg(long, value_enum)]
    pub law: Option<LawName>,
    /// Simulated time, s; the scene's otherwise.
    #[arg(long, value_name = "SECONDS")]
    pub duration: Option<f64>,
    /// Folder for log and plots; the scene's name under out/ otherwise.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Print the summary as JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
    /// No progress bar and no table.
    #[arg(long)]
    pub quiet: bool,
}

const DYNAMICS_EXAMPLES: &str = r#"Each input line is an object; all keys but q may be left out (zero, and gravity [0, 0, -9.81]):
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
  echo '{"q":[0,0.5,0,0,0,0]}' | host-sim dynamics robots/puma560.toml --input -
  host-sim dynamics robots/puma560.toml --input states.jsonl --scalar f32 --rotor absent

Numbers have as many digits as they need to be read back exactly. The first bad line ends the work with exit code 2; the
lines before it have been answered. Empty lines are skipped. Friction is not part of these equations."#;

/// Options of `dynamics`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = DYNAMICS_EXAMPLES)]
pub struct DynamicsArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// File of JSON lines; - for standard input.
    #[arg(long, value_name = "FILE")]
    pub input: PathBuf,
    /// Floating-point type to compute in.
    #[arg(long, value_enum, default_value_t = Scalar::F64)]
    pub scalar: Scalar,
    /// Whether the rotors of the robot file count.
    #[arg(long, value_enum, default_value_t = Presence::Present)]
    pub rotor: Presence,
}

const TERMS_EXAMPLES: &str = "\
Printed, for  D(q) qdd + C(q, qd) qd + G(q) = tau + J^T w  (eq. 12.217):
  D   inertia matrix, with the rotors on its diagonal           12.229 (lagrange), 12.393 (trace)
  C   C_ij = sum_k Gamma^i_jk qd_k: dD/dt - 2 C is skew         12.217
  H   velocity coupling, C qd                                   12.238 (lagrange), 12.394 (trace)
  G   torques that hold the weight                              12.239 (lagrange), 12.395 (trace)
  Gamma^i_jk   Christoffel symbols of the first kind            12.281
12.229 is taken without its factor 1/2 and 12.239 with the other sign: docs/dynamics.md says why.

Methods, which agree to rounding:
  lagrange   Jacobians of the links and their derivatives       12.223-12.241, 12.281
  trace      derivatives of the 4x4 transforms                  12.393-12.419
  recursive  composite bodies and Newton-Euler; Gamma from the
             velocity terms at pairs of unit speeds             12.157-12.162

Examples:
  host-sim terms robots/puma560.toml --q 0,0.5,-0.5,0,0.3,0
  host-sim terms robots/planar2r.toml --q 0.3,0.7 --qd 1,-2 --gravity 0,-9.81,0 --method trace
  host-sim terms robots/scara.toml --q 0,0.2,0.1,0 --scene scenes/scara_pick.toml --json | jq .christoffel

SI units, radians. A posture outside the joint limits is refused. Of a scene, gravity, payload and rotors count, a live
payload or gravity as its [plant] has it; its contact does not. Without --scene: gravity on a floor, nothing held, rotors of the
robot file. Tables show six decimals.

--json is an object {robot, method, q, qd, g, mass_matrix, coriolis_matrix, velocity_coupling, gravity, christoffel}, with
as many digits as are needed to read the numbers back exactly; christoffel[i][j][k] is Gamma^i_jk, counted from 0.";

/// Options of `terms`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = TERMS_EXAMPLES)]
pub struct TermsArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// Joint positions, rad or m, one for each joint.
    #[arg(long, value_name = "Q1,Q2,..", value_delimiter = ',', allow_hyphen_values = true, required = true)]
    pub q: Vec<f64>,
    /// Joint velocities, rad/s or m/s; zero if not given.
    #[arg(long, value_name = "QD1,QD2,..", value_delimiter = ',', allow_hyphen_values = true)]
    pub qd: Option<Vec<f64>>,
    /// Gravitational acceleration in the base frame, m/s^2; the scene's otherwise.
    #[arg(long, value_name = "GX,GY,GZ", value_delimiter = ',', allow_hyphen_values = true)]
    pub gravity: Option<Vec<f64>>,
    /// The scene file, about this robot: gravity, payload, rotors.
    #[arg(long)]
    pub scene: Option<PathBuf>,
    /// How to compute them.
    #[arg(long, value_enum, default_value_t = TermsMethod::Lagrange)]
    pub method: TermsMethod,
    /// Whether the rotors count; the scene's otherwise.
    #[arg(long, value_enum)]
    pub rotor: Option<Presence>,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

const STATICS_EXAMPLES: &str = "\
What is computed, with the equations of the chapter in docs/dynamics.md:
  wrench    F_{i-1} = F_i - sum F_e,  M_{i-1} = M_i - sum M_e + d x F_i, from the tip inward       12.455-12.456
            with every moment of a load moved to the joint it is felt at; 12.465 gives weight another
  torque    the component along the joint's axis, which its actuator carries: G(q) - J^T w         12.503-12.504, index i-1
  bearing   everything else: force across and along the axis, moment across and along it
  V         -sum m g . r, of the arm and its load; zero for masses at the base's origin            12.230

Examples:
  host-sim statics robots/puma560.toml --q 0,0.9,-1.6,0,0.5,0
  host-sim statics robots/puma560.toml --q 0,0.9,-1.6,0,0.5,0 --load 2,0,0,0.1 --json | jq .tau
  host-sim statics robots/planar2r.toml --gravity 0,-9.81,0 --q 0.5,0.785 --hold elbow --minimise shoulder
  host-sim statics robots/ur5.toml --minimise total --tip-wrench 0,0,-20,0,0,0

The wrench is that of the environment on the robot at the tip's origin, in tip axes. Rotors and friction do not act at rest.

--minimise looks inside the joint limits (one turn where a revolute joint has none). From 64 starts, the given posture, the middle
of the limits and 62 points spread evenly by a fixed sequence, it goes along one joint after another by steps that halve when
none helps, to a ten-thousandth of each joint's range; the best goes on to a billionth. The same input gives the same answer.
It is the least that was found: no proof that nothing less exists.";

/// Options of `statics`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = STATICS_EXAMPLES)]
pub struct StaticsArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// Joint positions, rad or m; where the search begins with --minimise, which needs none.
    #[arg(
        long,
        value_name = "Q1,Q2,..",
        value_delimiter = ',',
        allow_hyphen_values = true,
        required_unless_present = "minimise"
    )]
    pub q: Option<Vec<f64>>,
    /// Gravitational acceleration in the base frame, m/s^2.
    #[arg(
        long,
        value_name = "GX,GY,GZ",
        value_delimiter = ',',
        allow_hyphen_values = true,
        default_value = "0,0,-9.81"
    )]
    pub gravity: Vec<f64>,
    /// A point mass held by the tip: kg, and where in the tip frame, m (its origin if left out).
    #[arg(long, value_name = "MASS[,X,Y,Z]", value_delimiter = ',', allow_hyphen_values = true)]
    pub load: Option<Vec<f64>>,
    /// What the environment does to the arm at the tip, in tip axes, N and N m.
    #[arg(long, value_name = "FX,FY,FZ,MX,MY,MZ", value_delimiter = ',', allow_hyphen_values = true)]
    pub tip_wrench: Option<Vec<f64>>,
    /// Find the posture of the least: torque of a joint (its name or number), total (sum of squares of all), potential (V).
    #[arg(long, value_name = "JOINT|total|potential")]
    pub minimise: Option<String>,
    /// Joints (names or numbers) that stay at their --q in the search.
    #[arg(long, value_name = "JOINT,..", value_delimiter = ',', requires_all = ["q", "minimise"])]
    pub hold: Vec<String>,
    /// Axes of the joints' wrenches.
    #[arg(long, value_enum, default_value_t = AxesName::Link)]
    pub axes: AxesName,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// How the terms of the equations of motion are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TermsMethod {
    /// Lagrange's equations from the links' Jacobians.
    Lagrange,
    /// Lagrange's equations from derivatives of 4x4 transforms.
    Trace,
    /// Composite rigid bodies and Newton-Euler.
    Recursive,
}

/// Which axes a wrench is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AxesName {
    /// Each link's own, z along its joint.
    Link,
    /// The base frame's.
    Base,
}

const ENERGY_EXAMPLES: &str = "\
What is computed:
  work      int tau qd dt of every joint, positive and negative apart; tau as it acts, after delay, saturation and lag
  friction  int -tau_f qd dt of every joint
  contact   work of what pushes at the tip
  T         1/2 qd^T D qd, with rotors                                                             12.228
  V         -sum m g . r                                                                           12.230
  residual  work + friction + contact - (gain of T + V): what the quadrature misses
The trapezoid rule over the simulation's own steps: the residual falls with the square of `step` in the scene's [plant].

Examples:
  host-sim energy scenes/puma560_pick.toml
  host-sim energy scenes/planar2r_swing.toml --duration 1.8 --json | jq '.joints[0].positive'

Files, in the folder given by --out:
  energy.json  what --json prints
  power.svg    power of every joint over time: commanded torque times velocity

A fault ends the account: what the brakes take is not in it. Exit codes as those of `run`.";

/// Options of `energy`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = ENERGY_EXAMPLES)]
pub struct EnergyArgs {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// Simulated time, s; the scene's otherwise.
    #[arg(long, value_name = "SECONDS")]
    pub duration: Option<f64>,
    /// Folder for the files; the scene's name under out/ otherwise.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

const EXPLAIN_EXAMPLES: &str = "\
For every term of the model (gravity, payload, tip wrench, rotors, velocity terms, friction feedforward):
  is            absent, constant, live, or given up by `terms = \"auto\"`; and the line that says so
  mul add sub   operations of a tick's inverse dynamics and friction that go with it: the kernel compiled with and without, at the
                scene's level (exact where the scene runs the recursion); friction as its formula has it
  torque error  what the model leaves out without the term, on the scene's own reference motion
  tracking      greatest error of the closed loop without the term, in the scene's world, which keeps it
A term may go if its torque error stays within the tolerance on every joint that has a torque limit. Which may go together is
searched over all sets, as `terms = \"auto\"` in a scene's [model] does it.

--chip builds the controller's tick with every term and without each, runs it on the emulated chip, and shows what goes with the term:
  instructions  of a tick, mean over consecutive ticks of the scene's motion
  cycles        an estimate
  flash         bytes of the tick and all that it reaches

Examples:
  host-sim explain scenes/puma560_pick.toml
  host-sim explain scenes/puma560_pick.toml --tolerance 0.05
  host-sim explain scenes/puma560_pick.toml --chip
  host-sim explain scenes/puma560_auto.toml --json | jq .fewest.given_up";

/// Options of `explain`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = EXPLAIN_EXAMPLES)]
pub struct ExplainArgs {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// Torque error that is allowed, as a share of each joint's torque limit; the scene's otherwise, or 0.002.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Measure what each term takes on the emulated chip; installs what that needs.
    #[arg(long)]
    pub chip: bool,
    /// Print JSON instead of tables.
    #[arg(long)]
    pub json: bool,
}

/// Options of `info`.
#[derive(Clone, Debug, Args)]
pub struct InfoArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
}

const KERNEL_EXAMPLES: &str = "\
Examples:
  host-sim kernel robots/puma560.toml > kernel.rs
  host-sim kernel robots/puma560.toml --scene scenes/puma560_pick.toml --level regrouped --scalar f32
  host-sim kernel robots/ur5.toml --function mass-matrix
  host-sim kernel robots/ur5.toml --table
  host-sim kernel robots/ur5.toml --json | jq '.[] | select(.level == \"regrouped\")'

Without --scene: gravity on a floor, velocity terms, and the rotors of the robot file.
Levels: exact gives the very results of the recursion; regrouped needs fewer operations and rounds otherwise.

--table shows operations and values alive, then what each rewrite saves and what each term of the scene costs.
--json is an array of {function, level, mul, add, sub, neg, live_inputs, max_live}.
Both show every function and level, or those that are asked for.";

/// Options of `kernel`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = KERNEL_EXAMPLES)]
pub struct KernelArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// The scene file, about this robot: which terms act on it.
    #[arg(long)]
    pub scene: Option<PathBuf>,
    /// How far the operations may leave those of the recursion; exact if nothing is said.
    #[arg(long, value_enum)]
    pub level: Option<LevelName>,
    /// What it computes; inverse-dynamics if nothing is said.
    #[arg(long, value_enum)]
    pub function: Option<FunctionName>,
    /// Floating-point type; the scene's otherwise.
    #[arg(long, value_enum)]
    pub scalar: Option<Scalar>,
    /// Print operation counts as JSON instead of the source.
    #[arg(long, conflicts_with = "table")]
    pub json: bool,
    /// Print tables of what is saved, by what, instead of the source.
    #[arg(long)]
    pub table: bool,
}

const LINKAGE_EXAMPLES: &str = "\
Examples:
  host-sim linkage robots/chapter12/four_bar.toml
  host-sim linkage robots/chapter12/slider_crank.toml --speed 300 --steps 720 --json | jq .shaking_force
  host-sim linkage robots/chapter12/four_bar.toml --simulate 0.5 --duration 3

Driven: the crank turns at a constant speed, and at every step of a turn the nine equations of the three links, [A] x = b (12.44-12.46;
12.41 with m3 a3), give the driving moment M_0 and the joint forces F_0 to F_3. F_i acts through joint i on what comes after it.
The shaking force on the ground is F_3 - F_0 (12.47), weight included; its moment is about the crank's ground pivot, the motor's
reaction included. A crank that cannot turn fully is driven through all steps at which the loop closes.

Simulated: M = I(theta) thetadd + 1/2 I'(theta) thetad^2 + dV/dtheta (12.216 with one coordinate) under a constant moment on the crank, by
a Runge-Kutta method of fourth order. The balance is that of energy and work, E - E_0 = M (theta - theta_0).

Files, in the folder given by --out:
  driven.csv, driving_moment.svg, shaking_force.svg, shaking_moment.svg   over the crank's angle
  free.csv, motion.svg, energy.svg                                        over time, with --simulate
  summary.json                                                            what --json prints

Units: SI, radians. Angles count from the ground or the guide; see docs/linkages.md.";

/// Options of `linkage`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = LINKAGE_EXAMPLES)]
pub struct LinkageArgs {
    /// The linkage file (TOML).
    pub linkage: PathBuf,
    /// Speed of the crank, rad/s: constant and 10 if nothing is said; with --simulate that of the start, else 0.
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true)]
    pub speed: Option<f64>,
    /// Steps in a turn.
    #[arg(long, default_value_t = 360, value_parser = clap::value_parser!(u32).range(8..=100_000), conflicts_with = "simulate")]
    pub steps: u32,
    /// Which way the loop is assembled.
    #[arg(long, value_enum, default_value_t = BranchName::Open)]
    pub branch: BranchName,
    /// Let it run under this moment on the crank, N m, instead of driving it.
    #[arg(long, value_name = "MOMENT", allow_negative_numbers = true)]
    pub simulate: Option<f64>,
    /// Simulated time, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, requires = "simulate")]
    pub duration: f64,
    /// Time step of the simulation, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 1e-4, requires = "simulate")]
    pub time_step: f64,
    /// Crank angle at which the simulation starts, rad; the middle of its range if nothing is said, 0 if that is a whole turn.
    #[arg(long, value_name = "RAD", allow_negative_numbers = true, requires = "simulate")]
    pub angle: Option<f64>,
    /// Folder for table and plots; the linkage's name under out/ otherwise.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Print the summary as JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Which of two ways a loop is assembled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BranchName {
    /// Joint 2 to the left of the line from the crank pin to the follower's pivot; the slider ahead of the crank pin.
    Open,
    /// The mirror image about that line; the slider behind the crank pin.
    Crossed,
}

const TRADE_EXAMPLES: &str = "\
Every combination of the choices below is a scene file of its own; so is the scene's own choice, and each that differs from it in one
thing (not with --alone). Measured of each:
  instructions   of the controller's tick on the emulated chip, every one counted: mean and most, over consecutive ticks of the scene's motion
  cycles         an estimate for the chip's core and flash, from the instructions that were executed
  flash, RAM     the tick with all that it reaches, and what it remembers from tick to tick
  torque error   with the arm exactly on its reference: against the full model in 31 digits, greatest and root mean square
  tracking       of the closed loop in the scene's world
on three motions: slow (a tenth of the speed limits), fast (as velocity and torque limits allow), singular (fast through the posture in
which the scaled mass matrix is nearest to singular). Every torque of the chip must have the desk's very bits.

Choices, each a key of the scene file:
  --scalar   f32, mixed (all but the recursion in f64), f64                                [control] scalar
  --trig     polynomial, polynomial-5, polynomial-3, table, rotation, libm                 [control] trig
  --terms    full; no-coriolis; diagonal: gravity and a constant diagonal inertia;
             gravity; none                                                                 [control] law, [model] coriolis
  --friction, --rotors   on, off                                                           [model] friction, rotor
  --every    the model every so many ticks: 1, 4:hold, 4:extrapolate                       [control] model_every, model_between
  --kernel   exact, regrouped                                                              [control] kernel
  --rate     Hz; the scene's otherwise                                                     [control] rate

Examples:
  host-sim trade scenes/puma560_pick.toml
  host-sim trade scenes/puma560_pick.toml --scalar f32 --trig polynomial,table --terms full,diagonal --every 1,2:hold
  host-sim trade robots/ur5.toml --json | jq '.points[] | select(.on_torque_front) | .command'

Files, in the folder given by --out (out/trade/NAME otherwise):
  trade.csv, trade.svg   every choice with every number; all of them in one picture
  points/                the scene of every choice
  measured.jsonl         what has been measured: after an interruption the work goes on from there";

/// What is combined.
#[derive(Clone, Debug, Args)]
pub struct AxisArgs {
    /// Floating-point types.
    #[arg(long, value_enum, value_delimiter = ',', default_values = ["f32"])]
    pub scalar: Vec<RunScalar>,
    /// Sines and cosines.
    #[arg(
        long,
        value_parser = PossibleValuesParser::new(ControlSpec::trig_names()),
        value_delimiter = ',',
        default_values = ["polynomial", "polynomial-3", "table"]
    )]
    pub trig: Vec<String>,
    /// Sets of terms.
    #[arg(long, value_enum, value_delimiter = ',', default_values = ["full", "no-coriolis", "diagonal", "gravity", "none"])]
    pub terms: Vec<TermSet>,
    /// Friction fed forward, where the scene does it.
    #[arg(long, value_enum, value_delimiter = ',', default_values = ["on"])]
    pub friction: Vec<Switch>,
    /// Rotors in the model, where the scene has them.
    #[arg(long, value_enum, value_delimiter = ',', default_values = ["on"])]
    pub rotors: Vec<Switch>,
    /// When the model is evaluated.
    #[arg(long, value_delimiter = ',', default_values = ["1", "4:extrapolate"], value_name = "TICKS[:BETWEEN]")]
    pub every: Vec<Every>,
    /// Levels of the arm's kernel.
    #[arg(long, value_enum, value_delimiter = ',', default_values = ["regrouped"])]
    pub kernel: Vec<LevelName>,
    /// Control rates, Hz; the scene's otherwise.
    #[arg(long, value_delimiter = ',', value_name = "HZ")]
    pub rate: Vec<f64>,
    /// The product alone: without the scene's own choice and those that differ from it in one thing.
    #[arg(long)]
    pub alone: bool,
}

/// Options of `trade`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = TRADE_EXAMPLES)]
pub struct TradeArgs {
    /// The scene file, or a robot file for a scene made up for it.
    pub scene: PathBuf,
    /// What is combined.
    #[command(flatten)]
    pub axes: AxisArgs,
    /// Folder for the files.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Measure again what is known.
    #[arg(long)]
    pub fresh: bool,
    /// Put the tables between `<!-- measured: trade, NAME -->` and `<!-- end measured: trade, NAME -->` of this file, and the picture beside it.
    #[arg(long, value_name = "FILE")]
    pub write: Option<PathBuf>,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

const CHOOSE_EXAMPLES: &str = "\
The choices, and what is measured of them, are those of `trade`, whose measurements are used where they are known. The cheapest is the one
with the fewest cycles. Share of the processor: mean cycles (an estimate) times the rate over the clock; the longest tick must also
end before the next is due. If no choice does, the message says what the nearest would cost, and the exit code is 2.

Examples:
  host-sim choose scenes/puma560_pick.toml --max-torque-error 0.2% --budget 20%@4kHz
  host-sim choose scenes/puma560_pick.toml --max-tracking-error 2e-3 --trig polynomial --out scenes/mine.toml";

/// Options of `choose`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = CHOOSE_EXAMPLES)]
pub struct ChooseArgs {
    /// The scene file, or a robot file for a scene made up for it.
    pub scene: PathBuf,
    /// Greatest torque error of any joint on any course, as a share of its limit: 0.2% or 0.002.
    #[arg(long, value_name = "SHARE")]
    pub max_torque_error: Option<Share>,
    /// Greatest tracking error of any joint on any course, rad or m.
    #[arg(long, value_name = "RAD")]
    pub max_tracking_error: Option<f64>,
    /// Share of the processor at a control rate: 20%@4kHz.
    #[arg(long, value_name = "SHARE@RATE")]
    pub budget: Option<Budget>,
    /// Clock of the processor, MHz.
    #[arg(long, value_name = "MHZ", default_value_t = 168.0)]
    pub clock: f64,
    /// What is combined.
    #[command(flatten)]
    pub axes: AxisArgs,
    /// Where the scene goes; out/trade/NAME/chosen.toml otherwise.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Measure again what is known.
    #[arg(long)]
    pub fresh: bool,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// A share: `20%` or `0.2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share(pub f64);

impl FromStr for Share {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
        let share = number.trim().parse::<f64>().ok().map(|number| number * unit);
        let share = share.filter(|share| *share > 0.0 && *share <= 1.0);
        share.map(Self).ok_or_else(|| format!("{text}: expected a share above 0 and at most 1, such as 20% or 0.2"))
    }
}

/// A share of the processor at a control rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Of the processor.
    pub share: f64,
    /// Hz.
    pub rate: f64,
}

impl FromStr for Budget {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("{text}: expected a share and a rate, such as 20%@4kHz or 0.2@1000Hz");
        let (share, rate) = text.split_once('@').ok_or_else(expected)?;
        let share: Share = share.parse().map_err(|_| expected())?;
        let (number, unit) = match (rate.strip_suffix("kHz"), rate.strip_suffix("Hz")) {
            (Some(number), _) => (number, 1e3),
            (None, Some(number)) => (number, 1.0),
            (None, None) => return Err(expected()),
        };
        let rate = number.trim().parse::<f64>().map_err(|_| expected())? * unit;
        if rate > 0.0 && rate.is_finite() { Ok(Self { share: share.0, rate }) } else { Err(expected()) }
    }
}

/// Whether something counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// It counts.
    On,
    /// It is left out.
    Off,
}

const BOUND_EXAMPLES: &str = "\
Examples:
  host-sim bound robots/puma560.toml
  host-sim bound scenes/puma560_pick.toml --level regrouped
  host-sim bound robots/ur5.toml --samples 1000000 --boxes 1000000 --json | jq .joints[0].proven
  host-sim bound robots/planar2r.toml robots/ur5.toml --write docs/measured/bound.md

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
#[command(after_long_help = BOUND_EXAMPLES)]
pub struct BoundArgs {
    /// Robot files (TOML or URDF) or scene files (TOML); of a scene, what its model counts.
    #[arg(required = true, value_name = "ROBOT|SCENE")]
    pub files: Vec<PathBuf>,
    /// How far the operations leave those of the recursion.
    #[arg(long, value_enum, default_value_t = LevelName::Exact)]
    pub level: LevelName,
    /// Random states; a tenth of them again for the bound of one state.
    #[arg(long, value_name = "COUNT", default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub samples: u32,
    /// Boxes that are looked at for each joint.
    #[arg(long, value_name = "COUNT", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub boxes: u32,
    /// Seed of the random states and climbs.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Greatest joint speeds, rad/s or m/s, one for each joint; the robot file's otherwise.
    #[arg(long, value_name = "QD1,QD2,..", value_delimiter = ',')]
    pub velocity: Option<Vec<f64>>,
    /// Greatest joint accelerations, rad/s^2 or m/s^2, one for each joint; five times the speed a second otherwise.
    #[arg(long, value_name = "QDD1,QDD2,..", value_delimiter = ',')]
    pub acceleration: Option<Vec<f64>>,
    /// Print JSON, and nothing else: an object for each file, a line each.
    #[arg(long)]
    pub json: bool,
    /// Put the table between `<!-- measured: bound -->` and `<!-- end measured: bound -->` of this file.
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    pub write: Option<PathBuf>,
}

const EXTREMES_EXAMPLES: &str = "\
Groups:
  masses       masses and inertias from 1e-6 to 1e6, massless links, nearly singular inertia matrices
  inputs       angles to 1e6 turns, rates to 1e4 rad/s, NaN and infinity: a right torque or the documented fault
  integrators  order and energy of the plant's integrators, over a second and over a hundred; a chaotic arm
  time         periods from 1 us to 50 ms, a million ticks, an encoder that hardly moves; with --long, a day
  control      saturation, wrong models, joints that stick
  stability    the longest stable period, predicted and simulated: a planar arm, the Puma, wrong models

A cell passes when what it requires holds and its number is the one measured before, to 2 %; long cells have requirements only. A cell that fails says why; the suite of
tests fails when a cell's outcome changes in either direction.

Examples:
  host-sim extremes
  host-sim extremes --json | jq '.cells[] | select(.passed | not)'
  host-sim extremes --long
  host-sim extremes --long 1 --write
  host-sim extremes --write

--json is an object {count, passed, failed, cells: [{group, name, done, expected, found, value, pinned, moved, passed, reason}]}.
--write puts the tables between the lines `<!-- measured: extremes -->` and `<!-- end measured: extremes -->` of the file, and
extremes_region.svg, extremes_stability.svg and extremes_stability_puma.svg beside it. Long cells have a table of their own, between the lines
`<!-- measured: extremes, long -->` and `<!-- end measured: extremes, long -->`, which only --long --write changes.";

/// Options of `extremes`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = EXTREMES_EXAMPLES)]
pub struct ExtremesArgs {
    /// Also run what takes minutes: a million ticks of a microsecond, and so many simulated hours at 1 kHz.
    #[arg(long, value_name = "HOURS", num_args = 0..=1, default_missing_value = "24")]
    pub long: Option<f64>,
    /// Put the tables into this file.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "docs/measured/extremes.md")]
    pub write: Option<PathBuf>,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

const CAMPAIGN_EXAMPLES: &str = "\
Each run takes the machine to one of its states (idle, homing, idle and homed, armed, running, holding, fault), waits a random number of
ticks, and lets one fault last for a random number of ticks, with the scene's own simulated arm in the loop. After every tick a judge,
written from docs/safety.md, looks whether the command was safe. Faults and states take turns: all of them come equally often.

Run K depends on the seed, K and the scenes alone. An unsafe command is printed with all that the machine was told and with what repeats
it: --seed S --run K and the same scenes and target.

Examples:
  host-sim campaign
  host-sim campaign --runs 10000 --write
  host-sim campaign --target qemu --runs 400 --write
  host-sim campaign scenes/puma560_pick.toml --seed 7 --run 4711
  host-sim campaign --json | jq '.rows[] | select(.unsafe_commands > 0)'

--json is an object {scenes, target, seed, runs, ticks, seconds, rows: [{fault, cells, runs, ticks, unsafe_commands}], counterexamples}.
--write puts the table between the lines `<!-- measured: campaign, desk -->` and `<!-- end measured: campaign, desk -->` of the file,
with --target qemu between those of `campaign, qemu`.";

/// Options of `campaign`.
#[derive(Clone, Debug, Args)]
#[command(after_long_help = CAMPAIGN_EXAMPLES)]
pub struct CampaignArgs {
    /// The scene files (TOML), which take turns.
    #[arg(
        value_name = "SCENE",
        default_values = ["scenes/campaign/encoders.toml", "scenes/campaign/states.toml"]
    )]
    pub scenes: Vec<PathBuf>,
    /// How many runs.
    #[arg(long, default_value_t = 10_000)]
    pub runs: u64,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Only the run with this number.
    #[arg(long, value_name = "K", conflicts_with = "runs")]
    pub run: Option<u64>,
    /// Who is put to the test: the firmware's session on the desk, or the firmware in an emulated STM32F405 with the desk beside it.
    #[arg(long, value_enum, default_value_t = Target::Desk)]
    pub target: Target,
    /// Put the table into this file.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "docs/measured/campaign.md")]
    pub write: Option<PathBuf>,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// How far a kernel's operations may leave those of the recursion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LevelName {
    /// Every result equal.
    Exact,
    /// Fewer operations, other rounding.
    Regrouped,
}

/// What a kernel computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FunctionName {
    /// D qdd + C qd + G - J^T w
    InverseDynamics,
    /// G(q)
    Gravity,
    /// C(q, qd) qd
    Coriolis,
    /// D(q), the upper triangle row by row.
    MassMatrix,
    /// Force and moment at every joint, base first.
    JointWrenches,
    /// Generalised momentum, then what changes it beside the actuators.
    Momentum,
    /// Accelerations from torques, then the pivots.
    ForwardDynamics,
    /// The law, ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q)), with the scene's gains folded in.
    ComputedTorque,
}

impl FunctionName {
    /// The function of this name, with the gains that the law takes.
    #[must_use]
    pub const fn function(self, springs: Springs) -> Function {
        match self {
            Self::InverseDynamics => Function::InverseDynamics,
            Self::Gravity => Function::Gravity,
            Self::Coriolis => Function::Coriolis,
            Self::MassMatrix => Function::MassMatrix,
            Self::JointWrenches => Function::JointWrenches,
            Self::Momentum => Function::Momentum,
            Self::ForwardDynamics => Function::ForwardDynamics,
            Self::ComputedTorque => Function::ComputedTorque(springs),
        }
    }
}

/// Who computes the torques.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// This program.
    Desk,
    /// The firmware, in an emulated STM32F405.
    Qemu,
}

/// Floating-point type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scalar {
    /// Single precision, as on the chip.
    F32,
    /// Double precision.
    F64,
}

/// Floating-point type of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RunScalar {
    /// Single precision, as on the chip.
    F32,
    /// Double precision.
    F64,
    /// Inverse dynamics, sine and cosine in single precision, all else in double.
    Mixed,
}

/// Control law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LawName {
    /// Inverse dynamics of the measured state and a corrected acceleration.
    ComputedTorque,
    /// Spring and damper per joint.
    Pd,
    /// Spring and damper, and the torque that holds the arm.
    PdGravity,
    /// A fixed inertia per joint for what is asked for, and the torque that holds the arm.
    DiagonalInertia,
    /// Spring and damper, and the torque of the reference motion.
    Feedforward,
}

/// Whether an effect counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Presence {
    /// It counts.
    Present,
    /// It is left out.
    Absent,
}

impl From<BranchName> for Branch {
    fn from(branch: BranchName) -> Self {
        match branch {
            BranchName::Open => Self::Open,
            BranchName::Crossed => Self::Crossed,
        }
    }
}

impl From<RunScalar> for ScalarChoice {
    fn from(scalar: RunScalar) -> Self {
        match scalar {
            RunScalar::F32 => Self::F32,
            RunScalar::F64 => Self::F64,
            RunScalar::Mixed => Self::Mixed,
        }
    }
}

impl From<ScalarChoice> for RunScalar {
    fn from(scalar: ScalarChoice) -> Self {
        match scalar {
            ScalarChoice::F32 => Self::F32,
            ScalarChoice::F64 => Self::F64,
            ScalarChoice::Mixed => Self::Mixed,
        }
    }
}

impl From<Scalar> for Precision {
    fn from(scalar: Scalar) -> Self {
        match scalar {
            Scalar::F32 => Self::Single,
            Scalar::F64 => Self::Double,
        }
    }
}

impl From<LevelName> for Level {
    fn from(level: LevelName) -> Self {
        match level {
            LevelName::Exact => Self::Exact,
            LevelName::Regrouped => Self::Regrouped,
        }
    }
}

impl From<LawName> for Law {
    fn from(law: LawName) -> Self {
        match law {
            LawName::ComputedTorque => Self::ComputedTorque,
            LawName::Pd => Self::Pd,
            LawName::PdGravity => Self::PdGravity,
            LawName::DiagonalInertia => Self::DiagonalInertia,
            LawName::Feedforward => Self::Feedforward,
        }
    }
}
