//! Arm kernel: the equations of motion, traced and made into machine code, for several arms of one shape side by side.
//!
//! The source that is traced is [`Mechanism::solution`] itself. Zero, one and minus one stay in the code as what they are, so what they
//! make superfluous is left out. Every other number of the arm is an input, so arms that differ in masses, lengths, payload or gravity
//! share the code. Each arm's accelerations are equal (`==`) to those of [`Mechanism::acceleration`]; only a zero may have the other sign.

use super::Plant;
use super::dynamics::Mechanism;
use dynamics_core::trig::Polynomial;
use dynamics_core::{JointKind, Scalar, SinCos, Trig, Wrench};
use machine_code::Kernel;
use nalgebra::Vector3;
use robot_compiler::kernel::tape::{Arena, Expr, input, trace};
use robot_compiler::kernel::{Precision, Program, RuleSet};
use std::collections::HashMap;

/// Groups of inputs with one number a joint: sine, cosine, position, velocity, torque.
const GROUPS: usize = 5;
const SINE: usize = 0;
const COSINE: usize = 1;
const POSITION: usize = 2;
const VELOCITY: usize = 3;
const TORQUE: usize = 4;

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

/// What arms must have in common to share the code.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Shape {
    /// Whether each joint is revolute, and the number of bodies that it moves.
    joints: Vec<(bool, usize)>,
    numbers: Vec<Number>,
    wrench: bool,
    rotor_coupling: bool,
}

/// The shape of an arm, and the numbers that the code is given.
fn take_apart<const N: usize>(mechanism: &Mechanism<N>, wrench: bool) -> (Shape, Vec<f64>) {
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
    (Shape { joints, numbers, wrench, rotor_coupling }, given)
}

/// The equations of motion of arms of one shape, with the states of as many arms as the kernel has lanes.
#[derive(Clone, Debug)]
pub(crate) struct ArmKernel<const N: usize> {
    kernel: Kernel,
    shape: Shape,
}

impl<const N: usize> Plant<N> {
    /// What arms must have in common with this one to share code.
    pub(crate) fn shape(&self) -> Shape {
        take_apart(&self.body.mechanism, self.may_touch()).0
    }

    /// Whether a wrench acts at the tip, now or later.
    fn may_touch(&self) -> bool {
        self.push.is_some() || self.body.mechanism.tip_wrench().is_some()
    }
}

impl<const N: usize> ArmKernel<N> {
    /// The kernel of arms of this plant's shape; `None` where this processor has none.
    ///
    /// Cost: some 10 ms for six joints.
    pub(crate) fn new(plant: &Plant<N>) -> Option<Self> {
        let mechanism = &plant.body.mechanism;
        let (shape, given) = take_apart(mechanism, plant.may_touch());
        let kernel = Kernel::new(&program(mechanism, &shape), GROUPS * N + WRENCH + given.len())?;
        Some(Self { kernel, shape })
    }

    /// Arms side by side.
    pub(crate) fn lanes(&self) -> usize {
        self.kernel.lanes()
    }

    /// Place an arm of this shape in a lane; false if it has another shape.
    pub(crate) fn place(&mut self, lane: usize, plant: &Plant<N>) -> bool {
        let (shape, given) = take_apart(&plant.body.mechanism, plant.may_touch());
        let fits = shape == self.shape && lane < self.lanes();
        if fits {
            let lanes = self.lanes();
            for (k, number) in given.into_iter().enumerate() {
                self.kernel.inputs()[(GROUPS * N + WRENCH + k) * lanes + lane] = number;
            }
        }
        fits
    }

    /// Set the state of a lane's arm, the torques on its joints, and the wrench at its tip.
    pub(crate) fn ask(&mut self, lane: usize, q: &[f64; N], qd: &[f64; N], drive: &[f64; N], wrench: Option<Wrench<f64>>) {
        let (lanes, touched) = (self.kernel.lanes(), self.shape.wrench);
        let (state, rest) = self.kernel.inputs().split_at_mut(GROUPS * N * lanes);
        let groups = state.chunks_exact_mut(N * lanes).skip(POSITION).zip([q, qd, drive]);
        for (places, numbers) in groups {
            for (place, number) in places.iter_mut().skip(lane).step_by(lanes).zip(numbers) {
                *place = *number;
            }
        }
        if touched {
            let none = Wrench { force: Vector3::zeros(), moment: Vector3::zeros() };
            let Wrench { force, moment } = wrench.unwrap_or(none);
            let numbers = force.iter().chain(&moment);
            for (place, number) in rest.iter_mut().skip(lane).step_by(lanes).zip(numbers) {
                *place = *number;
            }
        }
    }

    /// Solve the equations of motion of all lanes.
    pub(crate) fn solve(&mut self) {
        let group = N * self.kernel.lanes();
        let inputs = self.kernel.inputs();
        let (turns, rest) = inputs.split_at_mut(2 * group);
        let (sines, cosines) = turns.split_at_mut(group);
        let angles = rest.iter().take(group);
        for ((sine, cosine), angle) in sines.iter_mut().zip(cosines).zip(angles) {
            SinCos { sin: *sine, cos: *cosine } = Polynomial.sin_cos(*angle);
        }
        self.kernel.run();
    }

    /// Write the accelerations of a lane's arm to `qdd`; false where [`Mechanism::acceleration`] has none.
    pub(crate) fn answer(&self, lane: usize, qdd: &mut [f64; N]) -> bool {
        let mut lane = self.kernel.outputs().iter().skip(lane).step_by(self.kernel.lanes());
        for (to, from) in qdd.iter_mut().zip(&mut lane) {
            *to = *from;
        }
        lane.all(|&pivot| pivot > 0.0 && pivot.is_finite())
    }
}

/// The equations of motion on a tape: accelerations, then pivots.
fn program<const N: usize>(mechanism: &Mechanism<N>, shape: &Shape) -> Program {
    let (outputs, arena) = trace(Arena::new(RuleSet::ALL, Precision::Double), || {
        let joints = |group: usize| -> [Expr; N] { core::array::from_fn(|i| input((group * N + i) as u32)) };
        let (sin, cos) = (joints(SINE), joints(COSINE));
        let turn: [SinCos<Expr>; N] = core::array::from_fn(|i| SinCos { sin: sin[i], cos: cos[i] });
        let own = |k: usize| input((GROUPS * N + k) as u32);
        let wrench =
            Wrench { force: Vector3::new(own(0), own(1), own(2)), moment: Vector3::new(own(3), own(4), own(5)) };
        let mut numbers = shape.numbers.iter();
        let number = |x: f64| match numbers.next() {
            Some(Number::Given(k)) => own(WRENCH + k),
            _ => Expr::literal(x),
        };
        let mechanism = mechanism.map(number, shape.wrench.then_some(wrench));
        let solution = mechanism.solution(&turn, &joints(POSITION), &joints(VELOCITY), &joints(TORQUE));
        solution.qdd.into_iter().chain(solution.pivot).collect::<Vec<_>>()
    });
    Program::new(arena, &outputs)
}
