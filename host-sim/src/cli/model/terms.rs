//! `model terms`: the matrices of the equations of motion at one posture.

use crate::cli::chain::ChainArgs;
use crate::cli::names::Presence;
use clap::Args;
use sim::failure::Failure;
use sim::terminal::{json, print};
use std::path::PathBuf;
use studies::robot_or_scene::scene_about;
use studies::terms::{Method, TermsRequest, describe, terms};

const EXAMPLE: &str = "Example:\n  newtau model terms robots/puma560.toml --q 0,0.5,-0.5,0,0.3,0";

const EXAMPLES: &str = "\
Printed, for  D(q) qdd + C(q, qd) qd + G(q) = tau + J^T w  (eq. 12.217):
  D   inertia matrix, with the rotors on its diagonal           12.229 (lagrange), 12.393 (trace)
  C   C_ij = sum_k Gamma^i_jk qd_k: dD/dt - 2 C is skew         12.217
  H   velocity coupling, C qd                                   12.238 (lagrange), 12.394 (trace)
  G   torques that hold the weight                              12.239 (lagrange), 12.395 (trace)
  Gamma^i_jk   Christoffel symbols of the first kind            12.281
12.229 is taken without its factor 1/2 and 12.239 with the other sign: docs/theory/dynamics.md says why.

Methods, which agree to rounding:
  lagrange   Jacobians of the links and their derivatives       12.223-12.241, 12.281
  trace      derivatives of the 4x4 transforms                  12.393-12.419
  recursive  composite bodies and Newton-Euler; Gamma from the
             velocity terms at pairs of unit speeds             12.157-12.162

Examples:
  newtau model terms robots/puma560.toml --q 0,0.5,-0.5,0,0.3,0
  newtau model terms robots/planar2r.toml --q 0.3,0.7 --qd 1,-2 --gravity 0,-9.81,0 --method trace
  newtau model terms robots/scara.toml --q 0,0.2,0.1,0 --scene scenes/scara_pick.toml --json | jq .christoffel

SI units, radians. A posture outside the joint limits is refused. Of a scene, gravity, payload and rotors count, a live
payload or gravity as its [plant] has it; its contact does not. Without --scene: gravity on a floor, nothing held, rotors of the
robot file. Tables show six decimals.

--json is an object {robot, method, q, qd, g, mass_matrix, coriolis_matrix, velocity_coupling, gravity, christoffel}, with
as many digits as are needed to read the numbers back exactly; christoffel[i][j][k] is Gamma^i_jk, counted from 0.";

/// Options of `terms`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLE, after_long_help = EXAMPLES)]
pub struct TermsArgs {
    /// The robot file (TOML or URDF).
    pub robot: PathBuf,
    /// The chain of a URDF robot.
    #[command(flatten)]
    pub chain: ChainArgs,
    /// Joint positions, rad or m, one for each joint.
    #[arg(long, value_name = "Q1,Q2,..", value_delimiter = ',', allow_hyphen_values = true, required = true)]
    pub q: Vec<f64>,
    /// Joint velocities, rad/s or m/s; zero if not given.
    #[arg(long, value_name = "QD1,QD2,..", value_delimiter = ',', allow_hyphen_values = true)]
    pub qd: Option<Vec<f64>>,
    /// Gravitational acceleration in the base frame, m/s^2. Without it, the scene's.
    #[arg(long, value_name = "GX,GY,GZ", value_delimiter = ',', allow_hyphen_values = true)]
    pub gravity: Option<Vec<f64>>,
    /// A scene of this robot: gravity, payload, rotors.
    #[arg(long)]
    pub scene: Option<PathBuf>,
    /// Method of computation.
    #[arg(long, value_enum, default_value_t = Method::Lagrange)]
    pub method: Method,
    /// Include or omit the rotors. Without it, as in the scene.
    #[arg(long, value_enum)]
    pub rotor: Option<Presence>,
    /// Print JSON, and nothing else.
    #[arg(long)]
    pub json: bool,
}

/// Prints the terms.
///
/// # Errors
/// A wrong robot or scene file, a list of the wrong length, or a posture outside the limits.
pub fn run(args: &TermsArgs) -> Result<(), Failure> {
    let file = scene_about(&args.robot, args.chain.ends(), args.scene.as_deref())?;
    let question = TermsRequest {
        q: args.q.clone(),
        qd: args.qd.clone(),
        gravity: args.gravity.clone(),
        method: args.method,
        rotor: args.rotor.map(|asked| asked == Presence::Present),
    };
    let terms = terms(&question, &file)?;
    let text = if args.json { json(&terms)? + "\n" } else { describe(&terms, &file.robot) };
    print(&text)
}
