//! The controller: one tick from reference and measurement to a command.

use super::build::{ArmBuild, BuildOf, Unsupervised};
use super::collision::{ObservedState, Protection, Unprotected, Verdict};
use super::config::{Configuration, ControllerConfig, Guard};
use super::integral::{Integral, Integrated};
use super::law_torques::{LawInputs, torques};
use super::limits::{LimitFlags, hold_reference, hold_torques, reference_is_inside};
use super::observer::TrackingObserver;
use super::torque_request::TorqueRequest;
use super::{Command, Fault, Measurement, Reference, Sensed};
use crate::newton_euler::InverseDynamics;
use crate::scalar::Real;
use crate::scene::Live;
use crate::trig::Trig;
use core::fmt::{self, Debug};

/// State that changes from tick to tick.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ControllerMemory<S, const N: usize> {
    /// Integral action before the last proposed torque, and including it.
    integral: [[Integrated<S>; N]; 2],
    /// Position at which each joint of a hand-guided arm is kept, rad or m; `None` while the joint is free.
    anchors: [Option<S>; N],
    /// The fault in force.
    fault: Option<Fault>,
}

/// State used only when the controller runs without the safety state machine.
#[derive(Clone, Copy, Debug, PartialEq)]
struct StandaloneState<S, const N: usize> {
    observed: Observed<S, N>,
    /// Acceleration of the last reference, rad/s^2 or m/s^2.
    acceleration: [S; N],
    /// The last commanded torque, N m or N; zero before the first.
    torque: [S; N],
    /// Greatest change from the last torque to the next; any finite number before the first.
    torque_step: [S; N],
}

/// Estimate of the observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Observed<S, const N: usize> {
    /// Estimated positions, rad or m; zero while there is no estimate.
    position: [S; N],
    velocity: [S; N],
    /// Filter of the next step; [`TrackingObserver::start`] while there is no estimate.
    observer: TrackingObserver<S>,
    /// True if there is an estimate: the last reading was in counts.
    started: bool,
    /// Age of each joint's reading in the last tick, ticks. If all readings were fresh, all are zero and `aged` is false.
    age: [u32; N],
    /// True if some reading of the last tick was not fresh. Positions and velocities are then those used in that tick, for either kind of reading.
    aged: bool,
}

/// Inputs of one torque computation.
pub(crate) struct ControlInput<'a, S, const N: usize> {
    pub(crate) reference: &'a Reference<S, N>,
    /// True if the reference is known to be finite and within its limits.
    pub(crate) reference_checked: bool,
    /// True if the arm runs: a control law without a reference frees the joints then.
    pub(crate) is_running: bool,
    pub(crate) q: &'a [S; N],
    pub(crate) qd: &'a [S; N],
}

/// Computes torques from reference and state, before any torque limit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Regulator<S, const N: usize, D, T, C, P> {
    config: C,
    dynamics: D,
    trig: T,
    live: Live<S, N>,
    memory: ControllerMemory<S, N>,
    protection: P,
}

/// Computed-torque controller of an arm with `N` joints.
///
/// Its parts are chosen when the program is compiled ([`ArmBuild`]): inverse dynamics, sine and cosine, the source of the configuration
/// ([`Configuration`]), and the collision observer ([`Protection`]; without one it adds no instruction).
pub struct Controller<S: Real, const N: usize, A: ArmBuild<S, N>> {
    regulator: Regulator<S, N, A::Dynamics, A::Trig, A::Tuning, A::Protection>,
    alone: StandaloneState<S, N>,
}

/// A controller of these parts.
pub type ControllerOf<S, const N: usize, D, T, C = ControllerConfig<S, N>, P = Unprotected, K = Unsupervised> =
    Controller<S, N, BuildOf<D, T, C, P, K>>;

impl<S: Real, const N: usize, A: ArmBuild<S, N>> Clone for Controller<S, N, A> {
    fn clone(&self) -> Self {
        Self { regulator: self.regulator.clone(), alone: self.alone }
    }
}

impl<S: Real, const N: usize, A: ArmBuild<S, N>> Debug for Controller<S, N, A>
where
    A::Dynamics: Debug,
    A::Trig: Debug,
    A::Tuning: Debug,
    A::Protection: Debug,
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Controller").field("regulator", &self.regulator).field("alone", &self.alone).finish()
    }
}

