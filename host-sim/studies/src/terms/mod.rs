//! The matrices of the equations of motion at one posture.

mod report;

use super::numbers::{finite_entries, numbers};
use clap::ValueEnum;
use dynamics_core::chapter::posture::Chain;
use dynamics_core::chapter::trace_form::Transforms;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Inertia, InverseDynamics, Live, Model, Scene, Term, Trig, chapter::lagrange};
use nalgebra::{SMatrix, SVector, Vector3};
pub use report::describe;
use robot_compiler::{Robot, SceneFile, with_dof};
use serde::Serialize;
use sim::failure::Failure;
use sim::run::joint_label::JointLabel;

/// Method for the terms of the equations of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Lagrange's equations from the links' Jacobians.
    Lagrange,
    /// Lagrange's equations from derivatives of 4x4 transforms.
    Trace,
    /// Composite rigid bodies and Newton-Euler.
    Recursive,
}

/// Input of a computation of the terms.
#[derive(Clone, Debug, PartialEq)]
pub struct TermsRequest {
    /// Joint position, rad or m.
    pub q: Vec<f64>,
    /// Joint velocity, rad/s or m/s; zero if not given.
    pub qd: Option<Vec<f64>>,
    /// Gravitational acceleration in the base frame, m/s^2; by default the scene's.
    pub gravity: Option<Vec<f64>>,
    /// Method of computation.
    pub method: Method,
    /// True to include the rotors; by default as in the scene.
    pub rotor: Option<bool>,
}

/// The terms of `D(q) qdd + C(q, qd) qd + G(q) = tau + J^T w` (eq. 12.217).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Terms {
    /// Name of the robot.
    pub robot: String,
    /// Method of computation: `lagrange`, `trace` or `recursive`.
    pub method: &'static str,
    /// Joint position, rad or m.
    pub q: Vec<f64>,
    /// Joint velocity, rad/s or m/s.
    pub qd: Vec<f64>,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub g: [f64; 3],
    /// Rows of `D(q)`, including the rotors; kg m^2, kg m, kg.
    pub mass_matrix: Vec<Vec<f64>>,
    /// Rows of `C(q, qd)`: `C_ij = sum_k Gamma^i_jk qd_k`.
    pub coriolis_matrix: Vec<Vec<f64>>,
    /// `H = C qd`, N m or N.
    pub velocity_coupling: Vec<f64>,
    /// `G(q)`, N m or N.
    pub gravity: Vec<f64>,
    /// Christoffel symbols: `[i][j][k]` is `Gamma^i_jk` (eq. 12.281).
    pub christoffel: Vec<Vec<Vec<f64>>>,
}

/// Computes the terms at a posture.
///
/// # Errors
/// A list has the wrong length, or the posture is outside the limits.
pub fn terms(asked: &TermsRequest, file: &SceneFile) -> Result<Terms, Failure> {
    with_dof!(file.robot.dof(), N => {
        let model = file.robot.model::<N>().map_err(Failure::input)?;
        terms_for(asked, file, &model).map_err(Failure::Input)
    })
}

fn terms_for<const N: usize>(asked: &TermsRequest, file: &SceneFile, model: &Model<f64, N>) -> miette::Result<Terms> {
    let (scene, live) = (file.scene(model), file.live(model));
    let q: [f64; N] = list("q", &asked.q, "one for each joint")?;
    let qd = asked.qd.as_ref().map_or(Ok([0.0; N]), |qd| list("qd", qd, "one for each joint"))?;
    let g = match &asked.gravity {
        Some(gravity) => Vector3::from(list::<3>("gravity", gravity, "gx, gy, gz")?),
        None => scene.gravity.value(&live.gravity).copied().unwrap_or_else(Vector3::zeros),
    };
    within_limits(&file.robot, &q)?;

    let held = file.plant.payload.map(|body| Inertia::from_mass_centre(body.mass, &body.com, &body.inertia));
    let payload = scene.payload.value(&held.unwrap_or_else(Inertia::zero)).copied().unwrap_or_else(Inertia::zero);
    let mut found = match asked.method {
        Method::Lagrange => by_jacobians(&Chain::new(model, &payload), &q, &qd, &g),
        Method::Trace => by_traces(&Chain::new(model, &payload), &q, &qd, &g),
        Method::Recursive => by_recursion(model, payload, &q, &qd, &g),
    };
    if asked.rotor.unwrap_or(!matches!(scene.rotor, Term::Absent)) {
        for (i, link) in model.links().iter().enumerate() {
            found.d[(i, i)] += link.rotor;
        }
    }
    found.named(asked.method, &file.robot.name, &q, &qd, &g)
}

/// Result of a method, without rotors.
struct MethodResult<const N: usize> {
    d: SMatrix<f64, N, N>,
    c: SMatrix<f64, N, N>,
    h: [f64; N],
    weight: [f64; N],
    christoffel: [[[f64; N]; N]; N],
}

fn by_jacobians<const N: usize>(
    chain: &Chain<f64, N>,
    q: &[f64; N],
    qd: &[f64; N],
    g: &Vector3<f64>,
) -> MethodResult<N> {
    let posture = chain.posture(&Libm.sin_cos_all(q), q);
    MethodResult {
        d: lagrange::mass_matrix(&posture),
        c: lagrange::coriolis_matrix(&posture, qd),
        h: lagrange::velocity_coupling(&posture, qd),
        weight: lagrange::gravity(&posture, g),
        christoffel: lagrange::christoffel(&posture),
    }
}

