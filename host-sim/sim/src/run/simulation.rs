//! A simulation of a scene with any number of joints and any precision. Joint count and precision are selected here, at run time.

use super::closed_loop::World;
use super::scene_world;
use super::simulate::{self, Run};
use crate::failure::Failure;
use crate::plant::solver::{Solver, now};
use crate::plant::{Arm, State};
use dynamics_core::chapter::work::WorkMeter;
use indicatif::ProgressBar;
use robot_compiler::{SceneFile, with_dof};
use std::sync::atomic::AtomicBool;

/// The world of a scene at its start, ready for a run.
pub trait Simulation {
    /// Runs the controller of a scene with the same robot in this world, along this world's motion, until the motion's end or until `stop` is set.
    ///
    /// # Errors
    /// [`Failure::Input`] for a scene that cannot be run.
    fn run(&mut self, controller: &SceneFile, stop: &AtomicBool, progress: &ProgressBar) -> Result<Run, Failure>;

    /// Records the work on the arm during a run.
    fn record_work(&mut self);

    /// Work on the arm, and its energy at the start and at the end, J. `None` unless [`Simulation::record_work`] was called before the run.
    fn work(&self) -> Option<EnergyBalance>;

    /// Number of solutions of the equations of motion: the cost of the integration.
    fn accelerations(&self) -> u64;
}

/// Options of a world that a scene does not specify.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Ideal drives and sensors, whatever drives the robot file describes.
    pub ideal_drives: bool,
}

/// The simulation of a scene.
///
/// # Errors
/// [`Failure::Input`]: the motion is not possible, or the integrator's step is too long.
pub fn simulation(scene: &SceneFile, options: Options) -> Result<Box<dyn Simulation>, Failure> {
    Ok(with_dof!(scene.robot.dof(), N => {
        let world = if options.ideal_drives { scene_world::ideal_world::<N>(scene)? } else { scene_world::world::<N>(scene)? };
        Box::new(Simulated { world, arm: scene_world::arm::<N>(scene)? }) as Box<dyn Simulation>
    }))
}

/// Runs a scene on the desk, until its end or until `stop` is set.
///
/// # Errors
/// [`Failure::Input`] for a scene that cannot be run.
pub fn run(scene: &SceneFile, stop: &AtomicBool, progress: &ProgressBar) -> Result<Run, Failure> {
    simulation(scene, Options::default())?.run(scene, stop, progress)
}

/// Work of torques on the joints, J.
#[derive(Clone, Debug, PartialEq)]
pub struct JointWork {
    /// Positive work (given to the arm), by joint.
    pub positive: Vec<f64>,
    /// Negative work (taken from the arm), by joint; not above zero.
    pub negative: Vec<f64>,
}

impl JointWork {
    fn of<const N: usize>(meter: &WorkMeter<f64, N>) -> Self {
        Self { positive: meter.positive().to_vec(), negative: meter.negative().to_vec() }
    }

    /// Net work on a joint, J.
    #[must_use]
    pub fn total(&self, joint: usize) -> f64 {
        self.positive[joint] + self.negative[joint]
    }

    /// Net work on all joints, J.
    #[must_use]
    pub fn sum(&self) -> f64 {
        (0..self.positive.len()).map(|joint| self.total(joint)).sum()
    }

    /// Sum of the magnitudes of all parts, J.
    #[must_use]
    pub fn turnover(&self) -> f64 {
        self.positive.iter().chain(&self.negative).map(|x| x.abs()).sum()
    }
}

/// Work on an arm while its actuators drive it, and its energy.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyBalance {
    /// Work of the actuators.
    pub actuators: JointWork,
    /// Work of the joints' friction.
    pub friction: JointWork,
    /// Work of the wrench at the tip, as the joints feel it.
    pub contact: JointWork,
    /// Kinetic energy at the start and at the end, J.
    pub kinetic: [f64; 2],
    /// Potential energy at the start and at the end, J.
    pub potential: [f64; 2],
}

struct Simulated<const N: usize> {
    world: World<N>,
    arm: Arm<N>,
}

impl<const N: usize> Simulation for Simulated<N> {
    fn run(&mut self, controller: &SceneFile, stop: &AtomicBool, progress: &ProgressBar) -> Result<Run, Failure> {
        now(simulate::on_desk(Solver::AtOnce, &mut self.world, controller, stop, progress))
    }

    fn record_work(&mut self) {
        self.world.plant.start_ledger();
    }

    fn work(&self) -> Option<EnergyBalance> {
        let ledger = self.world.plant.ledger()?;
        let both = |energy: &dyn Fn(&State<N>) -> f64| [energy(&ledger.start), energy(&ledger.end)];
        Some(EnergyBalance {
            actuators: JointWork::of(&ledger.actuators),
            friction: JointWork::of(&ledger.friction),
            contact: JointWork::of(&ledger.contact),
            kinetic: both(&|state| self.arm.kinetic(&state.q, &state.qd)),
            potential: both(&|state| self.arm.potential(&state.q)),
        })
    }

    fn accelerations(&self) -> u64 {
        self.world.plant.accelerations()
    }
}
