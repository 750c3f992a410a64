//! `model`: results of the arm's equations of motion.

pub mod contact;
pub mod dynamics;
pub mod energy;
pub mod export;
pub mod info;
pub mod kernel;
pub mod linkage;
pub mod motion;
pub mod statics;
pub mod terms;

use crate::run::stop_on_interrupt;
use clap::{Args, Subcommand};
use sim::failure::Failure;

const EXAMPLES: &str = "\
Example:
  newtau model statics robots/ur5.toml --minimise total";

/// Options of `model`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ModelArgs {
    /// The computation.
    #[command(subcommand)]
    pub computation: Computation,
}

/// The computation.
#[derive(Clone, Debug, Subcommand)]
pub enum Computation {
    /// Inverse and forward dynamics of states given as JSON lines.
    Dynamics(dynamics::DynamicsArgs),
    /// The matrices of the equations of motion at one posture.
    Terms(terms::TermsArgs),
    /// Torques that hold an arm at rest, loads of its joints, and the posture with the least torque.
    Statics(statics::StaticsArgs),
    /// Wrench at the tip from a force sensor in the base, or the sensor's reading for a known contact.
    Contact(contact::ContactArgs),
    /// Run a scene and balance its energy: work of every joint, friction, remainder.
    Energy(energy::EnergyArgs),
    /// Drive a four-bar linkage or a slider-crank through a turn, or simulate it.
    Linkage(linkage::LinkageArgs),
    /// The arm's dynamics as straight-line Rust source, or tables of how many operations this spares.
    Kernel(kernel::KernelArgs),
    /// Turn the path of a hand-guided arm into a motion.
    Motion(motion::MotionArgs),
    /// Contents of a robot file.
    Info(info::InfoArgs),
    /// The arm of a robot file as a URDF.
    Export(export::ExportArgs),
}

impl ModelArgs {
    /// Runs the computation, and prints or writes its result. Returns the exit code.
    ///
    /// # Errors
    /// Errors of the computation.
    pub fn run(&self) -> Result<u8, Failure> {
        let done = match &self.computation {
            Computation::Energy(args) => return energy::run(args, &stop_on_interrupt()),
            Computation::Linkage(args) => return linkage::run(args),
            Computation::Dynamics(args) => dynamics::run(args),
            Computation::Terms(args) => terms::run(args),
            Computation::Statics(args) => statics::run(args),
            Computation::Contact(args) => contact::run(args),
            Computation::Kernel(args) => kernel::run(args),
            Computation::Motion(args) => motion::run(args),
            Computation::Info(args) => info::run(args),
            Computation::Export(args) => export::run(args),
        };
        done.map(|()| 0)
    }
}
