//! Many states: transposed into blocks, computed on one core or on all, and transposed back.

use crate::arm::{Arm, ArmFloat, Compute, Singular};
use crate::kernel::{Block, Float, Kernel, LANES};
use crate::quantity::Quantity;
use ndarray::parallel::prelude::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use ndarray::{ArrayView2, ArrayViewMut2, Axis, Slice};
use std::sync::OnceLock;

/// Fewest states for which a kernel is faster than the recursion, including the time to prepare its memory.
const FEW: usize = 6;

/// States that one core computes at a time.
const GRAIN: usize = 1024;

/// Evaluates a function for every row of the inputs, which all have one row for each state and one column for each joint. `out` has
/// one row for each state and [`Quantity::results`] columns. Large batches use all cores.
///
/// # Errors
/// [`Singular`]: forward dynamics, and a joint moves no inertia. The rows of `out` are then meaningless.
pub fn evaluate<F: ArmFloat>(
    arm: &Arm,
    quantity: Quantity,
    inputs: &[ArrayView2<'_, F>],
    mut out: ArrayViewMut2<'_, F>,
) -> Result<(), Singular> {
    let worker = Worker { compute: F::of(arm), quantity, joints: arm.joints() };
    let states = out.nrows();
    if states <= FEW {
        return worker.by_recursion(0, inputs, &mut out);
    }
    if states < 2 * GRAIN || !may_use_threads() {
        return worker.by_kernel(0, inputs, out);
    }
    let chunks = out.axis_chunks_iter_mut(Axis(0), GRAIN).into_par_iter().enumerate();
    let found = chunks.map(|(chunk, out)| {
        let first = chunk * GRAIN;
        let rows = Slice::from(first..first + out.nrows());
        let inputs: Vec<_> = inputs.iter().map(|list| list.slice_axis(Axis(0), rows)).collect();
        worker.by_kernel(first, &inputs, out)
    });
    // The first state in the order of the batch, whatever the threads did.
    found.collect::<Vec<_>>().into_iter().collect()
}

/// True in the process that first asked. A forked child has no threads: it computes on one core.
fn may_use_threads() -> bool {
    static HOME: OnceLock<u32> = OnceLock::new();
    *HOME.get_or_init(std::process::id) == std::process::id()
}

/// The function that a batch evaluates.
#[derive(Clone, Copy)]
struct Worker<'a, F> {
    compute: &'a dyn Compute<F>,
    quantity: Quantity,
    joints: usize,
}

impl<F: Float> Worker<'_, F> {
    /// Computes every state by the recursion; `first` is the index of the first state.
    fn by_recursion(
        &self,
        first: usize,
        inputs: &[ArrayView2<'_, F>],
        out: &mut ArrayViewMut2<'_, F>,
    ) -> Result<(), Singular> {
        let mut lists = core::array::from_fn(|_| vec![F::zero(); self.joints]);
        let mut found = vec![F::zero(); self.quantity.outputs(self.joints)];
        for (state, mut row) in out.rows_mut().into_iter().enumerate() {
            for (list, input) in lists.iter_mut().zip(inputs) {
                list.iter_mut().zip(input.row(state)).for_each(|(x, input)| *x = *input);
            }
            self.one(first + state, &lists, &mut found)?;
            row.iter_mut().zip(&found).for_each(|(x, found)| *x = *found);
        }
        Ok(())
    }

    /// Computes one state by the recursion.
    fn one(&self, state: usize, lists: &[Vec<F>; 3], found: &mut [F]) -> Result<(), Singular> {
        self.compute.one(self.quantity, lists.each_ref().map(Vec::as_slice), found);
        if self.quantity == Quantity::ForwardDynamics {
            let finite = lists.iter().flatten().all(|x| x.is_finite());
            let pivots = &found[self.joints..];
            if let Some(joint) = pivots.iter().rposition(|pivot| !(*pivot > F::zero() && pivot.is_finite()))
                && finite
                && pivots.iter().all(|pivot| pivot.is_finite())
            {
                return Err(Singular { state, joint });
            }
        }
        Ok(())
    }

    /// Computes every state by a kernel, except those for which only the recursion gives the right bits.
    fn by_kernel(
        &self,
        first: usize,
        inputs: &[ArrayView2<'_, F>],
        mut out: ArrayViewMut2<'_, F>,
    ) -> Result<(), Singular> {
        let mut kernel = Kernel::new(self.compute.statements(self.quantity));
        let mut blocks = vec![vec![Block([F::zero(); LANES]); self.joints]; inputs.len()];
        for start in (0..out.nrows()).step_by(LANES) {
            let end = (start + LANES).min(out.nrows());
            let rows = Slice::from(start..end);
            let part: Vec<_> = inputs.iter().map(|list| list.slice_axis(Axis(0), rows)).collect();
            let mut results = out.slice_axis_mut(Axis(0), rows);
            if !load(&part, &mut blocks) {
                self.by_recursion(first + start, &part, &mut results)?;
                continue;
            }
            kernel.run(&blocks);
            if self.needs_recursion(&kernel, end - start) {
                self.by_recursion(first + start, &part, &mut results)?;
            } else {
                store(&kernel, &mut results);
            }
        }
        Ok(())
    }

    /// True if one of the first `count` states has a result that the kernel does not give: a torque of zero, which has a sign, or an
    /// acceleration that does not exist.
    fn needs_recursion(&self, kernel: &Kernel<'_, F>, count: usize) -> bool {
        let any = |outputs: core::ops::Range<usize>, f: &dyn Fn(F) -> bool| {
            outputs.into_iter().any(|k| kernel.output(k)[..count].iter().any(|x| f(*x)))
        };
        match self.quantity {
            Quantity::InverseDynamics => any(0..self.joints, &|x| x == F::zero()),
            Quantity::ForwardDynamics => any(self.joints..2 * self.joints, &|x| x <= F::zero() || !x.is_finite()),
            _ => false,
        }
    }
}

/// Copies states into blocks, the positions first. Returns false if a number is too large, infinite or NaN.
fn load<F: Float>(inputs: &[ArrayView2<'_, F>], blocks: &mut [Vec<Block<F>>]) -> bool {
    let mut ordinary = true;
    for (place, (input, list)) in inputs.iter().zip(blocks).enumerate() {
        let most = if place == 0 { F::ANGLE } else { F::ORDINARY };
        for (column, block) in input.columns().into_iter().zip(list) {
            for (x, input) in block.0.iter_mut().zip(column) {
                *x = *input;
                ordinary &= x.abs() <= most;
            }
        }
    }
    ordinary
}

/// Copies the results of a kernel into the rows of states; negative zeros become positive.
fn store<F: Float>(kernel: &Kernel<'_, F>, out: &mut ArrayViewMut2<'_, F>) {
    for (k, column) in out.columns_mut().into_iter().enumerate() {
        for (x, found) in column.into_iter().zip(kernel.output(k)) {
            *x = *found + F::zero();
        }
    }
}
