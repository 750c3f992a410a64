//! Arm kernel: the equations of motion, traced and compiled to machine code, for one arm or for several arms of the same shape, one a lane.
//!
//! The traced source is [`Mechanism::solution`] itself, with sines by [`Polynomial::by_arithmetic`]. Zero, one and minus one are constants in the
//! code, so operations that they make superfluous are left out. Every other number of the arm is an input. So arms that differ in masses, lengths,
//! payload or gravity share the code. Each arm's accelerations are equal (`==`) to those of [`Mechanism::acceleration`]; only a zero may have the
//! other sign.

use super::dynamics::{HeldSolution, Mechanism, Solution};
use super::flow::Dry;
use dynamics_core::trig::Polynomial;
use dynamics_core::{JointKind, Scalar, Wrench};
use machine_code::{Instructions, Kernel, LANES};
use nalgebra::Vector3;
use robot_compiler::kernel::tape::{Arena, Expr, input, trace};
use robot_compiler::kernel::{Precision, Program, RuleSet};
use std::collections::HashMap;

/// Groups of inputs with one number per joint: position, velocity, torque, and one for a free joint or zero for a held one.
const GROUPS: usize = 4;
const POSITION: usize = 0;
const VELOCITY: usize = 1;
const TORQUE: usize = 2;
const FREE: usize = 3;

/// Number of components of the wrench at the tip. These inputs follow the groups.
const WRENCH: usize = 6;

/// A number of an arm, as it appears in the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Number {
    Zero,
    One,
    MinusOne,
    /// Input with this index among the arm's own numbers.
    Given(usize),
}

/// Properties that arms must share to use the same code.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Shape {
    /// For each joint: true if revolute, and the number of bodies that it moves.
    joints: Vec<(bool, usize)>,
    numbers: Vec<Number>,
    wrench: bool,
    /// True if friction can hold a joint.
    dry: bool,
    rotor_coupling: bool,
}

/// Splits an arm into its shape and the numbers that are inputs of the code.
pub(super) fn take_apart<const N: usize>(mechanism: &Mechanism<N>, wrench: bool, dry: bool) -> (Shape, Vec<f64>) {
    let (mut numbers, mut given) = (Vec::new(), Vec::new());
    let mut known: HashMap<u64, usize> = HashMap::new();
    let rotor_coupling = mechanism.has_rotor_coupling();
    mechanism.map::<f64>(
        |x| {
            numbers.push(match x {
                0.0 => Number::Zero,
                1.0 => Number::One,
                -1.0 => Number::MinusOne,
                // A number that occurs several times in an arm is one input.
                _ => Number::Given(*known.entry(x.to_bits()).or_insert_with(|| {
                    given.push(x);
                    given.len() - 1
                })),
            });
            x
        },
        None,
    );
    let joints = mechanism.joints().map(|(kind, bodies)| (kind == JointKind::Revolute, bodies)).to_vec();
    (Shape { joints, numbers, wrench, dry, rotor_coupling }, given)
}

/// The compiled equations of motion of arms of one shape, and the inputs of as many arms as a kernel has lanes.
#[derive(Clone, Debug)]
pub(super) struct ArmKernel<const N: usize> {
    kernel: Kernel,
    shape: Shape,
}

/// A flag per lane: one if true, zero otherwise. As wide as the numbers from which it is computed.
pub(super) type Flags = [u64; LANES];

/// One number per joint and lane.
pub(super) type JointLanes<const N: usize> = [[f64; LANES]; N];

impl<const N: usize> ArmKernel<N> {
    /// Compiles a kernel for arms of this shape; `None` if this processor is not supported.
    ///
    /// Cost: some milliseconds for six joints.
    pub(super) fn new(mechanism: &Mechanism<N>, wrench: bool, dry: bool) -> Option<Self> {
        let (shape, given) = take_apart(mechanism, wrench, dry);
        let kernel = Kernel::new(&program(mechanism, &shape), GROUPS * N + WRENCH + given.len())?;
        Some(Self { kernel, shape })
    }

    /// Compiles a kernel for this arm alone, in lane 0; `None` if this processor is not supported.
    ///
    /// Cost: as [`ArmKernel::new`].
    pub(super) fn of_one(mechanism: &Mechanism<N>, dry: bool) -> Option<Self> {
        let wrench = mechanism.tip_wrench().is_some();
        let (shape, given) = take_apart(mechanism, wrench, dry);
        let kernel = Kernel::of_one(&program(mechanism, &shape), GROUPS * N + WRENCH + given.len())?;
        let mut kernel = Self { kernel, shape };
        kernel.place(0, mechanism, dry);
        Some(kernel)
    }

    /// Sets the wrench at the tip of a single arm. Returns false if the code has no input for a wrench.
    pub(super) fn feels(&mut self, wrench: Option<Wrench<f64>>) -> bool {
        self.push(0, wrench);
        wrench.is_none() || self.shape.wrench
    }

    /// Puts an arm into a lane. Returns false if the arm has another shape.
    pub(super) fn place(&mut self, lane: usize, mechanism: &Mechanism<N>, dry: bool) -> bool {
        let (shape, given) = take_apart(mechanism, self.shape.wrench, dry);
        if shape != self.shape {
            return false;
        }
        for (k, number) in given.into_iter().enumerate() {
            self.write(GROUPS * N + WRENCH + k, lane, number);
        }
        true
    }