impl<S: Real, const N: usize, A: ArmBuild<S, N>> PartialEq for Controller<S, N, A>
where
    A::Dynamics: PartialEq,
    A::Trig: PartialEq,
    A::Tuning: PartialEq,
    A::Protection: PartialEq,
{
    fn eq(&self, other: &Self) -> bool {
        self.regulator == other.regulator && self.alone == other.alone
    }
}

impl<S, const N: usize, D, T, C> Controller<S, N, BuildOf<D, T, C>>
where
    S: Real,
    D: InverseDynamics<S, N> + Clone,
    T: Trig<S> + Clone,
    C: Configuration<S, N> + Clone,
{
    /// A controller at rest, without a collision observer, with every live input zero.
    #[must_use]
    pub fn new(config: C, dynamics: D, trig: T) -> Self {
        Self::built(config, dynamics, trig, Unprotected)
    }

    /// The same controller with a collision observer.
    #[must_use]
    pub fn with_protection<P: Protection<S, N> + Clone>(self, protection: P) -> Controller<S, N, BuildOf<D, T, C, P>> {
        let Regulator { config, dynamics, trig, live, memory, .. } = self.regulator;
        Controller { regulator: Regulator { config, dynamics, trig, live, memory, protection }, alone: self.alone }
    }
}

impl<S: Real, const N: usize, D, T, C, P, K> Controller<S, N, BuildOf<D, T, C, P, K>>
where
    BuildOf<D, T, C, P, K>: ArmBuild<S, N, Dynamics = D, Trig = T, Tuning = C, Protection = P>,
{
    /// The same controller inside a safety state machine with settings of another type.
    #[must_use]
    pub fn with_settings<L>(self) -> Controller<S, N, BuildOf<D, T, C, P, L>>
    where
        BuildOf<D, T, C, P, L>: ArmBuild<S, N, Dynamics = D, Trig = T, Tuning = C, Protection = P>,
    {
        Controller { regulator: self.regulator, alone: self.alone }
    }
}

impl<S: Real, const N: usize, A: ArmBuild<S, N>> Controller<S, N, A> {
    /// A controller at rest, with every live input zero.
    #[must_use]
    pub fn built(config: A::Tuning, dynamics: A::Dynamics, trig: A::Trig, protection: A::Protection) -> Self {
        let (live, memory) = (Live::zero(), ControllerMemory::new());
        Self {
            regulator: Regulator { config, dynamics, trig, live, memory, protection },
            alone: StandaloneState::new(),
        }
    }

    /// One tick: from reference and measurement to a command. Total: it neither panics nor fails.
    ///
    /// Cost: one inverse dynamics, `N` pairs of sine and cosine, and for six joints about 600 further instructions of a Cortex-M4F
    /// (`docs/performance.md`).
    #[inline]
    pub fn tick(&mut self, reference: &Reference<S, N>, measurement: &Measurement<S, N>) -> Command<S, N> {
        let fault = match self.regulator.memory.fault {
            Some(fault) => fault,
            None => {
                let (mut torque, mut limits) = ([S::zero(); N], [LimitFlags::NONE; N]);
                match self.drive(reference, measurement, &mut torque, &mut limits) {
                    Ok(()) => return Command::Drive { torque, limits },
                    Err(fault) => fault,
                }
            }
        };
        self.regulator.memory.fault = Some(fault);
        Command::Brake(fault)
    }

    /// One tick inside a machine that has observed and judged the joints, and applies the torque limits. Writes the torques of the control law to
    /// `torque`, and the limits that acted on the reference to `limits`.
    ///
    /// # Errors
    /// The fault in force, which stays until [`Controller::reset`].
    #[inline]
    pub fn answer(
        &mut self,
        ask: &TorqueRequest<'_, S, N>,
        torque: &mut [S; N],
        limits: &mut [LimitFlags; N],
    ) -> Result<(), Fault> {
        if ask.start {
            self.reset();
        } else {
            self.regulator.settle(ask.torque, ask.limits);
        }
        if let Some(fault) = self.regulator.memory.fault {
            return Err(fault);
        }
        let TorqueRequest { reference, is_running, q, qd, .. } = *ask;
        let given = ControlInput { reference, reference_checked: true, is_running, q, qd };
        let answer = self.regulator.propose(&given, torque, limits, None);
        if let Err(fault) = answer {
            self.regulator.memory.fault = Some(fault);
        }
        answer
    }

    /// Reports to the controller that a tick had not ended when the next was due.
    pub fn overrun(&mut self) {
        self.regulator.memory.fault.get_or_insert(Fault::Overrun);
    }

    /// Reports to the controller that measurements have stopped coming.
    pub fn measurement_lost(&mut self) {
        self.regulator.memory.fault.get_or_insert(Fault::StaleMeasurement);
    }

