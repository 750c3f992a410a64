//! Arm kernel: the equations of motion, traced and made into machine code, for one arm or for several of one shape side by side.
//!
//! The source that is traced is [`Mechanism::solution`] itself, behind [`Polynomial::by_arithmetic`]. Zero, one and minus one stay in the code as what they are, so what they
//! make superfluous is left out. Every other number of the arm is an input, so arms that differ in masses, lengths, payload or gravity
//! share the code. Each arm's accelerations are equal (`==`) to those of [`Mechanism::acceleration`]; only a zero may have the other sign.

use super::dynamics::{HeldSolution, Mechanism, Solution};
use super::flow::Dry;
use dynamics_core::trig::Polynomial;
use dynamics_core::{JointKind, Scalar, Wrench};
use machine_code::{Instructions, Kernel, LANES};
use nalgebra::Vector3;
use robot_compiler::kernel::tape::{Arena, Expr, input, trace};
use robot_compiler::kernel::{Precision, Program, RuleSet};
use std::collections::HashMap;

/// Groups of inputs with one number a joint: position, velocity, torque, and one or zero for a joint that is free or held.
const GROUPS: usize = 4;
const POSITION: usize = 0;
const VELOCITY: usize = 1;
const TORQUE: usize = 2;
const FREE: usize = 3;

/// Numbers of a wrench at the tip, which follow.
const WRENCH: usize = 6;

/// A number of an arm, as the code sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Number {
    Zero,
    One,
    MinusOne,
    /// The input with this place among the arm's own.
    Given(usize),
}

/// Properties in common of arms that share the code.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Shape {
    /// True if revolute, and number of bodies moved, for each joint.
    joints: Vec<(bool, usize)>,
    numbers: Vec<Number>,
    wrench: bool,
    /// Friction can hold a joint.
    dry: bool,
    rotor_coupling: bool,
}

/// The shape of an arm, and the numbers that the code is given.
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
                // What is equal in every arm of this shape is computed once.
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

/// The equations of motion of arms of one shape, with the states of as many arms as a kernel has lanes.
#[derive(Clone, Debug)]
pub(super) struct ArmKernel<const N: usize> {
    kernel: Kernel,
    shape: Shape,
}

/// One for every lane of which something is true, zero for the others: as wide as the numbers that it is found from.
pub(super) type Flags = [u64; LANES];

/// One number of every joint, for all lanes.
pub(super) type JointLanes<const N: usize> = [[f64; LANES]; N];

impl<const N: usize> ArmKernel<N> {
    /// The kernel of arms of this shape; `None` where this processor has none.
    ///
    /// Cost: some 10 ms for six joints.
    pub(super) fn new(mechanism: &Mechanism<N>, wrench: bool, dry: bool) -> Option<Self> {
        let (shape, given) = take_apart(mechanism, wrench, dry);
        let kernel = Kernel::new(&program(mechanism, &shape), GROUPS * N + WRENCH + given.len())?;
        Some(Self { kernel, shape })
    }

    /// The kernel of this arm alone, in lane 0; `None` where this processor has none.
    ///
    /// Cost: as that of several arms.
    pub(super) fn of_one(mechanism: &Mechanism<N>, dry: bool) -> Option<Self> {
        let wrench = mechanism.tip_wrench().is_some();
        let (shape, given) = take_apart(mechanism, wrench, dry);
        let kernel = Kernel::of_one(&program(mechanism, &shape), GROUPS * N + WRENCH + given.len())?;
        let mut kernel = Self { kernel, shape };
        kernel.place(0, mechanism, dry);
        Some(kernel)
    }

    /// Let an arm alone feel this wrench at its tip; false if its code knows of none.
    pub(super) fn feels(&mut self, wrench: Option<Wrench<f64>>) -> bool {
        self.push(0, wrench);
        wrench.is_none() || self.shape.wrench
    }

    /// Place an arm of this shape in a lane; false if it has another shape.
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

    /// Set the wrench at the tip of a lane's arm.
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

    /// Instructions that the kernel is made of.
    pub(super) const fn instructions(&self) -> Instructions {
        self.kernel.instructions()
    }

    /// Write the accelerations of all lanes' arms to `qdd`, and what loads their held joints to `dry`. Returns the lanes whose inertia
    /// matrix is positive definite.
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

    /// Accelerations of an arm alone; `None` if its inertia matrix is not positive definite. What loads the held joints is written to `dry`.
    pub(super) fn solve_one(
        &mut self,
        q: &[f64; N],
        qd: &[f64; N],
        drive: &[f64; N],
        dry: Option<&mut Dry<N, 1>>,
    ) -> Option<[f64; N]> {
        let (inputs, _) = self.kernel.inputs().as_chunks_mut::<LANES>();
        let free = dry.as_ref().map_or(&[][..], |dry| &dry.free);
        for (to, from) in inputs.iter_mut().zip(q.iter().chain(qd).chain(drive).chain(free.as_flattened())) {
            to[0] = *from;
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

/// The equations of motion on a tape: accelerations, then pivots, then the loads of held joints.
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
