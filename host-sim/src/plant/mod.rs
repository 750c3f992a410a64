//! The simulated arm: f64, an algorithm of its own.
//!
//! | module | holds |
//! |---|---|
//! | [`dynamics`] | equations of motion by moving bodies in base axes |
//! | [`integrator`] | fourth-order Runge-Kutta, semi-implicit Euler, an adaptive pair |
//! | [`elasticity`] | motor and link sides of elastic joints, play between them |
//! | [`friction`] | viscous, Coulomb and Stribeck friction |
//! | [`actuator`] | delay, saturation, lag and ripple of the torque |
//! | [`jitter`] | instants of measuring and acting that wander |
//! | [`sensor`] | noise, encoder counts and delay of the measurement |
//! | [`ledger`] | what has put energy into the arm and taken it out |

pub mod actuator;
#[cfg(test)]
mod calls;
pub mod dynamics;
pub mod elasticity;
pub mod friction;
pub mod integrator;
pub mod jitter;
mod kinematics;
pub mod ledger;
pub mod sensor;
#[cfg(test)]
mod tests;

use actuator::{ActuatorSettings, Actuators, Drive, Ripple};
use core::cell::Cell;
pub use dynamics::Arm;
use dynamics::Mechanism;
use dynamics_core::trig::Polynomial;
use dynamics_core::{JointKind, Wrench};
use elasticity::{Elasticity, Motors, Pair};
pub use friction::JointFriction;
pub use integrator::Integrator;
use integrator::{Flow, Step, Stretch};
use jitter::Jitter;
use ledger::Ledger;

/// Position and velocity of every joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize> {
    /// Joint position, rad or m.
    pub q: [f64; N],
    /// Joint velocity, rad/s or m/s.
    pub qd: [f64; N],
}

/// The arm could not be simulated further.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Diverged {
    /// The joint-space inertia matrix has a pivot that is not above zero.
    #[error("the plant's inertia matrix is not positive definite: a joint moves no mass")]
    SingularInertia,
    /// A position or velocity has become infinite or NaN, or a position so large that it has no sine.
    #[error("the plant's motion has grown beyond all bounds: the loop is unstable, or the step too long")]
    NotFinite,
    /// The adaptive integrator has cut a tick into a hundred thousand steps and is not at its end.
    #[error("the plant's integrator cannot keep its tolerance: something acts too suddenly or too fast")]
    ToleranceOutOfReach,
}

/// Which side of an elastic joint is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// The motor's, behind its gear, as the joint has it: where most arms have their encoders.
    #[default]
    Motor,
    /// The link's.
    Link,
}

/// How time is cut up.
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

/// A wrench at the tip for a while, beside what pushes all the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// When it begins, s: with the tick that is nearest.
    pub at: f64,
    /// How long it lasts, s: whole ticks.
    pub duration: f64,
    /// At the tip's origin, in tip axes.
    pub wrench: Wrench<f64>,
}

/// The simulated arm with its actuators and brakes.
///
/// Brakes are stronger than the arm: from the tick in which they engage every joint loses its speed at a constant rate
/// within [`BRAKING_TIME`] and then stands, whatever pulls at it; of an elastic joint both sides do.
#[derive(Clone, Debug)]
pub struct Plant<const N: usize> {
    body: Acted<N>,
    actuators: Actuators<N>,
    clock: Clock,
    integrator: Integrator,
    /// Next step of the adaptive integrator, s.
    next_step: f64,
    state: State<N>,
    /// What pushes all the time, and what does so for a while.
    push: Option<(Option<Wrench<f64>>, Push)>,
    /// Ticks driven.
    driven: u64,
    motors: Option<Motors<N>>,
    sampling: Option<Jitter>,
    acting: Option<Jitter>,
    /// What the sensors saw where that was not now.
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

/// The arm's bodies and what acts on them, but for the torque.
#[derive(Clone, Debug)]
struct Acted<const N: usize> {
    mechanism: Mechanism<N>,
    friction: Option<[JointFriction; N]>,
    ripple: Option<Ripple>,
    kinds: [JointKind; N],
    /// How often the equations of motion were solved.
    solved: Cell<u64>,
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
            body: Acted { mechanism: arm.mechanism(), friction, ripple, kinds, solved: Cell::new(0) },
            actuators: Actuators::new(actuators, torque_max),
            clock,
            integrator: Integrator::default(),
            next_step: clock.period,
            state: State { q: start, qd: [0.0; N] },
            push: None,
            driven: 0,
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

