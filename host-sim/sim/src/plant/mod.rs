//! The simulated arm: f64, with its own algorithm.
//!
//! | module | holds |
//! |---|---|
//! | `state` | states of one arm, or of several side by side |
//! | `flow` | their differential equation, with dry friction in it |
//! | [`dynamics`] | equations of motion by moving bodies in base axes |
//! | `acted` | an arm with friction and ripple: its accelerations under torques |
//! | `arm_kernel` | the equations of motion in machine code, for one arm or for several side by side |
//! | `arm_lanes` | friction, ripple and torque curves of these arms; they pass their time together |
//! | [`integrator`] | fourth-order Runge-Kutta, semi-implicit Euler, an adaptive pair |
//! | [`elasticity`] | motor and link sides of elastic joints, play between them |
//! | `factors` | solution of the equations of motion, with joints that are held |
//! | [`friction`] | viscous, Coulomb and Stribeck friction |
//! | `stiction` | which joints slide and which friction holds, and when that changes |
//! | `curve` | interpolant of a step, from which that instant is taken |
//! | [`actuator`] | delay, saturation, lag and ripple of an ideal drive's torque |
//! | [`drives`] | simulated drives: the board's own code before three CAN buses, an actuator at every joint |
//! | [`jitter`] | random offsets of the instants of measuring and acting |
//! | [`sensor`] | noise, encoder counts and delay of the measurement |
//! | `solver` | who lets the arm move while a run waits |
//! | [`ledger`] | energy put into the arm and taken out of it |

pub mod actuator;
pub(crate) mod arm_kernel;
pub(crate) mod arm_lanes;
#[cfg(test)]
mod calls;
mod curve;
pub mod drives;
pub mod dynamics;
pub mod elasticity;
mod factors;
mod flow;
pub mod friction;
pub mod integrator;
pub mod jitter;
mod kinematics;
pub mod ledger;
mod loaded_arm;
mod rotor_coupling;
pub mod sensor;
pub(crate) mod solver;
mod state;
mod stiction;
mod terms;
#[cfg(test)]
mod tests;

use actuator::{ActuatorSettings, Actuators, Drive};
pub use dynamics::Arm;
use dynamics_core::{JointSpec, Wrench};
use elasticity::{BothSides, Elasticity, Motors};
pub use friction::JointFriction;
use integrator::{Plan, Stretch};
use jitter::Jitter;
use ledger::Ledger;
pub(crate) use loaded_arm::LoadedArm;
use loaded_arm::{Elastic, Rigid};
use robot_compiler::scene::{Integrator, Push, Side};
use solver::{AtOnce, IntegrationRequest, Solver, now};
use state::States;
pub use state::{Diverged, State};

/// Division of time into ticks and steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Control period, s.
    pub period: f64,
    /// Steps of the integration in a period; the adaptive integrator makes its own.
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
/// Brakes are stronger than the arm. From the tick in which they engage, every joint loses its speed at a constant rate
/// within [`BRAKING_TIME`] and then stands, under any load. In an elastic joint both sides do so.
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
    /// Ticks that have begun, whether drives, brakes or nothing acted: the one clock of [`Push`].
    ticks: u64,
    motors: Option<Motors<N>>,
    sampling: Option<Jitter>,
    acting: Option<Jitter>,
    /// The state that the sensors sampled, if they sample at another instant than now.
    sampled: Option<State<N>>,
    brake: Option<Braking<N>>,
    ledger: Option<Ledger<N>>,
}

/// Time in which the brakes bring the arm to rest, s.
pub const BRAKING_TIME: f64 = 0.1;

#[derive(Clone, Debug)]
struct Braking<const N: usize> {
    from: State<N>,
    motor_from: Option<State<N>>,
    ticks: u32,
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

    /// Set the wrench at the tip for the tick that begins.
    fn begin_tick(&mut self) {
        let now = self.ticks;
        self.ticks += 1;
        let Some((always, Push { at, duration, wrench })) = self.push else { return };
        let tick = |t: f64| (t / self.clock.period).round() as u64;
        let pushes = (tick(at)..tick(at + duration)).contains(&now);
        let both = || always.map_or(wrench, |always| always + wrench);
        self.body.mechanism.push(if pushes { Some(both()) } else { always });
    }

