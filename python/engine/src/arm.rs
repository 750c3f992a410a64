//! An arm under gravity, with any number of joints and in two precisions.

use crate::kernel::Float;
use crate::quantity::Quantity;
use crate::statements::{Statements, statements};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Dynamics, Inertia, Model, Scene, Term, Trig};
use nalgebra::Vector3;
use robot_compiler::kernel::Precision;
use robot_compiler::{FileError, Robot, with_dof};
use std::sync::OnceLock;

/// An arm that is ready to compute.
pub struct Arm {
    joints: usize,
    single: Box<dyn Compute<f32>>,
    double: Box<dyn Compute<f64>>,
    parameters: Vec<f64>,
}

/// A joint that moves no inertia: accelerations do not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular {
    /// Index of the state.
    pub state: usize,
    /// The joint, counted from 0.
    pub joint: usize,
}

impl Arm {
    /// The arm of a robot under gravity (m/s^2, base frame), with a body at its tip, given in the tip frame.
    ///
    /// # Errors
    /// As [`Robot::model`]; for a robot that was built or changed in code; one that was read from a file has been checked.
    pub fn new(robot: &Robot, gravity: Vector3<f64>, payload: Option<Inertia<f64>>) -> Result<Self, FileError> {
        Ok(with_dof!(robot.dof(), N => {
            let model = robot.model::<N>()?;
            let scene = Scene { payload: payload.map_or(Term::Absent, Term::Constant), ..Scene::with_gravity(gravity, &model) };
            let mut links = model.links().map(|link| link.inertia);
            if let Some(payload) = payload {
                let tip = model.tip();
                links[N - 1] = links[N - 1] + payload.in_parent(&tip.rotation, &tip.translation);
            }
            Self {
                joints: N,
                single: Box::new(Fixed::<f32, N>::new(&model, &scene)),
                double: Box::new(Fixed::<f64, N>::new(&model, &scene)),
                parameters: links.iter().flat_map(Inertia::parameters).collect(),
            }
        }))
    }

    /// Number of joints.
    #[must_use]
    pub const fn joints(&self) -> usize {
        self.joints
    }

    /// Ten inertial parameters of each link, base first, in the order of
    /// [`PARAMETER_NAMES`](dynamics_core::regressor::PARAMETER_NAMES); the payload is part of the last link.
    #[must_use]
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }
}

/// The functions of an arm in one precision, whatever its number of joints.
pub trait Compute<F>: Send + Sync {
    /// Evaluates a function for one state by the recursion; `out` has [`Quantity::outputs`] numbers.
    fn one(&self, quantity: Quantity, inputs: [&[F]; 3], out: &mut [F]);

    /// The statements of a function; they are made at the first call.
    fn statements(&self, quantity: Quantity) -> &Statements;
}

/// Precision in which an arm computes: `f32` or `f64`.
pub trait ArmFloat: Float {
    /// The functions of an arm in this precision.
    #[doc(hidden)]
    fn of(arm: &Arm) -> &dyn Compute<Self>;
}

impl ArmFloat for f32 {
    fn of(arm: &Arm) -> &dyn Compute<Self> {
        arm.single.as_ref()
    }
}

impl ArmFloat for f64 {
    fn of(arm: &Arm) -> &dyn Compute<Self> {
        arm.double.as_ref()
    }
}

/// An arm with a fixed number of joints.
struct Fixed<F, const N: usize> {
    model: Model<f64, N>,
    scene: Scene<f64, N>,
    dynamics: Dynamics<F, N>,
    programs: [OnceLock<Statements>; Quantity::ALL.len()],
}

impl<F: Float, const N: usize> Fixed<F, N> {
    fn new(model: &Model<f64, N>, scene: &Scene<f64, N>) -> Self {
        Self {
            model: *model,
            scene: *scene,
            dynamics: Dynamics::new(model.cast(), scene.cast()),
            programs: Default::default(),
        }
    }
}

impl<F: Float, const N: usize> Compute<F> for Fixed<F, N>
where
    Polynomial: Trig<F>,
{
    fn one(&self, quantity: Quantity, inputs: [&[F]; 3], out: &mut [F]) {
        let [q, second, third] = inputs.map(|list| core::array::from_fn(|joint| list[joint]));
        quantity.evaluate(&self.dynamics, &Polynomial.sin_cos_all(&q), [&q, &second, &third], out);
        if quantity != Quantity::InverseDynamics {
            // A negative zero becomes positive; nothing else changes.
            out.iter_mut().for_each(|x| *x += F::zero());
        }
    }

    fn statements(&self, quantity: Quantity) -> &Statements {
        self.programs[quantity as usize]
            .get_or_init(|| statements(quantity, &self.model, &self.scene, Precision::of::<F>()))
    }
}
