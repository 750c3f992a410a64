//! `terms`: the matrices of the equations of motion at one posture.

use crate::cli::dynamics::numbers;
use crate::cli::kernel::scene_about;
use crate::cli::{Presence, TermsArgs, TermsMethod};
use crate::failure::{self, Failure};
use crate::run::record::JointLabel;
use comfy_table::{CellAlignment, Table, presets};
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::posture::Chain;
use dynamics_core::trace_form::Transforms;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Inertia, InverseDynamics, Live, Model, Scene, Term, Trig, lagrange};
use nalgebra::{SMatrix, SVector, Vector3};
use robot_compiler::{Robot, SceneFile, with_dof};
use serde::Serialize;

/// The terms of `D(q) qdd + C(q, qd) qd + G(q) = tau + J^T w` (eq. 12.217).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Terms {
    /// The robot's name.
    pub robot: String,
    /// How they were computed: `lagrange`, `trace` or `recursive`.
    pub method: &'static str,
    /// Joint position, rad or m.
    pub q: Vec<f64>,
    /// Joint velocity, rad/s or m/s.
    pub qd: Vec<f64>,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub g: [f64; 3],
    /// `D(q)`, rows, with the rotors; kg m^2, kg m, kg.
    pub mass_matrix: Vec<Vec<f64>>,
    /// `C(q, qd)`, rows: `C_ij = sum_k Gamma^i_jk qd_k`.
    pub coriolis_matrix: Vec<Vec<f64>>,
    /// `H = C qd`, N m or N.
    pub velocity_coupling: Vec<f64>,
    /// `G(q)`, N m or N.
    pub gravity: Vec<f64>,
    /// `[i][j][k]` is `Gamma^i_jk` (eq. 12.281).
    pub christoffel: Vec<Vec<Vec<f64>>>,
}

/// Print the terms.
///
/// # Errors
/// A robot or a scene file that is wrong, a list of the wrong length, a posture outside the limits.
pub fn run(args: &TermsArgs) -> Result<(), Failure> {
    let file = scene_about(&args.robot, args.scene.as_deref())?;
    let terms = with_dof!(file.robot.dof(), N => {
        let model = file.robot.model::<N>().map_err(Failure::input)?;
        terms(args, &file, &model).map_err(Failure::Input)?
    });
    let text = if args.json {
        serde_json::to_string_pretty(&terms).map_err(|error| Failure::Output(error.into()))? + "\n"
    } else {
        describe(&terms, &file.robot)
    };
    failure::print(&text)
}

fn terms<const N: usize>(args: &TermsArgs, file: &SceneFile, model: &Model<f64, N>) -> miette::Result<Terms> {
    let (scene, live) = (file.scene(model), file.live(model));
    let q: [f64; N] = list("q", &args.q, "one for each joint")?;
    let qd = args.qd.as_ref().map_or(Ok([0.0; N]), |qd| list("qd", qd, "one for each joint"))?;
    let g = match &args.gravity {
        Some(gravity) => Vector3::from(list::<3>("gravity", gravity, "gx, gy, gz")?),
        None => scene.gravity.value(&live.gravity).copied().unwrap_or_else(Vector3::zeros),
    };
    within_limits(&file.robot, &q)?;

    let held = file.plant.payload.map(|body| Inertia::from_mass_centre(body.mass, &body.com, &body.inertia));
    let payload = scene.payload.value(&held.unwrap_or_else(Inertia::zero)).copied().unwrap_or_else(Inertia::zero);
    let mut found = match args.method {
        TermsMethod::Lagrange => by_jacobians(&Chain::new(model, &payload), &q, &qd, &g),
        TermsMethod::Trace => by_traces(&Chain::new(model, &payload), &q, &qd, &g),
        TermsMethod::Recursive => by_recursion(model, payload, &q, &qd, &g),
    };
    let counted = match args.rotor {
        Some(asked) => asked == Presence::Present,
        None => !matches!(scene.rotor, Term::Absent),
    };
    if counted {
        for (i, link) in model.links().iter().enumerate() {
            found.d[(i, i)] += link.rotor;
        }
    }
    found.named(args.method, &file.robot.name, &q, &qd, &g)
}

/// What a method gives, without rotors.
struct Found<const N: usize> {
    d: SMatrix<f64, N, N>,
    c: SMatrix<f64, N, N>,
    h: [f64; N],
    weight: [f64; N],
    christoffel: [[[f64; N]; N]; N],
}

fn by_jacobians<const N: usize>(chain: &Chain<f64, N>, q: &[f64; N], qd: &[f64; N], g: &Vector3<f64>) -> Found<N> {
    let posture = chain.posture(&Libm.sin_cos_all(q), q);
    Found {
        d: lagrange::mass_matrix(&posture),
        c: lagrange::coriolis_matrix(&posture, qd),
        h: lagrange::velocity_coupling(&posture, qd),
        weight: lagrange::gravity(&posture, g),
        christoffel: lagrange::christoffel(&posture),
    }
}

