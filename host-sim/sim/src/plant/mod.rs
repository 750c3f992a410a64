//! The simulated arm: f64, with its own algorithm.
//!
//! | module | holds |
//! |---|---|
//! | `state` | states of one arm, or of several arms, one per lane |
//! | `flow` | their differential equation, with dry friction in it |
//! | [`dynamics`] | equations of motion from moving bodies in base axes |
//! | `moving_bodies` | bodies in base axes, their motion and their loads |
//! | `loaded_arm` | an arm with friction and ripple: its accelerations under torques |
//! | `arm_kernel` | the equations of motion in machine code, for one arm or for several arms, one per lane |
//! | `arm_lanes` | friction, ripple and torque curves of several arms that are integrated together |
//! | [`integrator`], `dormand_prince` | fourth-order Runge-Kutta, semi-implicit Euler, an adaptive pair |
//! | [`elasticity`] | motor and link sides of elastic joints, backlash between them |
//! | `factors` | solution of the equations of motion, with joints that are held |
//! | [`friction`] | viscous, Coulomb and Stribeck friction |
//! | `stiction` | which joints slide and which are held by friction, and when that changes |
//! | `curve` | interpolant of a step, which gives the instant of such a change |
//! | [`actuator`] | delay, saturation, lag and ripple of an ideal drive's torque |
//! | [`drives`], `drive_wiring` | simulated drives: the board's own driver code, three CAN buses, and an actuator at every joint |
//! | `joint_mount` | bus, gearing and actuator of a joint with a simulated drive |
//! | `tick`, `braking` | a control period of the arm, driven or braked |
//! | [`jitter`] | random offsets of the instants of measuring and acting |
//! | [`sensor`] | noise, encoder counts and delay of the measurement |
//! | `solver` | the interface through which a run waits for the integration of its arm |
//! | [`ledger`] | energy put into the arm and taken out of it |

pub mod actuator;
pub(crate) mod arm_kernel;
pub(crate) mod arm_lanes;
mod braking;
#[cfg(test)]
mod calls;
mod curve;
mod dormand_prince;
mod drive_wiring;
pub mod drives;
pub mod dynamics;
pub mod elasticity;
mod factors;
mod flow;
pub mod friction;
pub mod integrator;
pub mod jitter;
mod joint_mount;
mod kinematics;
pub mod ledger;
mod loaded_arm;
mod moving_bodies;
mod rotor_coupling;
pub mod sensor;
pub(crate) mod solver;
mod state;
mod stiction;
mod terms;
#[cfg(test)]
mod tests;
mod tick;

use actuator::{ActuatorSettings, Actuators};
pub use braking::BRAKING_TIME;
use braking::Braking;
pub use dynamics::Arm;
use dynamics_core::{JointSpec, Wrench};
use elasticity::{Elasticity, Motors};
pub use friction::JointFriction;
use jitter::Jitter;
use ledger::Ledger;
pub(crate) use loaded_arm::LoadedArm;
use loaded_arm::Rigid;
use robot_compiler::scene::{Integrator, Push, Side};
pub use state::{Diverged, State};

/// Division of time into ticks and steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Control period, s.
    pub period: f64,
    /// Integration steps in a period; the adaptive integrator chooses its own steps.
    pub steps_per_tick: u32,
}

impl Clock {
    /// Length of one step, s.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.period / f64::from(self.steps_per_tick)
    }
}

/// The simulated arm with its actuators and brakes.
///
/// Brakes are stronger than the arm. From the tick in which they engage, every joint decelerates at a constant rate, comes to rest within
/// [`BRAKING_TIME`], and then stays at rest under any load. In an elastic joint both sides do so.
#[derive(Clone, Debug)]
pub struct Plant<const N: usize> {
    body: LoadedArm<N>,
    actuators: Actuators<N>,
    clock: Clock,
    integrator: Integrator,
    /// Next step of the adaptive integrator, s.
    next_step: f64,
    state: State<N>,
    /// Permanent wrench at the tip, and a push of limited duration.
    push: Option<(Option<Wrench<f64>>, Push)>,
    /// Ticks that have begun, whether driven, braked or neither. [`Push`] is timed by this clock.
    ticks: u64,
    motors: Option<Motors<N>>,
    sampling: Option<Jitter>,
    acting: Option<Jitter>,
    /// The state that the sensors sampled, if they sample at another instant than the start of the tick.
    sampled: Option<State<N>>,
    brake: Option<Braking<N>>,
    ledger: Option<Ledger<N>>,
}