    /// Sets the wrench at the tip of a lane's arm.
    pub(super) fn push(&mut self, lane: usize, wrench: Option<Wrench<f64>>) {
        if !self.shape.wrench {
            return;
        }
        let none = Wrench { force: Vector3::zeros(), moment: Vector3::zeros() };
        let Wrench { force, moment } = wrench.unwrap_or(none);
        for (k, number) in force.iter().chain(&moment).enumerate() {
            self.write(GROUPS * N + k, lane, *number);
        }
    }

    /// Processor instruction set that the kernel uses.
    pub(super) const fn instructions(&self) -> Instructions {
        self.kernel.instructions()
    }

    /// Writes the accelerations of all lanes' arms to `qdd`, and the loads of held joints to `dry`. Returns the lanes whose inertia matrix is
    /// positive definite.
    #[inline(always)]
    pub(super) fn solve(
        &mut self,
        (q, qd): (&JointLanes<N>, &JointLanes<N>),
        drive: &JointLanes<N>,
        dry: &mut Dry<N, LANES>,
        qdd: &mut JointLanes<N>,
    ) -> Flags {
        let (inputs, _) = self.kernel.inputs().as_chunks_mut::<LANES>();
        inputs[POSITION * N..(POSITION + 1) * N].copy_from_slice(q);
        inputs[VELOCITY * N..(VELOCITY + 1) * N].copy_from_slice(qd);
        inputs[TORQUE * N..(TORQUE + 1) * N].copy_from_slice(drive);
        if self.shape.dry {
            inputs[FREE * N..(FREE + 1) * N].copy_from_slice(&dry.free);
        }
        self.kernel.run();
        let (outputs, _) = self.kernel.outputs().as_chunks::<LANES>();
        qdd.copy_from_slice(&outputs[..N]);
        if self.shape.dry {
            dry.load.copy_from_slice(&outputs[2 * N..3 * N]);
        }
        let mut definite = [1_u64; LANES];
        for pivot in &outputs[N..2 * N] {
            for lane in 0..LANES {
                definite[lane] &= u64::from(pivot[lane] > 0.0) & u64::from(pivot[lane].is_finite());
            }
        }
        definite
    }

    /// Computes the accelerations of a single arm; `None` if its inertia matrix is not positive definite. Writes the loads of held joints to `dry`.
    pub(super) fn solve_one(
        &mut self,
        q: &[f64; N],
        qd: &[f64; N],
        drive: &[f64; N],
        dry: Option<&mut Dry<N, 1>>,
    ) -> Option<[f64; N]> {
        let (inputs, _) = self.kernel.inputs().as_chunks_mut::<LANES>();
        let (groups, _) = inputs.as_chunks_mut::<N>();
        for (group, values) in [(POSITION, q), (VELOCITY, qd), (TORQUE, drive)] {
            for joint in 0..N {
                groups[group][joint][0] = values[joint];
            }
        }
        if let Some(dry) = &dry {
            for joint in 0..N {
                groups[FREE][joint][0] = dry.free[joint][0];
            }
        }
        self.kernel.run_one();
        let (outputs, _) = self.kernel.outputs().as_chunks::<LANES>();
        let definite = |pivot: &[f64; LANES]| pivot[0] > 0.0 && pivot[0].is_finite();
        if let Some(dry) = dry {
            dry.load = core::array::from_fn(|joint| [outputs[2 * N + joint][0]]);
        }
        outputs[N..2 * N].iter().all(definite).then(|| core::array::from_fn(|joint| outputs[joint][0]))
    }

    fn write(&mut self, number: usize, lane: usize, to: f64) {
        if let Some(place) = self.kernel.inputs().get_mut(number * LANES + lane) {
            *place = to;
        }
    }
}

/// Traces the equations of motion: accelerations, then pivots, then the loads of held joints.
fn program<const N: usize>(mechanism: &Mechanism<N>, shape: &Shape) -> Program {
    let (outputs, arena) = trace(Arena::new(RuleSet::ALL, Precision::Double), || {
        let joints = |group: usize| -> [Expr; N] { core::array::from_fn(|i| input((group * N + i) as u32)) };
        let turn = joints(POSITION).map(Polynomial::by_arithmetic);
        let own = |k: usize| input((GROUPS * N + k) as u32);
        let wrench =
            Wrench { force: Vector3::new(own(0), own(1), own(2)), moment: Vector3::new(own(3), own(4), own(5)) };
        let mut numbers = shape.numbers.iter();
        let number = |x: f64| match numbers.next() {
            Some(Number::Given(k)) => own(WRENCH + k),
            _ => Expr::literal(x),
        };
        let mechanism = mechanism.map(number, shape.wrench.then_some(wrench));
        let (q, qd, torque) = (joints(POSITION), joints(VELOCITY), joints(TORQUE));
        if shape.dry {
            let HeldSolution { qdd, pivot, load } = mechanism.solution_held(&turn, (&q, &qd), &torque, &joints(FREE));
            return [qdd, pivot, load].concat();
        }
        let Solution { qdd, pivot } = mechanism.solution(&turn, &q, &qd, &torque);
        [qdd, pivot].concat()
    });
    Program::new(arena, &outputs)
}