fn by_traces<const N: usize>(chain: &Chain<f64, N>, q: &[f64; N], qd: &[f64; N], g: &Vector3<f64>) -> Found<N> {
    let transforms = Transforms::new(chain, &Libm.sin_cos_all(q), q);
    let christoffel = transforms.coupling();
    let c = contracted(&christoffel, qd);
    Found {
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
) -> Found<N> {
    let (turn, live, zero) = (Libm.sin_cos_all(q), Live::zero(), [0.0; N]);
    let afloat = Scene { payload: Term::Constant(payload), ..Scene::free_space() };
    let heavy = Dynamics::new(*model, Scene { gravity: Term::Constant(*g), ..afloat });
    let afloat = Dynamics::new(*model, afloat);
    let velocity_terms = |qd: &[f64; N]| afloat.inverse_dynamics(&turn, q, qd, &zero, &live);
    // A quadratic form in the velocities: its values at pairs of unit speeds are its coefficients, and nothing is truncated.
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
    Found {
        d: mass_matrix(&afloat, &turn, q, &live),
        c: contracted(&christoffel, qd),
        h: velocity_terms(qd),
        weight: heavy.inverse_dynamics(&turn, q, &zero, &zero, &live),
        christoffel,
    }
}

/// `C_ij = sum_k Gamma^i_jk qd_k`.
fn contracted<const N: usize>(christoffel: &[[[f64; N]; N]; N], qd: &[f64; N]) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| christoffel[i][j].iter().zip(qd).map(|(symbol, speed)| symbol * speed).sum())
}

impl<const N: usize> Found<N> {
    fn named(
        &self,
        method: TermsMethod,
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
                TermsMethod::Lagrange => "lagrange",
                TermsMethod::Trace => "trace",
                TermsMethod::Recursive => "recursive",
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

/// Finite numbers of an option, as many as there should be.
fn list<const K: usize>(option: &str, values: &[f64], meaning: &str) -> miette::Result<[f64; K]> {
    if let Some(i) = values.iter().position(|x| !x.is_finite()) {
        return Err(miette::miette!("entry {} of `{option}` is {}; expected a finite number", i + 1, values[i]));
    }
    numbers(option, values, meaning)
        .map_err(|problem| miette::miette!(help = "the numbers are divided by commas: --q 0.1,-0.2", "{problem}"))
}

/// Every joint within its position limits.
fn within_limits<const N: usize>(robot: &Robot, q: &[f64; N]) -> miette::Result<()> {
    for (index, (joint, q)) in robot.joints.iter().zip(q).enumerate() {
        let (lo, hi) = joint.spec.limits.position;
        let (side, limit) = match q {
            q if *q < lo => ("below", lo),
            q if *q > hi => ("above", hi),
            _ => continue,
        };
        let unit = JointLabel { name: joint.name.clone(), kind: joint.spec.kind }.position_unit();
        return Err(miette::miette!(
            help = format!("expected a position from {lo} to {hi} {unit}"),
            "joint {} ({}): a position of {q} {unit} is {side} its limit of {limit} {unit}",
            index + 1,
            joint.name
        ));
    }
    Ok(())
}

/// The terms as tables.
#[must_use]
pub fn describe(terms: &Terms, robot: &Robot) -> String {
    let names: Vec<&str> = robot.joints.iter().map(|joint| joint.name.as_str()).collect();
    let mut state = table(&["joint", "q", "qd", "H = C qd", "G"]);
    for (i, joint) in robot.joints.iter().enumerate() {
        let label = JointLabel { name: joint.name.clone(), kind: joint.spec.kind };
        state.add_row([
            label.name.clone(),
            format!("{} {}", decimal(terms.q[i]), label.position_unit()),
            format!("{} {}", decimal(terms.qd[i]), label.velocity_unit()),
            format!("{} {}", decimal(terms.velocity_coupling[i]), label.torque_unit()),
            format!("{} {}", decimal(terms.gravity[i]), label.torque_unit()),
        ]);
    }
    let [gx, gy, gz] = terms.g;
    let mut text = format!("{}, by the method {}; g = ({gx}, {gy}, {gz}) m/s^2\n", terms.robot, terms.method);
    text += &format!("{state}\n\nInertia matrix D:\n{}\n", square(&names, &terms.mass_matrix));
    text += &format!("\nC, with dD/dt - 2 C skew-symmetric:\n{}\n", square(&names, &terms.coriolis_matrix));
    for (i, symbols) in terms.christoffel.iter().enumerate() {
        text += &format!(
            "\nChristoffel symbols of joint {} ({}), rows j and columns k:\n{}\n",
            i + 1,
            names[i],
            square(&names, symbols)
        );
    }
    text
}

fn square(names: &[&str], rows: &[Vec<f64>]) -> Table {
    let header: Vec<&str> = std::iter::once("").chain(names.iter().copied()).collect();
    let mut table = table(&header);
    for (name, row) in names.iter().zip(rows) {
        table.add_row(std::iter::once((*name).to_owned()).chain(row.iter().map(|x| decimal(*x))));
    }
    table
}

/// A table of a name and then numbers.
fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(header);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// Six decimals; what rounds to zero has no sign.
fn decimal(x: f64) -> String {
    let text = format!("{x:.6}");
    if text == "-0.000000" { "0.000000".to_owned() } else { text }
}
