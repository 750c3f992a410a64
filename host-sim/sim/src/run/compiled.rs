//! The loop, compiled once for each number of joints.
//!
//! A package that calls a function with a joint count compiles that function again. So other packages reach the loop through [`Loop`]. Only
//! [`loops`], which has no joint count, makes the objects behind it.

use crate::failure::Failure;
use crate::plant::solver::{Solver, now};
use crate::run::one_run::{Run, RunOptions, closed_in};
use crate::run::target::Torques;
use crate::run::world::World;
use dynamics_core::Real;
use robot_compiler::with_dof;
use std::any::Any;

/// The loop in one precision.
pub trait Loop<S, const N: usize> {
    /// As [`within`].
    #[doc(hidden)]
    fn run(
        &self,
        world: &mut World<N>,
        options: &RunOptions<'_>,
        controller: &mut dyn Torques<S, N>,
    ) -> Result<Run, Failure>;
}

/// Integrates the arm at once, at each tick.
struct OneByOne;

impl<S: Real, const N: usize> Loop<S, N> for OneByOne {
    fn run(
        &self,
        world: &mut World<N>,
        options: &RunOptions<'_>,
        controller: &mut dyn Torques<S, N>,
    ) -> Result<Run, Failure> {
        now(closed_in(Solver::AtOnce, world, options, controller))
    }
}

/// The loop in each precision.
pub struct Loops<const N: usize> {
    f32: &'static dyn Loop<f32, N>,
    f64: &'static dyn Loop<f64, N>,
}

/// [`Loops`] for this number of joints. This package compiles them, whoever calls.
fn loops(dof: usize) -> Box<dyn Any> {
    with_dof!(dof, N => Box::new(Loops::<N> { f32: &OneByOne, f64: &OneByOne }))
}

/// A precision in which the loop is compiled.
pub trait LoopScalar: Real {
    /// The loop in this precision.
    #[doc(hidden)]
    fn of<const N: usize>(loops: &Loops<N>) -> &'static dyn Loop<Self, N>;
}

impl LoopScalar for f32 {
    fn of<const N: usize>(loops: &Loops<N>) -> &'static dyn Loop<Self, N> {
        loops.f32
    }
}

impl LoopScalar for f64 {
    fn of<const N: usize>(loops: &Loops<N>) -> &'static dyn Loop<Self, N> {
        loops.f64
    }
}

/// Runs a scene with this controller, on any target, in a world that the caller owns.
///
/// # Errors
/// [`Failure::Input`] for a scene that cannot be run; [`Failure::Target`] if the target rejects the live inputs. A target that fails during the run
/// is no error here: see [`Run::failure`].
pub fn within<S: LoopScalar, const N: usize>(
    world: &mut World<N>,
    options: &RunOptions<'_>,
    controller: &mut dyn Torques<S, N>,
) -> Result<Run, Failure> {
    match loops(N).downcast_ref::<Loops<N>>() {
        Some(loops) => S::of(loops).run(world, options, controller),
        None => Err(Failure::Input(miette::miette!("an arm of {N} joints; expected 1 to 6"))),
    }
}