    /// Clears the fault, the observer's estimate and the last torque. The brakes have held meanwhile, so the torque-rate
    /// limit starts afresh.
    pub fn reset(&mut self) {
        self.regulator.memory = ControllerMemory::new();
        self.regulator.dynamics.forget();
        self.regulator.protection.forget();
        self.alone = StandaloneState::new();
    }

    /// The fault in force.
    pub fn fault(&self) -> Option<Fault> {
        self.regulator.memory.fault
    }

    /// The configuration.
    pub fn config(&self) -> &ControllerConfig<S, N> {
        self.regulator.config.get()
    }

    /// The inverse dynamics, for example to set a payload between ticks.
    pub fn dynamics_mut(&mut self) -> &mut A::Dynamics {
        &mut self.regulator.dynamics
    }

    /// The watch on the arm.
    pub fn protection(&self) -> &A::Protection {
        &self.regulator.protection
    }

    /// The configuration, to be changed between ticks; `None` if it is part of the program.
    pub fn config_mut(&mut self) -> Option<&mut ControllerConfig<S, N>> {
        self.regulator.config.get_mut()
    }

    /// The live inputs of the scene.
    pub fn live(&self) -> &Live<S, N> {
        &self.regulator.live
    }

    /// The live inputs of the scene, to be set between ticks.
    pub fn live_mut(&mut self) -> &mut Live<S, N> {
        &mut self.regulator.live
    }

    #[inline]
    fn drive(
        &mut self,
        reference: &Reference<S, N>,
        measurement: &Measurement<S, N>,
        torque: &mut [S; N],
        limits: &mut [LimitFlags; N],
    ) -> Result<(), Fault> {
        let Self { regulator, alone } = self;
        let config = regulator.config.get();
        if measurement.age_ticks > config.age_max {
            return Err(Fault::StaleMeasurement);
        }
        let mut read = [S::zero(); N];
        let ages = (measurement.age_ticks == 0, &[measurement.age_ticks; N]);
        let (_, q, qd) = alone.observed.update(config, &alone.acceleration, &measurement.sensed, ages, &mut read);
        if !state_is_inside(q, qd, config) {
            return Err(name_fault(reference, q, qd, config));
        }
        let given = ControlInput { reference, reference_checked: false, is_running: true, q, qd };
        regulator.propose(&given, torque, limits, Some(&mut alone.acceleration))?;
        let config = regulator.config.get();
        hold_torques(torque, limits, &config.limits, &alone.torque, &alone.torque_step, &config.torque_step)?;
        (alone.torque, alone.torque_step) = (*torque, config.torque_step);
        regulator.settle(torque, limits);
        Ok(())
    }
}

