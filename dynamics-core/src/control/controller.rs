//! The tick.

use super::collision::{Protection, Seen, Unprotected, Verdict};
use super::config::{Configuration, ControllerConfig, Guard};
use super::integral::{Integral, Integrated};
use super::law::{State, torques};
use super::limits::{LimitFlags, hold_reference, hold_torques, reference_is_inside};
use super::observer::TrackingObserver;
use super::{Command, Fault, Measurement, Reference, Sensed};
use crate::newton_euler::InverseDynamics;
use crate::scalar::Real;
use crate::scene::Live;
use crate::trig::Trig;

/// Origin of the joints' positions and velocities in a tick.
#[derive(Clone, Copy, Debug)]
pub enum Reading<'a, S, const N: usize> {
    /// A sensor reading, to be judged and, where it is in counts, observed.
    Measured(&'a Measurement<S, N>),
    /// Positions and velocities that were observed and judged already: finite, inside the guard's bounds, and young enough.
    Judged {
        /// Joint position, rad or m.
        q: &'a [S; N],
        /// Joint velocity, rad/s or m/s.
        qd: &'a [S; N],
    },
}

/// State that changes from tick to tick.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Memory<S, const N: usize> {
    observed: Observed<S, N>,
    /// Acceleration that the last reference asked for.
    acceleration: [S; N],
    /// The last commanded torque; zero before the first.
    torque: [S; N],
    /// Greatest change from it to the next torque; any finite number before the first.
    torque_step: [S; N],
    integral: [Integrated<S>; N],
    /// The fault in force.
    fault: Option<Fault>,
}

/// Estimate of the observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Observed<S, const N: usize> {
    /// Estimated positions; zero while there is no estimate.
    position: [S; N],
    velocity: [S; N],
    /// Filter of the next step; [`TrackingObserver::start`] while there is no estimate.
    observer: TrackingObserver<S>,
    /// Whether there is an estimate: the last reading was in counts.
    started: bool,
}

/// Computed-torque controller of an arm with `N` joints.
///
/// Generic over the inverse dynamics (the recursion or a generated kernel), over sine and cosine, over where the
/// configuration is kept ([`Configuration`]), and over the watch on the arm ([`Protection`]; by default none, at no
/// cost); it cannot tell one kernel from another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller<S, const N: usize, D, T, C = ControllerConfig<S, N>, P = Unprotected> {
    config: C,
    dynamics: D,
    trig: T,
    live: Live<S, N>,
    memory: Memory<S, N>,
    protection: P,
}

impl<S: Real, const N: usize, D: InverseDynamics<S, N>, T: Trig<S>, C: Configuration<S, N>> Controller<S, N, D, T, C> {
    /// A controller at rest, with every live input zero.
    #[must_use]
    pub fn new(config: C, dynamics: D, trig: T) -> Self {
        Self { config, dynamics, trig, live: Live::zero(), memory: Memory::new(), protection: Unprotected }
    }

    /// The same controller, watched.
    #[must_use]
    pub fn with_protection<P>(self, protection: P) -> Controller<S, N, D, T, C, P> {
        let Self { config, dynamics, trig, live, memory, .. } = self;
        Controller { config, dynamics, trig, live, memory, protection }
    }
}