    /// The same arm at the same position, with its rotors behind springs, and measured on one side of them. Every rotor
    /// needs an inertia. Friction, if there is any, acts on the rotors.
    #[must_use]
    pub fn with_elasticity(mut self, springs: Elasticity<N>, side: Side) -> Self {
        self.motors = Some(Motors::new(springs, &mut self.body.mechanism, &self.state, side));
        self
    }

    /// The same arm, with the coupling of its rotors' spin with the links that carry them.
    #[must_use]
    pub fn with_rotor_coupling(mut self, joints: &[JointSpec; N]) -> Self {
        self.body.mechanism = self.body.mechanism.with_rotor_coupling(joints);
        self
    }

    /// The same arm with jitter: `sampling` moves the measurement to before the tick, and `acting` moves the torque's
    /// start to after it.
    #[must_use]
    pub fn with_jitter(self, sampling: Option<Jitter>, acting: Option<Jitter>) -> Self {
        Self { sampling, acting, ..self }
    }

    /// Starts a ledger of work from now on. With a wrench at the tip, the ledger costs the terms of two more states
    /// a step. It excludes energy in springs: an elastic arm's ledger stays empty.
    pub fn start_ledger(&mut self) {
        self.ledger = Some(Ledger::new(self.state));
    }

    /// Energy ledger of the arm, if [`Plant::start_ledger`] asked for it.
    #[must_use]
    pub fn ledger(&self) -> Option<&Ledger<N>> {
        self.ledger.as_ref()
    }

    /// Number of solutions of the equations of motion: the cost of the integration.
    #[must_use]
    pub fn accelerations(&self) -> u64 {
        self.body.solutions()
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

    /// Current state of the side that the sensors are on.
    fn seen(&self) -> &State<N> {
        match &self.motors {
            Some(Motors { state, side: Side::Motor, .. }) => state,
            _ => &self.state,
        }
    }

    /// Simulate one control period with this torque command held (before the actuators' own effects), and the brakes
    /// released.
    ///
    /// # Errors
    /// [`Diverged`] if the motion cannot be continued; the state is then the last good one.
    pub fn drive(&mut self, torque: &[f64; N]) -> Result<(), Diverged> {
        now(self.drive_with(&AtOnce, torque))
    }

    /// As [`Plant::drive`], with this solver.
    pub(crate) async fn drive_with(&mut self, solver: &impl Solver<N>, torque: &[f64; N]) -> Result<(), Diverged> {
        self.begin_tick();
        if self.brake.take().is_some() {
            self.actuators.released();
        }
        let Clock { period, steps_per_tick } = self.clock;
        let (acts, samples) = (self.acts(), self.samples());
        let (before, drive) = self.actuators.drive(torque, period, acts.unwrap_or(0.0));
        if acts.is_none() && samples.is_none() {
            return self.pass(solver, &drive, Stretch { from: 0.0, to: period, steps: steps_per_tick }).await;
        }
        let acts = acts.unwrap_or(0.0);
        let mut from = 0.0;
        let mut events = [(acts, false), (samples.unwrap_or(period), samples.is_some()), (period, false)];
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (to, sample) in events {
            if to > from {
                // A part of a step counts as a step; a rounding error does not.
                let steps = libm::ceil((to - from) / self.clock.step() - 1e-9).max(1.0) as u32;
                self.pass(solver, if from < acts { &before } else { &drive }, Stretch { from, to, steps }).await?;
                from = to;
            }
            if sample {
                self.sampled = Some(*self.seen());
            }
        }
        Ok(())
    }

    /// Simulates one control period under drives that renew their torque so many `times` in it: `renew` gives it from the
    /// state that the drives feel, and for how long (s). The brakes are released.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub fn drive_renewed(&mut self, times: u32, renew: impl FnMut(&State<N>, f64) -> [f64; N]) -> Result<(), Diverged> {
        now(self.drive_by(&AtOnce, times, renew))
    }