impl<S, const N: usize, D, T, C, P> Regulator<S, N, D, T, C, P>
where
    S: Real,
    D: InverseDynamics<S, N>,
    T: Trig<S>,
    C: Configuration<S, N>,
    P: Protection<S, N>,
{
    /// Computes the torques of the control law with friction and integral action, before any torque limit. Returns the acceleration that is
    /// followed too, for a caller that runs an observer.
    ///
    /// Out of line, so that open-loop bench mode and supervision share one copy of it.
    #[inline(never)]
    fn propose(
        &mut self,
        given: &ControlInput<'_, S, N>,
        torque: &mut [S; N],
        limits: &mut [LimitFlags; N],
        acceleration: Option<&mut [S; N]>,
    ) -> Result<(), Fault> {
        let Self { config, dynamics, trig, live, memory, protection } = self;
        let config = config.get();
        let ControlInput { reference, reference_checked, is_running, q, qd } = *given;
        *limits = [LimitFlags::NONE; N];
        let held;
        let reference = if reference_checked || reference_is_inside(reference, &config.limits) {
            reference
        } else {
            if let Some(fault) = name_reference(reference) {
                return Err(fault);
            }
            held = hold_reference(reference, &config.limits, limits);
            &held
        };

        let standing;
        let (mut reference, mut turn, mut collision_compliant) = (reference, None, false);
        // During hand guiding, the hand is not a collision, and there is no reference velocity to compensate friction along.
        let hand_guided = is_running && config.law.is_hand_guided();
        if hand_guided && !protection.only_reports() {
            protection.forget();
        } else if P::WATCHES {
            // A constant at build time: a controller without protection contains no instruction of this.
            let (friction, friction_terms) = (config.friction.as_ref(), dynamics.friction_terms());
            let seen = ObservedState { q, qd, live, friction, friction_terms };
            let verdict;
            (verdict, turn) = protection.look(&seen, || trig.sin_cos_all(q));
            match verdict {
                Verdict::Free => {}
                Verdict::Stop { joint } => return Err(Fault::Collision { joint }),
                Verdict::Hold { q, joint } => {
                    let zero = [S::zero(); N];
                    standing = Reference { q, qd: zero, qdd: zero };
                    reference = &standing;
                    flag(limits, joint);
                }
                Verdict::Comply { joint } => {
                    collision_compliant = true;
                    flag(limits, joint);
                }
            }
        }
        if let Some(acceleration) = acceleration {
            *acceleration = if collision_compliant { [S::zero(); N] } else { reference.qdd };
        }

        let state = LawInputs { reference, q, qd, live, turn };
        // While armed or held, the arm stays where it is.
        let law = if hand_guided { config.law } else { config.law.standing() };
        *torque = torques((law, collision_compliant), config, dynamics, trig, &state);
        let is_compliant = collision_compliant || hand_guided;
        let friction_terms = dynamics.friction_terms();
        for i in 0..N {
            if let (Some(friction), false) = (&config.friction, is_compliant) {
                torque[i] += match friction_terms {
                    None => friction[i].torque(reference.qd[i]),
                    Some(terms) => friction[i].torque_with(&terms[i], reference.qd[i], torque[i]),
                };
            }
            if let Some(integral) = &config.integral {
                // A compliant arm must not be driven by the integral torque that held it before.
                let next = match is_compliant {
                    true => Integrated::zero(),
                    false => integral[i].next(memory.integral[0][i], reference.q[i] - q[i]),
                };
                memory.integral[1][i] = next;
                torque[i] += next.torque;
            }
            if let Some(teach) = &config.teach {
                if hand_guided {
                    torque[i] += teach[i].torque(q[i], qd[i], &mut memory.anchors[i]);
                } else {
                    // When hand guiding starts, the joint is released from the spring that holds it here.
                    memory.anchors[i] = Some(reference.q[i]);
                }
            }
            // Turns -0 into +0: equal kernels may differ in the sign of a zero, and commands are compared by their
            // bits.
            torque[i] += S::zero();
        }
        Ok(())
    }

    /// Records the result of the proposal: the torque that acts, and the limits that acted on it.
    #[inline]
    fn settle(&mut self, torque: &[S; N], limits: &[LimitFlags; N]) {
        if self.config.get().integral.is_some() {
            let [before, proposed] = &mut self.memory.integral;
            for i in 0..N {
                before[i] = Integral::after(before[i], proposed[i], limits[i]);
            }
        }
        if P::WATCHES {
            self.protection.drove(torque);
        }
    }
}

/// Flag that the reference is not followed because of a collision on this joint.
fn flag<const N: usize>(limits: &mut [LimitFlags; N], joint: u8) {
    if let Some(flags) = limits.get_mut(usize::from(joint)) {
        *flags |= LimitFlags::COLLISION;
    }
}

impl<S: Real, const N: usize> ControllerMemory<S, N> {
    fn new() -> Self {
        Self { integral: [[Integrated::zero(); N]; 2], anchors: [None; N], fault: None }
    }
}

impl<S: Real, const N: usize> StandaloneState<S, N> {
    fn new() -> Self {
        let zero = [S::zero(); N];
        Self { observed: Observed::new(), acceleration: zero, torque: zero, torque_step: [S::MAX; N] }
    }
}

impl<S: Real, const N: usize> Observed<S, N> {
    pub(crate) fn new() -> Self {
        let zero = [S::zero(); N];
        Self {
            position: zero,
            velocity: zero,
            observer: TrackingObserver::start(),
            started: false,
            age: [0; N],
            aged: false,
        }
    }

