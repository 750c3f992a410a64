//! Integration of the arm and the loop around it, compiled once for each number of joints.
//!
//! A package that calls a function with a joint count compiles that function again. So other packages call what is large through [`Steps`]. Only
//! [`scene_world`](crate::run::scene_world) makes the object behind it, in a function without a joint count.

use crate::failure::Failure;
use crate::plant::Diverged;
use crate::plant::drives::Order;
use crate::plant::solver::{AtOnce, now};
use crate::run::simulate::{self, Run, RunOptions};
use crate::run::target::Torques;
use crate::run::world::World;
use core::fmt;
use dynamics_core::Real;

/// The large functions of a world.
pub(crate) trait Steps<const N: usize>: Send + Sync {
    /// As [`World::drive`].
    fn drive(&self, world: &mut World<N>, torque: &[f64; N]) -> Result<(), Diverged>;

    /// As [`World::stop`], with this command to the drives.
    fn rest(&self, world: &mut World<N>, order: &Order<N>) -> Result<(), Diverged>;

    /// As [`simulate::within`], in single precision.
    fn run_f32(
        &self,
        world: &mut World<N>,
        options: &RunOptions<'_>,
        controller: &mut dyn Torques<f32, N>,
    ) -> Result<Run, Failure>;

    /// As [`simulate::within`], in double precision.
    fn run_f64(
        &self,
        world: &mut World<N>,
        options: &RunOptions<'_>,
        controller: &mut dyn Torques<f64, N>,
    ) -> Result<Run, Failure>;
}

/// [`Steps`] compiled in this package.
#[derive(Clone, Copy)]
pub(crate) struct Compiled<const N: usize>(pub(crate) &'static dyn Steps<N>);

impl<const N: usize> Compiled<N> {
    /// The functions for this number of joints; the caller's package compiles them.
    pub(crate) fn new() -> Self {
        Self(&OneByOne)
    }
}

impl<const N: usize> fmt::Debug for Compiled<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Compiled")
    }
}

/// Integrates each arm at once.
struct OneByOne;

impl<const N: usize> Steps<N> for OneByOne {
    fn drive(&self, world: &mut World<N>, torque: &[f64; N]) -> Result<(), Diverged> {
        now(world.drive_with(&AtOnce, torque))
    }

    fn rest(&self, world: &mut World<N>, order: &Order<N>) -> Result<(), Diverged> {
        now(world.rest_with(&AtOnce, order))
    }

    fn run_f32(
        &self,
        world: &mut World<N>,
        options: &RunOptions<'_>,
        controller: &mut dyn Torques<f32, N>,
    ) -> Result<Run, Failure> {
        now(simulate::closed_in(&AtOnce, world, options, controller))
    }

    fn run_f64(
        &self,
        world: &mut World<N>,
        options: &RunOptions<'_>,
        controller: &mut dyn Torques<f64, N>,
    ) -> Result<Run, Failure> {
        now(simulate::closed_in(&AtOnce, world, options, controller))
    }
}

/// A precision in which the loop is compiled.
pub trait LoopScalar: Real {
    /// Runs the loop.
    #[doc(hidden)]
    fn run<const N: usize>(
        world: &mut World<N>,
        options: &RunOptions<'_>,
        controller: &mut dyn Torques<Self, N>,
    ) -> Result<Run, Failure>;
}

impl LoopScalar for f32 {
    fn run<const N: usize>(
        world: &mut World<N>,
        options: &RunOptions<'_>,
        controller: &mut dyn Torques<Self, N>,
    ) -> Result<Run, Failure> {
        let Compiled(compiled) = world.compiled;
        compiled.run_f32(world, options, controller)
    }
}

impl LoopScalar for f64 {
    fn run<const N: usize>(
        world: &mut World<N>,
        options: &RunOptions<'_>,
        controller: &mut dyn Torques<Self, N>,
    ) -> Result<Run, Failure> {
        let Compiled(compiled) = world.compiled;
        compiled.run_f64(world, options, controller)
    }
}