fn by_traces<const N: usize>(chain: &Chain<f64, N>, q: &[f64; N], qd: &[f64; N], g: &Vector3<f64>) -> MethodResult<N> {
    let transforms = Transforms::new(chain, &Libm.sin_cos_all(q), q);
    let christoffel = transforms.coupling();
    let c = contracted(&christoffel, qd);
    MethodResult {
        d: transforms.mass_matrix(),
        c,
        h: (c * SVector::from(*qd)).into(),
        weight: transforms.gravity(g),
        christoffel,
    }
}

fn by_recursion<const N: usize>(
    model: &Model<f64, N>,
    payload: Inertia<f64>,
    q: &[f64; N],
    qd: &[f64; N],
    g: &Vector3<f64>,
) -> MethodResult<N> {
    let (turn, live, zero) = (Libm.sin_cos_all(q), Live::zero(), [0.0; N]);
    let afloat = Scene { payload: Term::Constant(payload), ..Scene::free_space() };
    let heavy = Dynamics::new(*model, Scene { gravity: Term::Constant(*g), ..afloat });
    let afloat = Dynamics::new(*model, afloat);
    let velocity_terms = |qd: &[f64; N]| afloat.inverse_dynamics(&turn, q, qd, &zero, &live);
    // The velocity terms are a quadratic form: their values at pairs of unit speeds give its coefficients, without truncation error.
    let unit = |j: usize| std::array::from_fn::<f64, N, _>(|i| if i == j { 1.0 } else { 0.0 });
    let own: [[f64; N]; N] = std::array::from_fn(|j| velocity_terms(&unit(j)));
    let mut christoffel = [[[0.0; N]; N]; N];
    for j in 0..N {
        for k in 0..N {
            let mut both = unit(j);
            both[k] = 1.0;
            let both = velocity_terms(&both);
            for i in 0..N {
                christoffel[i][j][k] = if j == k { own[j][i] } else { 0.5 * (both[i] - own[j][i] - own[k][i]) };
            }
        }
    }
    MethodResult {
        d: mass_matrix(&afloat, &turn, q, &live),
        c: contracted(&christoffel, qd),
        h: velocity_terms(qd),
        weight: heavy.inverse_dynamics(&turn, q, &zero, &zero, &live),
        christoffel,
    }
}

/// Computes `C_ij = sum_k Gamma^i_jk qd_k`.
fn contracted<const N: usize>(christoffel: &[[[f64; N]; N]; N], qd: &[f64; N]) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| christoffel[i][j].iter().zip(qd).map(|(symbol, speed)| symbol * speed).sum())
}

impl<const N: usize> MethodResult<N> {
    fn named(
        &self,
        method: Method,
        robot: &str,
        q: &[f64; N],
        qd: &[f64; N],
        g: &Vector3<f64>,
    ) -> miette::Result<Terms> {
        let symbols = self.christoffel.as_flattened().as_flattened();
        let mut all = self.d.iter().chain(&self.c).chain(&self.h).chain(&self.weight).chain(symbols);
        if !all.all(|x| x.is_finite()) {
            return Err(miette::miette!("the numbers are too large: a term overflows"));
        }
        let rows = |m: &SMatrix<f64, N, N>| m.row_iter().map(|row| row.iter().copied().collect()).collect();
        Ok(Terms {
            robot: robot.to_owned(),
            method: match method {
                Method::Lagrange => "lagrange",
                Method::Trace => "trace",
                Method::Recursive => "recursive",
            },
            q: q.to_vec(),
            qd: qd.to_vec(),
            g: (*g).into(),
            mass_matrix: rows(&self.d),
            coriolis_matrix: rows(&self.c),
            velocity_coupling: self.h.to_vec(),
            gravity: self.weight.to_vec(),
            christoffel: self.christoffel.iter().map(|of_joint| of_joint.map(|row| row.to_vec()).to_vec()).collect(),
        })
    }
}

/// Checks a list of an option: finite numbers, of the required count.
fn list<const K: usize>(option: &str, values: &[f64], meaning: &str) -> miette::Result<[f64; K]> {
    finite_entries(option, values).map_err(|problem| miette::miette!("{problem}"))?;
    numbers(option, values, meaning)
        .map_err(|problem| miette::miette!(help = "the numbers are divided by commas: --q 0.1,-0.2", "{problem}"))
}

/// Checks that every joint is within its position limits.
fn within_limits<const N: usize>(robot: &Robot, q: &[f64; N]) -> miette::Result<()> {
    for (index, (joint, q)) in robot.joints.iter().zip(q).enumerate() {
        let (lo, hi) = joint.spec.limits.position;
        let (side, limit) = match q {
            q if *q < lo => ("below", lo),
            q if *q > hi => ("above", hi),
            _ => continue,
        };
        let unit = JointLabel::from(joint).position_unit();
        return Err(miette::miette!(
            help = format!("expected a position from {lo} to {hi} {unit}"),
            "joint {} ({}): a position of {q} {unit} is {side} its limit of {limit} {unit}",
            index + 1,
            joint.name
        ));
    }
    Ok(())
}