    /// The same arm, pushed for a while.
    #[must_use]
    pub fn with_push(self, push: Option<Push>) -> Self {
        let always = self.body.mechanism.tip_wrench();
        Self { push: push.map(|push| (always, push)), ..self }
    }

    /// What pushes in the tick that begins.
    fn begin_tick(&mut self) {
        let Some((always, Push { at, duration, wrench })) = self.push else { return };
        let tick = |t: f64| (t / self.clock.period).round() as u64;
        let pushes = (tick(at)..tick(at + duration)).contains(&self.driven);
        self.driven += 1;
        let both = || always.map_or(wrench, |always| always + wrench);
        self.body.mechanism.push(if pushes { Some(both()) } else { always });
    }

    /// The same arm, standing where it did, with its rotors behind springs and measured on one side of them. Every rotor needs an
    /// inertia. Friction, if there is any, is that of the rotors: [`JointFriction::on_motors`].
    #[must_use]
    pub fn with_elasticity(mut self, springs: Elasticity<N>, side: Side) -> Self {
        self.motors = Some(Motors::new(springs, &mut self.body.mechanism, &self.state, side));
        self
    }

    /// The same arm, measured at an instant that `sampling` moves to before the tick, and driven from one on that `acting` moves to
    /// after it.
    #[must_use]
    pub fn with_jitter(self, sampling: Option<Jitter>, acting: Option<Jitter>) -> Self {
        Self { sampling, acting, ..self }
    }

    /// The same arm, with a ledger from now on; where something pushes at the tip, it costs the terms of two
    /// more states a step. Energy in springs is not in it: an elastic arm's ledger stays empty.
    #[must_use]
    pub fn with_ledger(self) -> Self {
        Self { ledger: Some(Ledger::new(self.state)), ..self }
    }

    /// Where the energy came from and went, if that was asked for.
    #[must_use]
    pub fn ledger(&self) -> Option<&Ledger<N>> {
        self.ledger.as_ref()
    }

    /// How often its equations of motion have been solved: what an integrator's step costs.
    #[must_use]
    pub fn accelerations(&self) -> u64 {
        self.body.solved.get()
    }

    /// Where the arm is now; of elastic joints, their link sides.
    #[must_use]
    pub fn state(&self) -> &State<N> {
        &self.state
    }

    /// Where the motor sides of elastic joints are now.
    #[must_use]
    pub fn motors(&self) -> Option<&State<N>> {
        self.motors.as_ref().map(|motors| &motors.state)
    }

    /// What the sensors of this tick see: the side that they are on, at the instant at which they look.
    #[must_use]
    pub fn measured(&self) -> &State<N> {
        self.sampled.as_ref().unwrap_or_else(|| self.seen())
    }

    /// The side that the sensors are on, now.
    fn seen(&self) -> &State<N> {
        match &self.motors {
            Some(Motors { state, side: Side::Motor, .. }) => state,
            _ => &self.state,
        }
    }

