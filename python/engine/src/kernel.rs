//! A program, run on one block of states.
//!
//! Every statement is a loop over the states of a block. The loops are compiled several times, for the instruction sets that
//! [`pulp::Arch`] knows, and the widest that the processor has is chosen at run time. No multiplication is fused with an addition, so
//! every state has the bits that the same operations on single numbers give.

use crate::statements::{Slot, Source, Statement, Statements};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Real, Trig};
use pulp::{Arch, WithSimd};

/// Number of states in a block.
pub const LANES: usize = 32;

/// One value in every state of a block.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Block<F>(pub [F; LANES]);

/// `f32` or `f64`.
pub trait Float: Real + Send + Sync + 'static {
    /// Largest magnitude of an input for which a program and the recursion cannot overflow differently.
    const ORDINARY: Self;

    /// Largest joint position for which sine and cosine are computed, rad; beyond it they are NaN.
    const ANGLE: Self;

    /// Sines and cosines of many angles, rad.
    fn sin_cos(angles: &[Self], sin: &mut [Self], cos: &mut [Self]);
}

macro_rules! impl_float {
    ($float:ty, $ordinary:literal, $angle:expr) => {
        impl Float for $float {
            const ORDINARY: Self = $ordinary;
            const ANGLE: Self = $angle;

            #[inline(always)]
            fn sin_cos(angles: &[Self], sin: &mut [Self], cos: &mut [Self]) {
                Polynomial.sin_cos_lists(angles, sin, cos);
            }
        }
    };
}

// The outputs are polynomials of degree four at most in the inputs, with coefficients far below the rest of the range.
impl_float!(f32, 1e7, Polynomial::LIMIT_F32);
impl_float!(f64, 1e60, Polynomial::LIMIT_F64);

/// A program ready to run, with its memory.
#[derive(Clone, Debug)]
pub struct Kernel<'a, F> {
    program: &'a Statements,
    memory: Vec<Block<F>>,
    /// Joints of which the program reads sine or cosine, and the slots of both.
    turns: Vec<(usize, [Option<Slot>; 2])>,
    /// Inputs that the program reads as they are: slot, list, joint.
    lists: Vec<(Slot, usize, usize)>,
    arch: Arch,
}

impl<'a, F: Float> Kernel<'a, F> {
    /// Prepares a program to run.
    #[must_use]
    pub fn new(program: &'a Statements) -> Self {
        Self::with(program, Arch::new())
    }

    /// Prepares a program to run with these instructions.
    #[must_use]
    pub fn with(program: &'a Statements, arch: Arch) -> Self {
        let mut memory = vec![Block([F::zero(); LANES]); program.slots];
        for (slot, number) in &program.numbers {
            memory[usize::from(*slot)] = Block([F::literal(*number); LANES]);
        }
        let mut turns: Vec<(usize, [Option<Slot>; 2])> = Vec::new();
        let mut lists = Vec::new();
        for (slot, source) in &program.inputs {
            let (joint, which) = match *source {
                Source::Sine(joint) => (joint, 0),
                Source::Cosine(joint) => (joint, 1),
                Source::List(list, joint) => {
                    lists.push((*slot, list, joint));
                    continue;
                }
            };
            match turns.iter_mut().find(|(other, _)| *other == joint) {
                Some((_, slots)) => slots[which] = Some(*slot),
                None => turns.push((joint, if which == 0 { [Some(*slot), None] } else { [None, Some(*slot)] })),
            }
        }
        Self { program, memory, turns, lists, arch }
    }

    /// Runs the program on a block: `inputs[list][joint]`, each with one number for every state.
    pub fn run(&mut self, inputs: &[Vec<Block<F>>]) {
        let arch = self.arch;
        arch.dispatch(Run { kernel: self, inputs });
    }

    /// Output number `k` of the last run, in every state.
    #[must_use]
    pub fn output(&self, k: usize) -> &[F; LANES] {
        &self.memory[usize::from(self.program.outputs[k])].0
    }
}

/// A call of a kernel, as [`pulp`] compiles it for an instruction set.
struct Run<'a, 'b, F> {
    kernel: &'a mut Kernel<'b, F>,
    inputs: &'a [Vec<Block<F>>],
}

impl<F: Float> WithSimd for Run<'_, '_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Kernel { program, memory, turns, lists, .. } = self.kernel;
        for (joint, slots) in turns {
            let (mut sine, mut cosine) = ([F::zero(); LANES], [F::zero(); LANES]);
            F::sin_cos(&self.inputs[0][*joint].0, &mut sine, &mut cosine);
            for (slot, values) in slots.iter().zip([sine, cosine]) {
                if let Some(slot) = slot {
                    memory[usize::from(*slot)].0 = values;
                }
            }
        }
        for (slot, list, joint) in lists {
            memory[usize::from(*slot)] = self.inputs[*list][*joint];
        }
        for statement in &program.statements {
            execute(memory, statement);
        }
    }
}

#[inline(always)]
fn execute<F: Float>(memory: &mut [Block<F>], statement: &Statement) {
    match *statement {
        Statement::Add(slots) => two(memory, slots, |a, b| a + b),
        Statement::Sub(slots) => two(memory, slots, |a, b| a - b),
        Statement::Mul(slots) => two(memory, slots, |a, b| a * b),
        Statement::Div(slots) => two(memory, slots, |a, b| a / b),
        Statement::Neg([to, a]) => two(memory, [to, a, a], |a, _| -a),
        Statement::MulAdd(slots) => three(memory, slots, |a, b, c| a * b + c),
        Statement::MulSub(slots) => three(memory, slots, |a, b, c| a * b - c),
        Statement::SubMul(slots) => three(memory, slots, |a, b, c| c - a * b),
    }
}

/// States that one step of a loop handles. Copies of so few numbers stay in registers; longer ones went through memory, which took
/// three times as long.
const STEP: usize = 8;

#[inline(always)]
fn two<F: Float>(memory: &mut [Block<F>], [to, a, b]: [Slot; 3], f: impl Fn(F, F) -> F) {
    let [to, a, b] = [to, a, b].map(usize::from);
    assert!(to < memory.len() && a < memory.len() && b < memory.len());
    for at in 0..LANES / STEP {
        let (x, y) = (step(&memory[a], at), step(&memory[b], at));
        memory[to].0.as_chunks_mut::<STEP>().0[at] = core::array::from_fn(|i| f(x[i], y[i]));
    }
}

#[inline(always)]
fn three<F: Float>(memory: &mut [Block<F>], [to, a, b, c]: [Slot; 4], f: impl Fn(F, F, F) -> F) {
    let [to, a, b, c] = [to, a, b, c].map(usize::from);
    assert!(to < memory.len() && a < memory.len() && b < memory.len() && c < memory.len());
    for at in 0..LANES / STEP {
        let (x, y, z) = (step(&memory[a], at), step(&memory[b], at), step(&memory[c], at));
        memory[to].0.as_chunks_mut::<STEP>().0[at] = core::array::from_fn(|i| f(x[i], y[i], z[i]));
    }
}

#[inline(always)]
fn step<F: Copy>(block: &Block<F>, at: usize) -> [F; STEP] {
    block.0.as_chunks::<STEP>().0[at]
}