impl<const N: usize> Plant<N> {
    /// An arm at rest at `start`.
    #[must_use]
    pub fn new(
        arm: &Arm<N>,
        friction: Option<[JointFriction; N]>,
        actuators: ActuatorSettings,
        clock: Clock,
        start: [f64; N],
    ) -> Self {
        let torque_max = core::array::from_fn(|i| arm.joints[i].limits.torque);
        let ripple = actuators.ripple;
        let kinds = core::array::from_fn(|i| arm.joints[i].kind);
        Self {
            body: LoadedArm::new(arm.mechanism(), friction, ripple, kinds),
            actuators: Actuators::new(actuators, torque_max),
            clock,
            integrator: Integrator::default(),
            next_step: clock.period,
            state: State { q: start, qd: [0.0; N] },
            push: None,
            ticks: 0,
            motors: None,
            sampling: None,
            acting: None,
            sampled: None,
            brake: None,
            ledger: None,
        }
    }

    /// The same arm, integrated by another method.
    #[must_use]
    pub fn with_integrator(self, integrator: Integrator) -> Self {
        Self { integrator, ..self }
    }

    /// The same arm, with a push of limited duration.
    #[must_use]
    pub fn with_push(self, push: Option<Push>) -> Self {
        let always = self.body.mechanism.tip_wrench();
        Self { push: push.map(|push| (always, push)), ..self }
    }

    /// The same arm at the same position, with springs between its rotors and links, measured on one side of them. Every rotor needs an inertia above
    /// zero. Friction, if there is any, acts on the rotors.
    #[must_use]
    pub fn with_elasticity(mut self, springs: Elasticity<N>, side: Side) -> Self {
        self.motors = Some(Motors::new(springs, &mut self.body.mechanism, &self.state, side));
        self
    }

    /// The same arm, with the coupling between the spin of its rotors and the links that carry them.
    #[must_use]
    pub fn with_rotor_coupling(mut self, joints: &[JointSpec; N]) -> Self {
        self.body.mechanism = self.body.mechanism.with_rotor_coupling(joints);
        self
    }

    /// The same arm with jitter: `sampling` moves the measurement to before the tick, and `acting` moves the start of the torque to after the start
    /// of the tick.
    #[must_use]
    pub fn with_jitter(self, sampling: Option<Jitter>, acting: Option<Jitter>) -> Self {
        Self { sampling, acting, ..self }
    }

    /// Starts a ledger of work from now on. With a wrench at the tip, the ledger computes the terms of two more states per step. It excludes the
    /// energy in springs: an elastic arm's ledger stays empty.
    pub fn start_ledger(&mut self) {
        self.ledger = Some(Ledger::new(self.state));
    }

    /// Energy ledger of the arm, if [`Plant::start_ledger`] was called.
    #[must_use]
    pub fn ledger(&self) -> Option<&Ledger<N>> {
        self.ledger.as_ref()
    }

    /// Number of solutions of the equations of motion: the cost of the integration.
    #[must_use]
    pub fn accelerations(&self) -> u64 {
        self.body.solutions()
    }

    /// Makes the next step compile the equations of motion, which a run does after a thousand solutions and which takes some milliseconds. For an arm in
    /// the time of the clock.
    pub fn compile_next(&self) {
        self.body.compile_next();
    }

    /// Current state of the arm; for elastic joints, of their link sides.
    #[must_use]
    pub fn state(&self) -> &State<N> {
        &self.state
    }

    /// Current state of the motor sides of elastic joints.
    #[must_use]
    pub fn motors(&self) -> Option<&State<N>> {
        self.motors.as_ref().map(|motors| &motors.state)
    }

    /// State seen by the sensors in this tick, on their side of the joints and at their sampling instant.
    #[must_use]
    pub fn measured(&self) -> &State<N> {
        self.sampled.as_ref().unwrap_or_else(|| self.seen())
    }

    /// Current state of the side that the sensors measure.
    fn seen(&self) -> &State<N> {
        match &self.motors {
            Some(Motors { state, side: Side::Motor, .. }) => state,
            _ => &self.state,
        }
    }
}
