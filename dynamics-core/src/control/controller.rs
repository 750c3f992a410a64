//! The tick.

use super::friction::Friction;
use super::law::{Gains, Law, State, torques};
use super::limits::{LimitFlags, hold_reference, hold_torque, reference_is_inside, torque_is_inside};
use super::observer::{Encoder, TrackingObserver};
use super::{Command, Fault, Measurement, Reference, Sensed};
use crate::joint::Limits;
use crate::newton_euler::InverseDynamics;
use crate::scalar::Real;
use crate::scene::Live;
use crate::trig::Trig;

/// When a measurement is no longer believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guard<S> {
    /// How far beyond a position limit a joint may be before it is a fault, rad or m.
    pub position_margin: S,
    /// Speed at which it is a fault, rad/s or m/s.
    pub velocity_max: S,
}

/// Everything about the controller that does not change while it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerConfig<S, const N: usize> {
    /// The control law.
    pub law: Law,
    /// Gains per joint.
    pub gains: [Gains<S>; N],
    /// Friction to make up for, per joint; `None` leaves it to the feedback.
    pub friction: Option<[Friction<S>; N]>,
    /// Limits per joint.
    pub limits: [Limits<S>; N],
    /// Greatest change of torque in one tick, N m or N: the torque-rate limit times the period.
    pub torque_step: [S; N],
    /// When a measurement is a fault, per joint.
    pub guard: [Guard<S>; N],
    /// Oldest measurement that is believed, in ticks.
    pub age_max: u32,
    /// Encoder scale per joint.
    pub encoder: [Encoder<S>; N],
    /// Velocity from counts.
    pub observer: TrackingObserver<S>,
}

impl<const N: usize> ControllerConfig<f64, N> {
    /// The same configuration in another scalar, each number through [`crate::Scalar::literal`].
    #[must_use]
    pub fn cast<T: Real>(&self) -> ControllerConfig<T, N> {
        let t = T::literal;
        ControllerConfig {
            law: self.law,
            gains: self.gains.map(|g| Gains {
                position: t(g.position),
                velocity: t(g.velocity),
                inertia: t(g.inertia),
            }),
            friction: self.friction.map(|all| {
                all.map(|f| Friction {
                    viscous: t(f.viscous),
                    coulomb: t(f.coulomb),
                    per_smoothing_speed: t(f.per_smoothing_speed),
                })
            }),
            limits: self.limits.map(|l| l.cast()),
            torque_step: self.torque_step.map(t),
            guard: self.guard.map(|g| Guard { position_margin: t(g.position_margin), velocity_max: t(g.velocity_max) }),
            age_max: self.age_max,
            encoder: self.encoder.map(|e| Encoder { zero: e.zero, per_count: t(e.per_count) }),
            observer: {
                let [period, half, g, k] = self.observer.gains().map(t);
                TrackingObserver::from_gains(period, half, g, k)
            },
        }
    }
}

/// What changes from tick to tick.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Memory<S, const N: usize> {
    /// The observer's position and velocity, once there was a first reading.
    estimate: Option<([S; N], [S; N])>,
    /// Acceleration that the last reference asked for.
    acceleration: [S; N],
    /// The last commanded torque.
    torque: Option<[S; N]>,
    /// The fault in force.
    fault: Option<Fault>,
}

/// Computed-torque controller of an arm with `N` joints.
///
/// Generic over the inverse dynamics (the recursion or a generated kernel) and over sine and cosine; it cannot tell one
/// kernel from another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller<S, const N: usize, D, T> {
    config: ControllerConfig<S, N>,
    dynamics: D,
    trig: T,
    live: Live<S, N>,
    memory: Memory<S, N>,
}

impl<S: Real, const N: usize, D: InverseDynamics<S, N>, T: Trig<S>> Controller<S, N, D, T> {
    /// A controller at rest, with every live input zero.
    #[must_use]
    pub fn new(config: ControllerConfig<S, N>, dynamics: D, trig: T) -> Self {
        Self { config, dynamics, trig, live: Live::zero(), memory: Memory::new() }
    }

    /// One tick: from what should be and what is to what to do. Total: it neither panics nor fails.
    ///
    /// Cost: one inverse dynamics, `N` pairs of sine and cosine, and for six joints about 860 instructions of a Cortex-M4F
    /// beside them (`docs/timing.md`).
    #[inline]
    pub fn tick(&mut self, reference: &Reference<S, N>, measurement: &Measurement<S, N>) -> Command<S, N> {
        let fault = match self.memory.fault {
            Some(fault) => fault,
            None => match self.drive(reference, measurement) {
                Ok(command) => return command,
                Err(fault) => fault,
            },
        };
        self.memory.fault = Some(fault);
        Command::Brake(fault)
    }

    /// Tell the controller that a tick had not ended when the next was due.
    pub fn overrun(&mut self) {
        self.memory.fault.get_or_insert(Fault::Overrun);
    }

    /// Tell the controller that measurements have stopped coming.
    pub fn measurement_lost(&mut self) {
        self.memory.fault.get_or_insert(Fault::StaleMeasurement);
    }

    /// Forget the fault, the observer's estimate and the last torque: the brakes have held meanwhile, so the torque-rate
    /// limit starts afresh.
    pub fn reset(&mut self) {
        self.memory = Memory::new();
    }

    /// The fault in force.
    pub fn fault(&self) -> Option<Fault> {
        self.memory.fault
    }

    /// What does not change.
    pub fn config(&self) -> &ControllerConfig<S, N> {
        &self.config
    }

    /// The inverse dynamics, for example to set a payload between ticks.
    pub fn dynamics_mut(&mut self) -> &mut D {
        &mut self.dynamics
    }

    /// The live inputs of the scene, to be set between ticks.
    pub fn live_mut(&mut self) -> &mut Live<S, N> {
        &mut self.live
    }

