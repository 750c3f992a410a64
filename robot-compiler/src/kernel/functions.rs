//! Functions that can be traced, and the names of their inputs and outputs.

use super::frames::{Frames, Turning};
use super::inputs::{LIVE, PER_JOINT, input_count};
use super::tape::{Arena, Expr, input, trace};
use crate::names::{self, Named};
use dynamics_core::control::{Gains, computed_torque};
use dynamics_core::forward_dynamics;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::momentum::{GeneralizedMomentum, Momentum};
use dynamics_core::newton_euler::joint_wrenches;
use dynamics_core::regressor::inverse_dynamics_regressor;
use dynamics_core::{Dynamics, Inertia, InverseDynamics, Live, Model, Reference, Scalar, Scene, SinCos, Term, Wrench};
use nalgebra::{Matrix3, Vector3};

/// The function that a kernel computes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Function {
    /// `tau = D qdd + C qd + G - J^T w`
    InverseDynamics,
    /// `G(q)`, with the payload of the arm.
    Gravity,
    /// `C(q, qd) qd`
    Coriolis,
    /// `D(q)`, the upper triangle row by row.
    MassMatrix,
    /// Force and moment at every joint, base first.
    JointWrenches,
    /// `p = D qd`, then `C^T qd - G + J^T w`: the input of the observer of external torques.
    Momentum,
    /// `qdd = D^-1 (tau - C qd - G + J^T w)`, then the pivots: the only one that divides.
    ForwardDynamics,
    /// `d tau / d pi`, joint by joint: the ten parameters of the joint's own link and of every link beyond it.
    Regressor,
    /// `tau = ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q))`: the whole control law, with its gains as constants.
    ComputedTorque(Springs),
}

/// The gains of the computed-torque law, base first: `Kp`, 1/s^2, and `Kd`, 1/s, of every joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Springs([[f64; 2]; 6]);

impl Springs {
    /// No feedback.
    pub const NONE: Self = Self([[0.0; 2]; 6]);

    /// From a controller's gains.
    #[must_use]
    pub fn new<const N: usize>(gains: &[Gains<f64>; N]) -> Self {
        Self(core::array::from_fn(|i| gains.get(i).map_or([0.0; 2], |gains| [gains.position, gains.velocity])))
    }

    /// As constants of a scalar; the law does not read the inertia.
    fn gains<S: Scalar, const N: usize>(&self) -> [Gains<S>; N] {
        let all = self.0.map(|[position, velocity]| Gains {
            position: S::literal(position),
            velocity: S::literal(velocity),
            inertia: S::zero(),
        });
        let none = Gains { position: S::zero(), velocity: S::zero(), inertia: S::zero() };
        core::array::from_fn(|i| all.get(i).copied().unwrap_or(none))
    }
}

impl Function {
    /// All functions that need only an arm in a scene.
    pub const ALL: [Self; 7] = [
        Self::InverseDynamics,
        Self::Gravity,
        Self::Coriolis,
        Self::MassMatrix,
        Self::JointWrenches,
        Self::Momentum,
        Self::ForwardDynamics,
    ];

    /// Its name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        names::name(self)
    }

    /// The function with these gains, if it is a law; otherwise unchanged.
    #[must_use]
    pub const fn with(self, springs: Springs) -> Self {
        match self {
            Self::ComputedTorque(_) => Self::ComputedTorque(springs),
            other => other,
        }
    }

    /// The scene for this function: terms outside its equation are absent.
    #[must_use]
    pub fn sees<const N: usize>(self, scene: &Scene<f64, N>) -> Scene<f64, N> {
        let weight = Scene { tip_wrench: Term::Absent, coriolis: Term::Absent, ..*scene };
        match self {
            Self::InverseDynamics | Self::ForwardDynamics | Self::ComputedTorque(_) => *scene,
            // At rest, rotors have no effect.
            Self::Gravity => Scene { rotor: Term::Absent, ..weight },
            Self::Coriolis => Scene { gravity: Term::Absent, tip_wrench: Term::Absent, rotor: Term::Absent, ..*scene },
            Self::MassMatrix => Scene { gravity: Term::Absent, ..weight },
            // The momentum keeps all its velocity terms.
            Self::Momentum => Scene { coriolis: Term::Live, ..*scene },
            // Gravity is the only load that multiplies a link's parameters.
            Self::Regressor => Scene { payload: Term::Absent, tip_wrench: Term::Absent, rotor: Term::Absent, ..*scene },
            // A rotor turns between motor and link, so no joint carries its wrench.
            Self::JointWrenches => Scene { rotor: Term::Absent, ..*scene },
        }
    }
}