    /// Returns the position as read, the position and the velocity to use, in SI units, from either kind of reading. `read` is the buffer for
    /// the position as read.
    ///
    /// The first reading in counts starts the estimate at that position, at rest, and costs no more than any other reading. `fresh` is true if
    /// every age is zero. A joint without a reading in this tick is predicted.
    #[inline]
    pub(crate) fn update<'a>(
        &'a mut self,
        config: &ControllerConfig<S, N>,
        acceleration: &[S; N],
        sensed: &'a Sensed<S, N>,
        (fresh, ages): (bool, &[u32; N]),
        read: &'a mut [S; N],
    ) -> (&'a [S; N], &'a [S; N], &'a [S; N]) {
        if !fresh || self.aged {
            return self.update_aged(config, acceleration, sensed, ages, read);
        }
        let counts = match sensed {
            Sensed::State { q, qd } => {
                // Later counts must not be compared with the joints' earlier positions.
                if self.started {
                    *self = Self::new();
                }
                return (q, q, qd);
            }
            Sensed::Counts(counts) => counts,
        };
        for i in 0..N {
            let position = config.encoder[i].position(counts[i]);
            read[i] = position;
            (self.position[i], self.velocity[i]) =
                self.observer.step(self.position[i], self.velocity[i], acceleration[i], position);
        }
        (self.observer, self.started) = (config.observer, true);
        (read, &self.position, &self.velocity)
    }

    /// As `update`, for a tick in which some joint's reading is not fresh, and for the tick after it.
    ///
    /// If the age of a reading has grown by one, it is the reading of the last tick: nothing new has arrived. The joint is then predicted along
    /// its reference's acceleration, `x + h v + (h^2 / 2) a`, as long as the reading is young enough to be used at all. A reading that
    /// arrives after a longer gap starts the estimate again.
    #[cold]
    #[inline(never)]
    fn update_aged<'a>(
        &'a mut self,
        config: &ControllerConfig<S, N>,
        acceleration: &[S; N],
        sensed: &'a Sensed<S, N>,
        ages: &[u32; N],
        read: &'a mut [S; N],
    ) -> (&'a [S; N], &'a [S; N], &'a [S; N]) {
        let counts = match sensed {
            Sensed::State { .. } => None,
            Sensed::Counts(counts) => Some(counts),
        };
        // An estimate from the other kind of reading does not count.
        let known = self.aged || counts.is_some();
        let known = known && self.started == counts.is_some();
        let mut aged = false;
        for i in 0..N {
            let last = core::mem::replace(&mut self.age[i], ages[i]);
            let missing = ages[i] == last.saturating_add(1) && ages[i] <= config.age_max;
            let (position, velocity) = match sensed {
                Sensed::State { q, qd } => (q[i], qd[i]),
                Sensed::Counts(counts) => (config.encoder[i].position(counts[i]), S::zero()),
            };
            read[i] = position;
            let (x, v) = if known { (self.position[i], self.velocity[i]) } else { (position, velocity) };
            (self.position[i], self.velocity[i]) = if missing {
                config.observer.predict(x, v, acceleration[i])
            } else if counts.is_none() || !known || last > config.age_max || ages[i] > config.age_max {
                (position, velocity)
            } else {
                config.observer.step(x, v, acceleration[i], position)
            };
            aged |= ages[i] != 0;
        }
        self.aged = aged;
        (self.observer, self.started) = (config.observer, counts.is_some());
        (read, &self.position, &self.velocity)
    }
}

/// Bounds on a joint's measured state: lowest position, highest position, greatest speed. Infinite if there is no
/// limit.
#[inline]
pub(crate) fn believed<S: Real, const N: usize>(config: &ControllerConfig<S, N>, i: usize) -> (S, S, S) {
    let Guard { position_margin, velocity_max } = config.guard[i];
    let (lo, hi) = config.limits[i].position;
    (lo - position_margin, hi + position_margin, velocity_max)
}

/// True if a measured state is within its bounds. False if a value is NaN or infinite.
#[inline]
fn state_is_inside<S: Real, const N: usize>(q: &[S; N], qd: &[S; N], config: &ControllerConfig<S, N>) -> bool {
    // Computed at build time: a finite bound excludes infinity, so the values need no second check.
    let finite = |x: S| x.clamp_symmetric(S::MAX);
    for i in 0..N {
        let (lo, hi, velocity_max) = believed(config, i);
        if !(q[i] >= finite(lo) && q[i] <= finite(hi) && qd[i].abs() <= finite(velocity_max)) {
            return false;
        }
    }
    true
}

/// The fault of a tick whose reference or state is rejected, on the first such joint. The reference is checked
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
    // Reached only if a bound is NaN: no state is within such a bound.
    Fault::NonFiniteMeasurement { joint: 0 }
}

/// The first joint whose reference is not a finite number, if there is one.
#[cold]
pub(crate) fn name_reference<S: Real, const N: usize>(reference: &Reference<S, N>) -> Option<Fault> {
    let finite = |i: usize| reference.q[i].is_finite() && reference.qd[i].is_finite() && reference.qdd[i].is_finite();
    (0..N).find(|&i| !finite(i)).map(|joint| Fault::NonFiniteReference { joint: joint as u8 })
}
