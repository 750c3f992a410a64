//! The simulated arm: f64, an algorithm of its own, fourth-order Runge-Kutta.
//!
//! | module | holds |
//! |---|---|
//! | [`dynamics`] | equations of motion by moving bodies in base axes |
//! | [`friction`] | viscous, Coulomb and Stribeck friction |
//! | [`actuator`] | delay, saturation, lag and ripple of the torque |
//! | [`sensor`] | noise, encoder counts and delay of the measurement |
//! | [`ledger`] | what has put energy into the arm and taken it out |

pub mod actuator;
#[cfg(test)]
mod calls;
pub mod dynamics;
pub mod friction;
mod kinematics;
pub mod ledger;
pub mod sensor;
#[cfg(test)]
mod tests;

use actuator::{ActuatorSettings, Actuators, Drive, Ripple};
pub use dynamics::Arm;
use dynamics::Mechanism;
use dynamics_core::JointKind;
use dynamics_core::trig::Polynomial;
pub use friction::JointFriction;
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
}

/// How time is cut up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Control period, s.
    pub period: f64,
    /// Runge-Kutta steps in a period.
    pub steps_per_tick: u32,
}

impl Clock {
    /// Length of one Runge-Kutta step, s.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.period / f64::from(self.steps_per_tick)
    }
}

/// The simulated arm with its actuators and brakes.
///
/// Brakes are stronger than the arm: from the tick in which they engage every joint loses its speed at a constant rate
/// within [`BRAKING_TIME`] and then stands, whatever pulls at it.
#[derive(Clone, Debug)]
pub struct Plant<const N: usize> {
    mechanism: Mechanism<N>,
    friction: Option<[JointFriction; N]>,
    actuators: Actuators<N>,
    ripple: Option<Ripple>,
    kinds: [JointKind; N],
    clock: Clock,
    state: State<N>,
    brake: Option<Braking<N>>,
    ledger: Option<Ledger<N>>,
}

/// Time in which the brakes bring the arm to rest, s.
pub const BRAKING_TIME: f64 = 0.1;

#[derive(Clone, Debug)]
struct Braking<const N: usize> {
    from: State<N>,
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
        let actuators = Actuators::new(actuators, torque_max);
        Self {
            mechanism: arm.mechanism(),
            friction,
            actuators,
            ripple,
            kinds: core::array::from_fn(|i| arm.joints[i].kind),
            clock,
            state: State { q: start, qd: [0.0; N] },
            brake: None,
            ledger: None,
        }
    }

    /// The same arm, with a ledger from now on; where something pushes at the tip, it costs the terms of two
    /// more states a step.
    #[must_use]
    pub fn with_ledger(self) -> Self {
        Self { ledger: Some(Ledger::new(self.state)), ..self }
    }

    /// Where the energy came from and went, if that was asked for.
    #[must_use]
    pub fn ledger(&self) -> Option<&Ledger<N>> {
        self.ledger.as_ref()
    }

    /// Where the arm is now.
    #[must_use]
    pub fn state(&self) -> &State<N> {
        &self.state
    }

    /// Let one control period pass with this torque command held (before the actuators' own effects).
    ///
    /// # Errors
    /// [`Diverged`] when the motion cannot be continued; the state is then the last good one.
    pub fn drive(&mut self, torque: &[f64; N]) -> Result<(), Diverged> {
        let drive = self.actuators.drive(torque, self.clock.period);
        let h = self.clock.step();
        for step in 0..self.clock.steps_per_tick {
            let t = f64::from(step) * h;
            let next = self.runge_kutta(&drive, t, h)?;
            let acting = |t: f64, state: &State<N>| self.acting(&drive.at(t), state);
            let ends =
                self.ledger.is_some().then(|| [(acting(t, &self.state), self.state), (acting(t + h, &next), next)]);
            if let (Some(ledger), Some(ends)) = (&mut self.ledger, ends) {
                ledger.step(h, &ends, self.friction.as_ref(), &self.mechanism);
            }
            self.state = next;
        }
        Ok(())
    }

    /// Let one control period pass with the drives released and the brakes engaged.
    pub fn brake(&mut self) {
        let brake = self.brake.get_or_insert(Braking { from: self.state, ticks: 0 });
        brake.ticks += 1;
        let t = (f64::from(brake.ticks) * self.clock.period).min(BRAKING_TIME);
        let left = 1.0 - t / BRAKING_TIME;
        self.state.q = core::array::from_fn(|i| brake.from.q[i] + brake.from.qd[i] * t * (1.0 + left) / 2.0);
        self.state.qd = brake.from.qd.map(|qd| qd * left);
    }

    /// One classical fourth-order step from `t` (s into the tick).
    fn runge_kutta(&self, drive: &Drive<N>, t: f64, h: f64) -> Result<State<N>, Diverged> {
        let start = self.state;
        let middle = drive.at(t + h / 2.0);
        let k1 = self.slope(&start, &drive.at(t))?;
        let k2 = self.slope(&along(&start, &k1, h / 2.0), &middle)?;
        let k3 = self.slope(&along(&start, &k2, h / 2.0), &middle)?;
        let k4 = self.slope(&along(&start, &k3, h), &drive.at(t + h))?;
        let mix = |x: [f64; 4]| (x[0] + 2.0 * (x[1] + x[2]) + x[3]) * (h / 6.0);
        let next = State {
            q: core::array::from_fn(|i| start.q[i] + mix([k1.q[i], k2.q[i], k3.q[i], k4.q[i]])),
            qd: core::array::from_fn(|i| start.qd[i] + mix([k1.qd[i], k2.qd[i], k3.qd[i], k4.qd[i]])),
        };
        if next.q.iter().chain(&next.qd).all(|x| x.is_finite()) { Ok(next) } else { Err(Diverged::NotFinite) }
    }

    /// The actuators' torques as the joints feel them at this state.
    fn acting(&self, torque: &[f64; N], state: &State<N>) -> [f64; N] {
        self.ripple.map_or(*torque, |ripple| ripple.acting(&self.kinds, torque, &state.q))
    }

    /// `(qd, qdd)`: how the state changes.
    fn slope(&self, state: &State<N>, torque: &[f64; N]) -> Result<State<N>, Diverged> {
        let mut torque = self.acting(torque, state);
        if let Some(friction) = &self.friction {
            for i in 0..N {
                torque[i] -= friction[i].torque_under(torque[i], state.qd[i]);
            }
        }
        let within = |q: &f64| q.abs() <= Polynomial::LIMIT_F64;
        if !(state.q.iter().all(within) && state.qd.iter().all(|x| x.is_finite())) {
            return Err(Diverged::NotFinite);
        }
        let qdd = self.mechanism.acceleration(&state.q, &state.qd, &torque).ok_or(Diverged::SingularInertia)?;
        Ok(State { q: state.qd, qd: qdd })
    }
}

/// `start + slope * h`.
fn along<const N: usize>(start: &State<N>, slope: &State<N>, h: f64) -> State<N> {
    State {
        q: core::array::from_fn(|i| start.q[i] + slope.q[i] * h),
        qd: core::array::from_fn(|i| start.qd[i] + slope.qd[i] * h),
    }
}