    /// As [`Plant::drive_renewed`], with this solver.
    ///
    /// # Errors
    /// As [`Plant::drive`].
    pub(crate) async fn drive_by(
        &mut self,
        solver: &impl Solver<N>,
        times: u32,
        mut renew: impl FnMut(&State<N>, f64) -> [f64; N],
    ) -> Result<(), Diverged> {
        self.begin_tick();
        if self.brake.take().is_some() {
            self.actuators.released();
        }
        let Clock { period, steps_per_tick } = self.clock;
        let instant = |turn: u32| period * f64::from(turn) / f64::from(times);
        for turn in 0..times {
            let (from, to) = (instant(turn), instant(turn + 1));
            let torque = renew(self.seen(), to - from);
            // The curve is in the time of the last tick only once.
            let (_, drive) = self.actuators.drive(&torque, if turn == 0 { period } else { 0.0 }, from);
            self.pass(solver, &drive, Stretch { from, to, steps: steps_per_tick.div_ceil(times) }).await?;
        }
        Ok(())
    }

    /// As [`Plant::drive_by`], outside the ledger: the drives stop the arm.
    pub(crate) async fn stop_by(
        &mut self,
        solver: &impl Solver<N>,
        times: u32,
        renew: impl FnMut(&State<N>, f64) -> [f64; N],
    ) -> Result<(), Diverged> {
        let ledger = self.ledger.take();
        let passed = self.drive_by(solver, times, renew).await;
        self.ledger = ledger;
        passed
    }

    /// The instant at which a new torque takes effect, s into the tick.
    fn acts(&mut self) -> Option<f64> {
        let jitter = self.acting.as_mut()?;
        #[cfg(test)]
        calls::count(calls::Effect::ActuatorJitter);
        Some(jitter.draw())
    }

    /// The instant of the next tick's measurement, s into this one.
    fn samples(&mut self) -> Option<f64> {
        let jitter = self.sampling.as_mut()?;
        #[cfg(test)]
        calls::count(calls::Effect::SensorJitter);
        Some(self.clock.period - jitter.draw())
    }

    /// Simulate a part of a tick.
    async fn pass(&mut self, solver: &impl Solver<N>, drive: &Drive<N>, stretch: Stretch) -> Result<(), Diverged> {
        let Self { body, integrator, next_step, state, motors, ledger, .. } = self;
        let plan = Plan { integrator: *integrator, stretch, next: *next_step };
        if let Some(motors) = motors {
            let mut pair = BothSides { link: States::alone(state), motor: States::alone(&motors.state) };
            let (flow, mut plans) = (Elastic { body, motors: &*motors, drive }, [Some(plan)]);
            let [failed] = integrator::advance(&flow, &mut pair, &mut plans, |_| ());
            (*state, motors.state) = (pair.link.lane(0), pair.motor.lane(0));
            *next_step = plans[0].map_or(*next_step, |plan| plan.next);
            return failed.map_or(Ok(()), Err);
        }
        let mut passage = IntegrationRequest { state: *state, drive: *drive, plan };
        let passed = solver.pass(body, ledger.as_mut(), &mut passage).await;
        (*state, *next_step) = (passage.state, passage.plan.next);
        passed
    }

    /// Simulate one control period with the drives released and the brakes engaged. The arm brakes from its state at
    /// the first such call, until it is driven again.
    pub fn brake(&mut self) {
        self.begin_tick();
        let (from, motor_from) = (self.state, self.motors().copied());
        let brake = self.brake.get_or_insert(Braking { from, motor_from, ticks: 0 });
        let begin = f64::from(brake.ticks) * self.clock.period;
        brake.ticks += 1;
        let end = f64::from(brake.ticks) * self.clock.period;
        if let Some(samples) = self.samples() {
            self.slow_down(begin + samples);
            self.sampled = Some(*self.seen());
        }
        self.slow_down(end);
    }

    /// Set the state at `t` (s) after the brakes have engaged.
    fn slow_down(&mut self, t: f64) {
        let Some(brake) = &self.brake else {
            return;
        };
        self.state = braked(&brake.from, t);
        if let (Some(motors), Some(from)) = (&mut self.motors, &brake.motor_from) {
            motors.state = braked(from, t);
        }
    }
}

/// State at `t` (s) after the brakes have engaged.
fn braked<const N: usize>(from: &State<N>, t: f64) -> State<N> {
    let t = t.min(BRAKING_TIME);
    let left = 1.0 - t / BRAKING_TIME;
    State {
        q: core::array::from_fn(|i| from.q[i] + from.qd[i] * t * (1.0 + left) / 2.0),
        qd: from.qd.map(|qd| qd * left),
    }
}