/// The law has no gains before [`Function::with`] sets them.
impl Named for Function {
    const NAMES: &'static [(&'static str, &'static str, Self)] = &[
        ("inverse-dynamics", "D qdd + C qd + G - J^T w", Self::InverseDynamics),
        ("gravity", "G(q)", Self::Gravity),
        ("coriolis", "C(q, qd) qd", Self::Coriolis),
        ("mass-matrix", "D(q), the upper triangle row by row", Self::MassMatrix),
        ("joint-wrenches", "Force and moment at every joint, base first", Self::JointWrenches),
        ("momentum", "Generalised momentum, then what changes it beside the actuators", Self::Momentum),
        ("forward-dynamics", "Accelerations from torques, then the pivots", Self::ForwardDynamics),
        ("regressor", "d tau / d pi: joint by joint, ten parameters of each link that it moves", Self::Regressor),
        (
            "computed-torque",
            "The law, ID(q, qd, qdd_ref + Kd (qd_ref - qd) + Kp (q_ref - q)), with the scene's gains folded in",
            Self::ComputedTorque(Springs::NONE),
        ),
    ];
}

/// Runs the core's own function on an empty tape, and returns the tape and the outputs.
pub(super) fn record<const N: usize>(
    function: Function,
    model: &Model<f64, N>,
    scene: &Scene<f64, N>,
    frames: Option<(&Frames<N>, &Turning)>,
    tape: Arena,
) -> (Arena, Vec<Expr>) {
    let scene = function.sees(scene);
    let (outputs, arena) = trace(tape, || {
        let joint = |group: usize| -> [Expr; N] { core::array::from_fn(|i| input((group * N + i) as u32)) };
        let (sin, cos, q, qd, qdd, tau) = (joint(0), joint(1), joint(2), joint(3), joint(4), joint(5));
        let turn: [SinCos<Expr>; N] = core::array::from_fn(|i| SinCos { sin: sin[i], cos: cos[i] });
        let (model, turn) =
            frames.map_or_else(|| (model.cast(), turn), |(frames, how)| frames.on_tape(model, &turn, how));
        let live = live_tape();
        let dynamics = Dynamics::new(model, scene.cast::<Expr>());
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
            Function::Momentum => {
                let Momentum { momentum, rate } = dynamics.momentum(&turn, &q, &qd, &live);
                [momentum, rate].concat()
            }
            Function::ForwardDynamics => {
                let found = forward_dynamics::acceleration(&dynamics, &turn, &q, &qd, &tau, &live);
                found.qdd.into_iter().chain(found.pivot).collect()
            }
            Function::Regressor => {
                let columns = inverse_dynamics_regressor(&dynamics, &turn, &q, &qd, &qdd, &live);
                columns.iter().enumerate().flat_map(|(i, row)| row[i..].iter().flatten().copied()).collect()
            }
            Function::ComputedTorque(springs) => {
                let start = input_count(N);
                let at = |group: usize| core::array::from_fn(|i| input((start + group * N + i) as u32));
                let reference = Reference { q: at(0), qd: at(1), qdd: at(2) };
                computed_torque(&springs.gains(), &dynamics, || turn, &reference, (&q, &qd), &live).to_vec()
            }
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
