//! Which function is traced, and what its inputs and outputs are called.

use super::program::Program;
use super::tape::{Arena, Expr, input, trace};
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::newton_euler::joint_wrenches;
use dynamics_core::{Dynamics, Inertia, InverseDynamics, Live, Model, Real, Scene, SinCos, Term, Wrench};
use nalgebra::{Matrix3, Vector3};

/// What a kernel computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// `tau = D qdd + C qd + G - J^T w`
    InverseDynamics,
    /// `G(q)`, with what the arm holds.
    Gravity,
    /// `C(q, qd) qd`
    Coriolis,
    /// `D(q)`, the upper triangle row by row.
    MassMatrix,
    /// Force and moment at every joint, base first.
    JointWrenches,
}

impl Function {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::InverseDynamics, Self::Gravity, Self::Coriolis, Self::MassMatrix, Self::JointWrenches];

    /// Its name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::InverseDynamics => "inverse-dynamics",
            Self::Gravity => "gravity",
            Self::Coriolis => "coriolis",
            Self::MassMatrix => "mass-matrix",
            Self::JointWrenches => "joint-wrenches",
        }
    }

    /// What of a scene it sees: what does not enter its equation is absent.
    #[must_use]
    pub fn sees<const N: usize>(self, scene: &Scene<f64, N>) -> Scene<f64, N> {
        let weight = Scene { tip_wrench: Term::Absent, coriolis: Term::Absent, ..*scene };
        match self {
            Self::InverseDynamics => *scene,
            // Standing still, rotors do nothing.
            Self::Gravity => Scene { rotor: Term::Absent, ..weight },
            Self::Coriolis => Scene { gravity: Term::Absent, tip_wrench: Term::Absent, rotor: Term::Absent, ..*scene },
            Self::MassMatrix => Scene { gravity: Term::Absent, ..weight },
            // A rotor turns between motor and link: no joint carries its wrench.
            Self::JointWrenches => Scene { rotor: Term::Absent, ..*scene },
        }
    }
}

/// Inputs that come once per joint, in this order; the live ones follow.
const PER_JOINT: [&str; 5] = ["turn[].sin", "turn[].cos", "q[]", "qd[]", "qdd[]"];

/// Live inputs that come once; the rotors follow, one per joint.
const LIVE: [&str; 19] = [
    "live.gravity.x",
    "live.gravity.y",
    "live.gravity.z",
    "live.tip_wrench.force.x",
    "live.tip_wrench.force.y",
    "live.tip_wrench.force.z",
    "live.tip_wrench.moment.x",
    "live.tip_wrench.moment.y",
    "live.tip_wrench.moment.z",
    "live.payload.mass",
    "live.payload.first_moment.x",
    "live.payload.first_moment.y",
    "live.payload.first_moment.z",
    "live.payload.about_origin.m11",
    "live.payload.about_origin.m22",
    "live.payload.about_origin.m33",
    "live.payload.about_origin.m12",
    "live.payload.about_origin.m13",
    "live.payload.about_origin.m23",
];

/// The Rust expression of an input in the arguments of `InverseDynamics::inverse_dynamics`.
#[must_use]
pub fn input_name(number: u32, joints: usize) -> String {
    let (group, joint) = (number as usize / joints, number as usize % joints);
    if let Some(name) = PER_JOINT.get(group) {
        return name.replace("[]", &format!("[{joint}]"));
    }
    let live = number as usize - PER_JOINT.len() * joints;
    LIVE.get(live).map_or_else(|| format!("live.rotor[{}]", live - LIVE.len()), |name| (*name).to_owned())
}

/// Which argument of `InverseDynamics::inverse_dynamics` an input is part of.
#[must_use]
pub const fn argument(number: u32, joints: usize) -> &'static str {
    match number as usize / joints {
        0 | 1 => "turn",
        2 => "q",
        3 => "qd",
        4 => "qdd",
        _ => "live",
    }
}

/// How many live inputs a program of an arm with so many joints reads.
#[must_use]
pub fn live_inputs(program: &Program, joints: usize) -> usize {
    program.inputs().into_iter().filter(|&number| argument(number, joints) == "live").count()
}

/// The values of all inputs in the order of their numbers.
#[must_use]
pub fn input_values<S: Real, const N: usize>(
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    qdd: &[S; N],
    live: &Live<S, N>,
) -> Vec<S> {
    let Live { gravity, payload, tip_wrench, rotor } = live;
    let j = &payload.about_origin;
    let mut values: Vec<S> = turn.iter().map(|t| t.sin).chain(turn.iter().map(|t| t.cos)).collect();
    values.extend(q.iter().chain(qd).chain(qdd));
    values.extend(gravity.iter().chain(tip_wrench.force.iter()).chain(tip_wrench.moment.iter()));
    values.push(payload.mass);
    values.extend(payload.first_moment.iter());
    values.extend([j.m11, j.m22, j.m33, j.m12, j.m13, j.m23]);
    values.extend(rotor);
    values
}

/// Call the core's own function on an empty tape, and take the tape and the outputs.
pub(super) fn record<const N: usize>(
    function: Function,
    model: &Model<f64, N>,
    scene: &Scene<f64, N>,
    tape: Arena,
) -> (Arena, Vec<Expr>) {
    let scene = function.sees(scene);
    let (outputs, arena) = trace(tape, || {
        let joint = |group: usize| -> [Expr; N] { core::array::from_fn(|i| input((group * N + i) as u32)) };
        let (sin, cos, q, qd, qdd) = (joint(0), joint(1), joint(2), joint(3), joint(4));
        let turn: [SinCos<Expr>; N] = core::array::from_fn(|i| SinCos { sin: sin[i], cos: cos[i] });
        let live = live_tape();
        let dynamics = Dynamics::new(model.cast::<Expr>(), scene.cast::<Expr>());
        let zero = [<Expr as num_traits::Zero>::zero(); N];
        match function {
            Function::InverseDynamics => dynamics.inverse_dynamics(&turn, &q, &qd, &qdd, &live).to_vec(),
            Function::Gravity => dynamics.inverse_dynamics(&turn, &q, &zero, &zero, &live).to_vec(),
            Function::Coriolis => dynamics.inverse_dynamics(&turn, &q, &qd, &zero, &live).to_vec(),
            Function::MassMatrix => {
                let matrix = mass_matrix(&dynamics, &turn, &q, &live);
                (0..N).flat_map(|row| (row..N).map(move |column| (row, column))).map(|at| matrix[at]).collect()
            }
            Function::JointWrenches => joint_wrenches(&dynamics, &turn, &q, &qd, &qdd, &live)
                .iter()
                .flat_map(|w| w.force.iter().chain(w.moment.iter()).copied().collect::<Vec<_>>())
                .collect(),
        }
    });
    (arena, outputs)
}

fn live_tape<const N: usize>() -> Live<Expr, N> {
    let at = |k: usize| input((PER_JOINT.len() * N + k) as u32);
    let vector = |k: usize| Vector3::new(at(k), at(k + 1), at(k + 2));
    let (xx, yy, zz, xy, xz, yz) = (at(13), at(14), at(15), at(16), at(17), at(18));
    Live {
        gravity: vector(0),
        tip_wrench: Wrench { force: vector(3), moment: vector(6) },
        payload: Inertia {
            mass: at(9),
            first_moment: vector(10),
            about_origin: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
        },
        rotor: core::array::from_fn(|i| at(LIVE.len() + i)),
    }
}