impl<S, const N: usize, D, T, C, P> Controller<S, N, D, T, C, P>
where
    S: Real,
    D: InverseDynamics<S, N>,
    T: Trig<S>,
    C: Configuration<S, N>,
    P: Protection<S, N>,
{
    /// One tick: from reference and measurement to a command. Total: it neither panics nor fails.
    ///
    /// Cost: one inverse dynamics, `N` pairs of sine and cosine, and for six joints about 600 instructions of a Cortex-M4F
    /// beside them (`docs/performance.md`).
    #[inline]
    pub fn tick(&mut self, reference: &Reference<S, N>, measurement: &Measurement<S, N>) -> Command<S, N> {
        self.tick_from(reference, Reading::Measured(measurement))
    }

    /// As [`Controller::tick`], from either kind of reading.
    #[inline]
    pub fn tick_from(&mut self, reference: &Reference<S, N>, reading: Reading<'_, S, N>) -> Command<S, N> {
        let fault = match self.memory.fault {
            Some(fault) => fault,
            None => match self.drive(reference, reading) {
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
        self.dynamics.forget();
        self.protection.forget();
    }

    /// The fault in force.
    pub fn fault(&self) -> Option<Fault> {
        self.memory.fault
    }

    /// The configuration.
    pub fn config(&self) -> &ControllerConfig<S, N> {
        self.config.get()
    }

    /// The inverse dynamics, for example to set a payload between ticks.
    pub fn dynamics_mut(&mut self) -> &mut D {
        &mut self.dynamics
    }

    /// The watch on the arm.
    pub fn protection(&self) -> &P {
        &self.protection
    }

    /// The configuration, to be changed between ticks; `None` where it is part of the program.
    pub fn config_mut(&mut self) -> Option<&mut ControllerConfig<S, N>> {
        self.config.get_mut()
    }

    /// The live inputs of the scene.
    pub fn live(&self) -> &Live<S, N> {
        &self.live
    }

    /// The live inputs of the scene, to be set between ticks.
    pub fn live_mut(&mut self) -> &mut Live<S, N> {
        &mut self.live
    }

    #[inline]
    fn drive(&mut self, reference: &Reference<S, N>, reading: Reading<'_, S, N>) -> Result<Command<S, N>, Fault> {
        let Self { config, dynamics, trig, live, memory, protection } = self;
        let config = config.get();
        let (q, qd) = match reading {
            Reading::Judged { q, qd } => (q, qd),
            Reading::Measured(measurement) => {
                if measurement.age_ticks > config.age_max {
                    return Err(Fault::StaleMeasurement);
                }
                let (q, qd) = memory.observed.update(config, &memory.acceleration, &measurement.sensed);
                if !state_is_inside(q, qd, config) {
                    return Err(name_fault(reference, q, qd, config));
                }
                (q, qd)
            }
        };

        let mut limits = [LimitFlags::NONE; N];
        let held;
        let reference = if reference_is_inside(reference, &config.limits) {
            reference
        } else {
            if let Some(fault) = name_reference(reference) {
                return Err(fault);
            }
            held = hold_reference(reference, &config.limits, &mut limits);
            &held
        };

        let standing;
        let (mut reference, mut turn, mut complies) = (reference, None, false);
        // A constant at build time: a controller without protection has not one instruction of this.
        if P::WATCHES {
            let seen = Seen { q, qd, live, friction: config.friction.as_ref() };
            let verdict;
            (verdict, turn) = protection.look(&seen, || trig.sin_cos_all(q));
            match verdict {
                Verdict::Free => {}
                Verdict::Stop { joint } => return Err(Fault::Collision { joint }),
                Verdict::Hold { q, joint } => {
                    let zero = [S::zero(); N];
                    standing = Reference { q, qd: zero, qdd: zero };
                    reference = &standing;
                    flag(&mut limits, joint);
                }
                Verdict::Comply { joint } => {
                    complies = true;
                    flag(&mut limits, joint);
                }
            }
        }
        memory.acceleration = reference.qdd;
        if complies {
            memory.acceleration = [S::zero(); N];
        }

        let state = State { reference, q, qd, live, turn };
        let law = (!complies).then_some(config.law);
        let mut torque = torques(law, &config.gains, dynamics, trig, &state);
        // An arm that gives way must not be pushed on by what it was held with.
        let mut integrated = [Integrated::zero(); N];
        for i in 0..N {
            if let (Some(friction), false) = (&config.friction, complies) {
                torque[i] += friction[i].torque(reference.qd[i]);
            }
            if let (Some(integral), false) = (&config.integral, complies) {
                integrated[i] = integral[i].next(memory.integral[i], reference.q[i] - q[i]);
                torque[i] += integrated[i].torque;
            }
            // Turns -0 into +0: equal kernels may differ in the sign of a zero, and commands are compared by their
            // bits.
            torque[i] += S::zero();
        }
        memory.limit(&mut torque, &mut limits, config)?;
        if config.integral.is_some() {
            for i in 0..N {
                memory.integral[i] = Integral::after(memory.integral[i], integrated[i], limits[i]);
            }
        }
        if P::WATCHES {
            protection.drove(&torque);
        }
        Ok(Command::Drive { torque, limits })
    }
}

/// Flag that the reference is not followed because of a collision on this joint.
fn flag<const N: usize>(limits: &mut [LimitFlags; N], joint: u8) {
    if let Some(flags) = limits.get_mut(usize::from(joint)) {
        *flags |= LimitFlags::COLLISION;
    }
}

impl<S: Real, const N: usize> Memory<S, N> {
    fn new() -> Self {
        let zero = [S::zero(); N];
        Self {
            observed: Observed::new(),
            acceleration: zero,
            torque: zero,
            torque_step: [S::MAX; N],
            integral: [Integrated::zero(); N],
            fault: None,
        }
    }

    /// Hold the torques inside their limits, and remember them.
    #[inline]
    fn limit(
        &mut self,
        torque: &mut [S; N],
        limits: &mut [LimitFlags; N],
        config: &ControllerConfig<S, N>,
    ) -> Result<(), Fault> {
        hold_torques(torque, limits, &config.limits, &self.torque, &self.torque_step, &config.torque_step)?;
        self.torque = *torque;
        self.torque_step = config.torque_step;
        Ok(())
    }
}

impl<S: Real, const N: usize> Observed<S, N> {
    pub(crate) fn new() -> Self {
        let zero = [S::zero(); N];
        Self { position: zero, velocity: zero, observer: TrackingObserver::start(), started: false }
    }

    /// Position and velocity in SI, from either kind of reading.
    ///
    /// The first reading in counts starts the estimate there, at rest, at the cost of any other reading.
    #[inline]
    pub(crate) fn update<'a>(
        &'a mut self,
        config: &ControllerConfig<S, N>,
        acceleration: &[S; N],
        sensed: &'a Sensed<S, N>,
    ) -> (&'a [S; N], &'a [S; N]) {
        let counts = match sensed {
            Sensed::State { q, qd } => {
                // Later counts must not be compared with the joints' earlier positions.
                if self.started {
                    *self = Self::new();
                }
                return (q, qd);
            }
            Sensed::Counts(counts) => counts,
        };
        for i in 0..N {
            let position = config.encoder[i].position(counts[i]);
            (self.position[i], self.velocity[i]) =
                self.observer.step(self.position[i], self.velocity[i], acceleration[i], position);
        }
        (self.observer, self.started) = (config.observer, true);
        (&self.position, &self.velocity)
    }
}

/// Bounds on a joint's measured state: lowest position, highest position, greatest speed. Infinite where there is no
/// limit.
#[inline]
pub(crate) fn believed<S: Real, const N: usize>(config: &ControllerConfig<S, N>, i: usize) -> (S, S, S) {
    let Guard { position_margin, velocity_max } = config.guard[i];
    let (lo, hi) = config.limits[i].position;
    (lo - position_margin, hi + position_margin, velocity_max)
}

/// Whether a measured state is within its bounds. False where a value is NaN or infinite.
#[inline]
fn state_is_inside<S: Real, const N: usize>(q: &[S; N], qd: &[S; N], config: &ControllerConfig<S, N>) -> bool {
    // Computed at build time: no infinity is inside a finite bound, so the values need no second look.
    let finite = |x: S| x.clamp_symmetric(S::MAX);
    for i in 0..N {
        let (lo, hi, velocity_max) = believed(config, i);
        if !(q[i] >= finite(lo) && q[i] <= finite(hi) && qd[i].abs() <= finite(velocity_max)) {
            return false;
        }
    }
    true
}

/// The fault of a tick whose reference or state is refused, on the first joint with one. The reference is checked
/// before the state.
#[cold]
fn name_fault<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    q: &[S; N],
    qd: &[S; N],
    config: &ControllerConfig<S, N>,
) -> Fault {
    if let Some(fault) = name_reference(reference) {
        return fault;
    }
    for i in 0..N {
        let joint = i as u8;
        let (lo, hi, velocity_max) = believed(config, i);
        if !(q[i].is_finite() && qd[i].is_finite()) {
            return Fault::NonFiniteMeasurement { joint };
        }
        if q[i] < lo || q[i] > hi {
            return Fault::PositionOutOfBounds { joint };
        }
        if qd[i].abs() > velocity_max {
            return Fault::VelocityOutOfBounds { joint };
        }
    }
    // Reached only with a bound that is NaN: no state is inside such a configuration.
    Fault::NonFiniteMeasurement { joint: 0 }
}

/// The first joint whose reference is not a finite number, if there is one.
#[cold]
pub(crate) fn name_reference<S: Real, const N: usize>(reference: &Reference<S, N>) -> Option<Fault> {
    let finite = |i: usize| reference.q[i].is_finite() && reference.qd[i].is_finite() && reference.qdd[i].is_finite();
    (0..N).find(|&i| !finite(i)).map(|joint| Fault::NonFiniteReference { joint: joint as u8 })
}
