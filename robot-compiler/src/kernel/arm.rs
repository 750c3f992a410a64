//! The inverse dynamics that a scene asks for, on the desk.

use super::functions::input_values;
use super::{Function, Level, Precision, Program, compile};
use crate::scene::SceneFile;
use dynamics_core::{Dynamics, InverseDynamics, Live, Model, Real, SinCos};

/// The recursion, or a kernel run by the tape's interpreter: the same operations, and so the same bits, as its source on
/// the chip.
#[derive(Clone, Debug)]
pub enum ArmDynamics<S, const N: usize> {
    /// The recursion. It stands for the exact kernel too, which is equal to it and which it outruns the interpreter of.
    Recursion(Dynamics<S, N>),
    /// A regrouped kernel.
    Kernel(Program),
}

impl SceneFile {
    /// The inverse dynamics that the scene asks for.
    #[must_use]
    pub fn dynamics<S: Real, const N: usize>(&self, model: &Model<f64, N>) -> ArmDynamics<S, N> {
        let scene = self.scene(model);
        match self.control.kernel.level() {
            Some(Level::Regrouped) => {
                let function = Function::InverseDynamics;
                ArmDynamics::Kernel(compile(function, model, &scene, Level::Regrouped, Precision::of::<S>()))
            }
            None | Some(Level::Exact) => ArmDynamics::Recursion(Dynamics::new(model.cast(), scene.cast())),
        }
    }
}

impl<S: Real, const N: usize> InverseDynamics<S, N> for ArmDynamics<S, N> {
    fn inverse_dynamics(
        &self,
        turn: &[SinCos<S>; N],
        q: &[S; N],
        qd: &[S; N],
        qdd: &[S; N],
        live: &Live<S, N>,
    ) -> [S; N] {
        match self {
            Self::Recursion(dynamics) => dynamics.inverse_dynamics(turn, q, qd, qdd, live),
            Self::Kernel(program) => {
                let found = program.evaluate(&input_values(turn, q, qd, qdd, live));
                core::array::from_fn(|i| found.get(i).copied().unwrap_or_else(S::zero))
            }
        }
    }
}