    /// Let one control period pass with this torque command held (before the actuators' own effects), and the brakes released.
    ///
    /// # Errors
    /// [`Diverged`] when the motion cannot be continued; the state is then the last good one.
    pub fn drive(&mut self, torque: &[f64; N]) -> Result<(), Diverged> {
        self.begin_tick();
        if self.brake.take().is_some() {
            self.actuators.released();
        }
        let Clock { period, steps_per_tick } = self.clock;
        let (acts, samples) = (self.acts(), self.samples());
        let (before, drive) = self.actuators.drive(torque, period, acts.unwrap_or(0.0));
        if acts.is_none() && samples.is_none() {
            return self.pass(&drive, Stretch { from: 0.0, to: period, steps: steps_per_tick });
        }
        let acts = acts.unwrap_or(0.0);
        let mut from = 0.0;
        let mut events = [(acts, false), (samples.unwrap_or(period), samples.is_some()), (period, false)];
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (to, sample) in events {
            if to > from {
                // A part of a step is a step; a rounding error is none.
                let steps = libm::ceil((to - from) / self.clock.step() - 1e-9).max(1.0) as u32;
                self.pass(if from < acts { &before } else { &drive }, Stretch { from, to, steps })?;
                from = to;
            }
            if sample {
                self.sampled = Some(*self.seen());
            }
        }
        Ok(())
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

    /// Let a part of a tick pass.
    fn pass(&mut self, drive: &Drive<N>, stretch: Stretch) -> Result<(), Diverged> {
        let Self { body, integrator, next_step, state, motors, ledger, .. } = self;
        if let Some(motors) = motors {
            let mut pair = Pair { link: *state, motor: motors.state };
            let flow = Elastic { body, motors: &*motors, drive };
            let passed = integrator.advance(&flow, &mut pair, stretch, next_step, |_| ());
            (*state, motors.state) = (pair.link, pair.motor);
            return passed;
        }
        integrator.advance(&Rigid { body, drive }, state, stretch, next_step, |step| {
            if let Some(ledger) = ledger {
                let Step { t, h, before, after } = *step;
                let ends = [(t, before), (t + h, after)].map(|(t, s)| (body.acting(&drive.at(t), s), *s));
                ledger.step(h, &ends, body.friction.as_ref(), &body.mechanism);
            }
        })
    }

    /// Let one control period pass with the drives released and the brakes engaged, from where the arm is until it is driven again.
    pub fn brake(&mut self) {
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

    /// To where the arm is `t` (s) after the brakes have engaged.
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

/// A motion `t` (s) after the brakes have engaged.
fn braked<const N: usize>(from: &State<N>, t: f64) -> State<N> {
    let t = t.min(BRAKING_TIME);
    let left = 1.0 - t / BRAKING_TIME;
    State {
        q: core::array::from_fn(|i| from.q[i] + from.qd[i] * t * (1.0 + left) / 2.0),
        qd: from.qd.map(|qd| qd * left),
    }
}

impl<const N: usize> Acted<N> {
    /// The actuators' torques as the joints, or their motors, feel them at this state.
    fn acting(&self, torque: &[f64; N], state: &State<N>) -> [f64; N] {
        self.ripple.map_or(*torque, |ripple| ripple.acting(&self.kinds, torque, &state.q))
    }

    /// The same less friction.
    fn driving(&self, torque: &[f64; N], state: &State<N>) -> [f64; N] {
        let mut torque = self.acting(torque, state);
        if let Some(friction) = &self.friction {
            for i in 0..N {
                torque[i] -= friction[i].torque_under(torque[i], state.qd[i]);
            }
        }
        torque
    }

    /// `(qd, qdd)` under these torques.
    fn moved(&self, state: &State<N>, torque: &[f64; N]) -> Result<State<N>, Diverged> {
        let within = |q: &f64| q.abs() <= Polynomial::LIMIT_F64;
        if !(state.q.iter().all(within) && state.qd.iter().all(|x| x.is_finite())) {
            return Err(Diverged::NotFinite);
        }
        self.solved.set(self.solved.get() + 1);
        let qdd = self.mechanism.acceleration(&state.q, &state.qd, torque).ok_or(Diverged::SingularInertia)?;
        Ok(State { q: state.qd, qd: qdd })
    }
}

/// Joints that follow their motors.
struct Rigid<'a, const N: usize> {
    body: &'a Acted<N>,
    drive: &'a Drive<N>,
}

impl<const N: usize> Flow<State<N>> for Rigid<'_, N> {
    type Input = [f64; N];

    fn input(&self, t: f64) -> [f64; N] {
        self.drive.at(t)
    }

    fn slope(&self, state: &State<N>, torque: &[f64; N]) -> Result<State<N>, Diverged> {
        self.body.moved(state, &self.body.driving(torque, state))
    }
}

/// Joints with springs in them.
struct Elastic<'a, const N: usize> {
    body: &'a Acted<N>,
    motors: &'a Motors<N>,
    drive: &'a Drive<N>,
}

impl<const N: usize> Flow<Pair<N>> for Elastic<'_, N> {
    type Input = [f64; N];

    fn input(&self, t: f64) -> [f64; N] {
        self.drive.at(t)
    }

    fn slope(&self, pair: &Pair<N>, torque: &[f64; N]) -> Result<Pair<N>, Diverged> {
        let driving = self.body.driving(torque, &pair.motor);
        let carried = self.motors.springs.torques(&pair.motor, &pair.link);
        let link = self.body.moved(&pair.link, &carried)?;
        let qdd = core::array::from_fn(|i| (driving[i] - carried[i]) / self.motors.inertia[i]);
        Ok(Pair { link, motor: State { q: pair.motor.qd, qd: qdd } })
    }
}
