//! The inverse dynamics that a scene selects, on the desk.

use crate::describe::scene::{KernelChoice, SceneFile};
use crate::kernel::inputs::{input_count, input_values, write_input_values};
use crate::kernel::interpreter::Interpreter;
use crate::kernel::{Function, Level, Precision, Program, compile};
use core::cell::RefCell;
use dynamics_core::control::{CollisionWatch, FrictionTerms};
use dynamics_core::{Dynamics, InverseDynamics, Live, Model, Real, SinCos};

/// Inverse dynamics on the desk: the recursion, or a kernel run by an interpreter. The interpreter does the same operations as
/// the kernel's source on the chip, so it gives the same bits.
#[derive(Clone, Debug)]
pub struct ArmDynamics<S, const N: usize> {
    means: Means<S, N>,
    friction_terms: Option<[FrictionTerms<S>; N]>,
}

/// Method of computing torques.
#[derive(Clone, Debug)]
enum Means<S, const N: usize> {
    /// The recursion. It also replaces the exact kernel, which gives equal results.
    Recursion(Dynamics<S, N>),
    /// A regrouped kernel.
    Kernel(RefCell<Ready<S>>),
    /// A regrouped kernel that is too large for the fast interpreter.
    Program(Program),
}

/// An interpreter, and a buffer for its inputs: nothing is allocated in a tick.
#[derive(Clone, Debug)]
struct Ready<S> {
    interpreter: Interpreter<S>,
    inputs: Vec<S>,
}

impl KernelChoice {
    /// The compiler's level, if a kernel is made.
    #[must_use]
    pub const fn level(self) -> Option<Level> {
        match self {
            Self::Generic => None,
            Self::Exact => Some(Level::Exact),
            Self::Regrouped => Some(Level::Regrouped),
        }
    }
}

impl SceneFile {
    /// Collision watch of the arm, or `None` if the scene has none. The chip's kernel of the momentum is always exact,
    /// so the recursion used here gives equal results.
    #[must_use]
    pub fn watch<S: Real, const N: usize>(
        &self,
        model: &Model<f64, N>,
    ) -> Option<CollisionWatch<S, N, Dynamics<S, N>>> {
        let config = self.collision_config::<N>()?;
        let dynamics = Dynamics::new(model.cast(), self.scene(model).cast());
        Some(CollisionWatch::new(config.cast(), dynamics))
    }

    /// The inverse dynamics that the scene selects.
    #[must_use]
    pub fn dynamics<S: Real, const N: usize>(&self, model: &Model<f64, N>) -> ArmDynamics<S, N> {
        let scene = self.scene(model);
        let means = match self.control.kernel.level() {
            Some(Level::Regrouped) => {
                let function = Function::InverseDynamics;
                let program = compile(function, model, &scene, Level::Regrouped, Precision::of::<S>());
                match Interpreter::new(&program, input_count(N)) {
                    Some(interpreter) => {
                        Means::Kernel(RefCell::new(Ready { interpreter, inputs: Vec::with_capacity(input_count(N)) }))
                    }
                    None => Means::Program(program),
                }
            }
            None | Some(Level::Exact) => Means::Recursion(Dynamics::new(model.cast(), scene.cast())),
        };
        let friction_terms = self.friction_terms::<N>().map(|all| all.map(|terms| terms.cast()));
        ArmDynamics { means, friction_terms }
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
        match &self.means {
            Means::Recursion(dynamics) => dynamics.inverse_dynamics(turn, q, qd, qdd, live),
            Means::Kernel(ready) => {
                let Ready { interpreter, inputs } = &mut *ready.borrow_mut();
                write_input_values(inputs, turn, [q, qd, qdd, &[S::zero(); N]], live);
                let mut found = [S::zero(); N];
                interpreter.run(inputs, &mut found);
                found
            }
            Means::Program(program) => {
                let found = program.evaluate(&input_values(turn, q, qd, qdd, live));
                core::array::from_fn(|i| found.get(i).copied().unwrap_or_else(S::zero))
            }
        }
    }

    fn friction_terms(&self) -> Option<&[FrictionTerms<S>; N]> {
        self.friction_terms.as_ref()
    }
}