    fn drive(&mut self, reference: &Reference<S, N>, measurement: &Measurement<S, N>) -> Result<Command<S, N>, Fault> {
        if measurement.age_ticks > self.config.age_max {
            return Err(Fault::StaleMeasurement);
        }
        check_reference(reference)?;
        let (q, qd) = self.observe(measurement);
        self.check_state(&q, &qd)?;

        let mut limits = [LimitFlags::NONE; N];
        let held;
        let reference = if reference_is_inside(reference, &self.config.limits) {
            reference
        } else {
            held = hold_reference(reference, &self.config.limits, &mut limits);
            &held
        };
        self.memory.acceleration = reference.qdd;

        let state = State { reference, q: &q, qd: &qd, live: &self.live };
        let mut torque = torques(self.config.law, &self.config.gains, &self.dynamics, &self.trig, &state);
        for i in 0..N {
            // Adding zero to a torque without friction makes +0 of -0: kernels that are equal need not agree on the sign
            // of a zero, and commands are compared by their bits.
            torque[i] += self.config.friction.as_ref().map_or(S::zero(), |all| all[i].torque(reference.qd[i]));
        }
        self.limit_torques(&mut torque, &mut limits)?;
        self.memory.torque = Some(torque);
        Ok(Command::Drive { torque, limits })
    }

    #[inline]
    fn limit_torques(&self, torque: &mut [S; N], limits: &mut [LimitFlags; N]) -> Result<(), Fault> {
        // Without a torque before there is no rate to limit: every torque is near itself.
        let last = self.memory.torque.as_ref();
        for i in 0..N {
            let near = last.map_or(torque[i], |last| last[i]);
            let limit = self.config.limits[i].torque;
            let step = self.config.torque_step[i];
            if torque_is_inside(torque[i], near, step, limit) {
                continue;
            }
            if !torque[i].is_finite() {
                return Err(Fault::NonFiniteTorque { joint: i as u8 });
            }
            let (held, flags) = hold_torque(torque[i], last.map(|last| last[i]), step, limit);
            torque[i] = held;
            limits[i] |= flags;
        }
        Ok(())
    }

    /// Position and velocity in SI, from whatever the sensors give.
    #[inline]
    fn observe(&mut self, measurement: &Measurement<S, N>) -> ([S; N], [S; N]) {
        let counts = match &measurement.sensed {
            Sensed::State { q, qd } => {
                // Counts that come later must not be compared with where the joints were before.
                self.memory.estimate = None;
                return (*q, *qd);
            }
            Sensed::Counts(counts) => counts,
        };
        let position: [S; N] = core::array::from_fn(|i| self.config.encoder[i].position(counts[i]));
        let (mut x, mut v) = self.memory.estimate.unwrap_or((position, [S::zero(); N]));
        if self.memory.estimate.is_some() {
            for i in 0..N {
                (x[i], v[i]) = self.config.observer.step(x[i], v[i], self.memory.acceleration[i], position[i]);
            }
        }
        self.memory.estimate = Some((x, v));
        (x, v)
    }

    #[inline]
    fn check_state(&self, q: &[S; N], qd: &[S; N]) -> Result<(), Fault> {
        let mut inside = true;
        for i in 0..N {
            let guard = &self.config.guard[i];
            let (lo, hi) = self.config.limits[i].position;
            let margin = guard.position_margin;
            inside &= q[i] >= lo - margin && q[i] <= hi + margin && qd[i].abs() <= guard.velocity_max;
        }
        // Where there is no limit an infinity is inside.
        if inside && zero_if_finite(q) + zero_if_finite(qd) == S::zero() { Ok(()) } else { Err(self.name_state(q, qd)) }
    }

    /// What is wrong with a state that is not believed, on the first joint where something is.
    #[cold]
    fn name_state(&self, q: &[S; N], qd: &[S; N]) -> Fault {
        for i in 0..N {
            let joint = i as u8;
            let (lo, hi) = self.config.limits[i].position;
            let margin = self.config.guard[i].position_margin;
            if !(q[i].is_finite() && qd[i].is_finite()) {
                return Fault::NonFiniteMeasurement { joint };
            }
            if q[i] < lo - margin || q[i] > hi + margin {
                return Fault::PositionOutOfBounds { joint };
            }
            if qd[i].abs() > self.config.guard[i].velocity_max {
                return Fault::VelocityOutOfBounds { joint };
            }
        }
        // Only a bound that is NaN brings us here: a configuration that no number can meet.
        Fault::NonFiniteMeasurement { joint: 0 }
    }
}

impl<S: Real, const N: usize> Memory<S, N> {
    fn new() -> Self {
        Self { estimate: None, acceleration: [S::zero(); N], torque: None, fault: None }
    }
}

#[inline]
fn check_reference<S: Real, const N: usize>(reference: &Reference<S, N>) -> Result<(), Fault> {
    let Reference { q, qd, qdd } = reference;
    if zero_if_finite(q) + zero_if_finite(qd) + zero_if_finite(qdd) == S::zero() {
        return Ok(());
    }
    let finite = |i: usize| reference.q[i].is_finite() && reference.qd[i].is_finite() && reference.qdd[i].is_finite();
    let joint = (0..N).find(|&i| !finite(i)).unwrap_or_default();
    Err(Fault::NonFiniteReference { joint: joint as u8 })
}

/// Zero when every value is a number, else NaN: `0 x` is zero for a number and NaN for what is none, and NaN outlives every
/// sum. So one comparison does for all joints.
#[inline]
fn zero_if_finite<S: Real, const N: usize>(x: &[S; N]) -> S {
    let mut sum = S::zero();
    for i in 0..N {
        sum += x[i] * S::zero();
    }
    sum
}
