//! The wrench at the tip from the reading of a sensor in the base; or that reading from a known wrench at the tip.

use super::numbers::{finite, wrench};
use super::options::GravityArgs;
use clap::{ArgGroup, Args};
use dynamics_core::chapter::contact::{base_wrench, contact_wrench};
use dynamics_core::chapter::global::{Assembled, residuals, weights};
use dynamics_core::chapter::posture::Chain;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Inertia, Live, Scene, Term, Trig, Wrench};
use nalgebra::Vector3;
use robot_compiler::{Robot, with_dof};
use serde::Serialize;
use sim::run::joint_label::JointLabel;
use sim::run::numbers::engineering;
use sim::table::table;

/// A state of an arm, and the known wrench at one of its ends.
#[derive(Clone, Debug, PartialEq, Args)]
#[command(group = ArgGroup::new("known").required(true).args(["base_wrench", "tip_wrench"]))]
pub struct ContactRequest {
    /// Joint positions, rad or m.
    #[arg(long, value_name = "Q1,Q2,..", value_delimiter = ',', allow_hyphen_values = true, required = true)]
    pub q: Vec<f64>,
    /// Joint velocities, rad/s or m/s; zero if not given.
    #[arg(long, value_name = "QD1,QD2,..", value_delimiter = ',', allow_hyphen_values = true)]
    pub qd: Option<Vec<f64>>,
    /// Joint accelerations, rad/s^2 or m/s^2; zero if not given.
    #[arg(long, value_name = "QDD1,QDD2,..", value_delimiter = ',', allow_hyphen_values = true)]
    pub qdd: Option<Vec<f64>>,
    /// Gravity.
    #[command(flatten)]
    pub gravity: GravityArgs,
    /// Reading of a sensor in the base, N and N m.
    #[arg(long, value_name = "FX,FY,FZ,MX,MY,MZ", value_delimiter = ',', allow_hyphen_values = true)]
    pub base_wrench: Option<Vec<f64>>,
    /// Wrench of the environment on the arm at the tip, N and N m.
    #[arg(long, value_name = "FX,FY,FZ,MX,MY,MZ", value_delimiter = ',', allow_hyphen_values = true)]
    pub tip_wrench: Option<Vec<f64>>,
}

/// The wrenches at both ends and at every joint; force (N), then moment (N m).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactWrenches {
    /// Name of the robot.
    pub robot: String,
    /// The base's wrench on the arm, about the base's origin, base axes.
    pub base_wrench: [f64; 6],
    /// The environment's wrench on the arm, about the tip's origin, tip axes.
    pub tip_wrench: [f64; 6],
    /// Wrench on each link from the previous one, about the joint's origin, in base axes; solved from one linear system of all equations.
    pub joints: Vec<[f64; 6]>,
    /// Greatest residual of any link's Newton-Euler equations with these wrenches, divided by the greatest wrench.
    pub residual: f64,
    #[serde(skip)]
    labels: Vec<JointLabel>,
}

/// Computes the wrench at the other end of the arm.
///
/// # Errors
/// A description of: a list of the wrong length, a number that is not finite, or a result that overflows.
pub fn answer(robot: &Robot, question: &ContactRequest) -> Result<ContactWrenches, String> {
    with_dof!(robot.dof(), N => answer_for::<N>(robot, question))
}

fn answer_for<const N: usize>(robot: &Robot, question: &ContactRequest) -> Result<ContactWrenches, String> {
    let model = robot.model::<N>().map_err(|error| error.to_string())?;
    let list = |name: &str, values: &Option<Vec<f64>>| {
        values.as_ref().map_or(Ok([0.0; N]), |values| finite::<N>(name, values, "one for each joint"))
    };
    let q = finite::<N>("--q", &question.q, "one for each joint")?;
    let (qd, qdd) = (list("--qd", &question.qd)?, list("--qdd", &question.qdd)?);
    let gravity = Vector3::from(finite::<3>("--gravity", &question.gravity.of(robot), "x, y, z")?);
    let (turn, live) = (Libm.sin_cos_all(&q), Live::zero());
    // A rotor spins between motor and link, so its torque is part of no joint wrench.
    let scene = Scene { rotor: Term::Absent, ..Scene::with_gravity(gravity, &model) };
    let (base, tip) = match (&question.base_wrench, &question.tip_wrench) {
        (Some(values), _) => {
            let base = wrench("--base-wrench", values)?;
            (base, contact_wrench(&Dynamics::new(model, scene), &turn, &q, &qd, &qdd, &base, &live))
        }
        (None, values) => {
            let tip = wrench("--tip-wrench", values.as_deref().unwrap_or_default())?;
            let touched = Dynamics::new(model, Scene { tip_wrench: Term::Constant(tip), ..scene });
            (base_wrench(&touched, &turn, &q, &qd, &qdd, &live), tip)
        }
    };
    let posture = Chain::new(&model, &Inertia::zero()).posture(&turn, &q);
    let motion = posture.motion(&qd, &qdd);
    let push = tip.in_parent(&posture.tip.rotation, &Vector3::zeros());
    let external = weights(&posture, &gravity);
    let joints = Assembled::new(&posture, &motion, &external, &push).solve();
    let joints = joints.ok_or("a wrench of a joint is beyond the numbers; expected smaller inputs")?;
    let most = |wrenches: &[Wrench<f64>]| wrenches.iter().flat_map(six).fold(0.0, |most, x| f64::max(most, x.abs()));
    let missed = most(&residuals(&posture, &motion, &joints, &external, &push));
    let size = most(&joints);
    Ok(ContactWrenches {
        robot: robot.name.clone(),
        base_wrench: six(&base),
        tip_wrench: six(&tip),
        joints: joints.iter().map(six).collect(),
        residual: if size > 0.0 { missed / size } else { missed },
        labels: robot.joints.iter().map(JointLabel::from).collect(),
    })
}

fn six(wrench: &Wrench<f64>) -> [f64; 6] {
    let (f, m) = (wrench.force, wrench.moment);
    [f.x, f.y, f.z, m.x, m.y, m.z]
}

impl ContactWrenches {
    /// The table and the line below it for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = table(["at", "axes", "force / N", "moment / N m"], 2);
        let three = |v: &[f64]| v.iter().map(|x| format!("{:.3}", x + 0.0)).collect::<Vec<_>>().join(" ");
        let row = |at: &str, axes: &str, w: &[f64; 6]| [at.to_owned(), axes.to_owned(), three(&w[..3]), three(&w[3..])];
        table.add_row(row("base, on the arm", "base", &self.base_wrench));
        for (label, wrench) in self.labels.iter().zip(&self.joints) {
            table.add_row(row(&label.name, "base", wrench));
        }
        table.add_row(row("tip, by the environment", "tip", &self.tip_wrench));
        let residual = engineering(self.residual, "of the greatest wrench");
        format!("{}: contact at the tip\n{table}\n{:<20}{residual}\n", self.robot, "residual")
    }
}
