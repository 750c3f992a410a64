//! The machine.

use super::measured::{Seen, Sensors};
use super::stop::{can_stop, slowed};
use super::{Actuation, Ask, Configuration, HoldCause, Inputs, Output, Refusal, Request, Rules, State};
use crate::control::{Command, ControllerConfig, Fault, LimitFlags, Reference, believed, hold_torques, name_reference};
use crate::scalar::Real;

/// The state machine around a controller. See the [module](super) for its states and `docs/safety.md` for its rules.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Safety<S, const N: usize, C> {
    config: C,
    state: State,
    homed: bool,
    sensors: Sensors<S, N>,
    /// Reference of the controller while torque acts.
    reference: Reference<S, N>,
    /// The torque that acts.
    torque: [S; N],
    /// Ticks that torque has acted without the host.
    alone: u32,
    /// The controller gave way to a collision in the last tick, and did not follow its reference.
    gave_way: bool,
}

/// Reason why a reference is refused.
enum Unfit {
    Missing,
    NonFinite(Fault),
    NoRoom { joint: u8 },
    OutOfReach { joint: u8 },
}

impl<S: Real, const N: usize, C: Configuration<S, N>> Safety<S, N, C> {
    /// A machine that idles, not homed.
    #[must_use]
    pub fn new(config: C) -> Self {
        let zero = [S::zero(); N];
        Self {
            config,
            state: State::Idle,
            homed: false,
            sensors: Sensors::new(),
            reference: Reference { q: zero, qd: zero, qdd: zero },
            torque: zero,
            alone: 0,
            gave_way: false,
        }
    }

    /// State of the machine.
    #[must_use]
    pub fn state(&self) -> State {
        self.state
    }

    /// Whether the joints' zeros have been confirmed.
    #[must_use]
    pub fn homed(&self) -> bool {
        self.homed
    }

    /// One tick. Total: every input gives torques inside their limits or the safe action.
    ///
    /// `control` is called once where torque may act, with the reference to follow, and not at all otherwise.
    ///
    /// Cost beside the controller's: `O(N)`, no division, no root; the same comparisons in every state for the sensors, and
    /// in `Running` for the reference.
    #[inline]
    pub fn tick(
        &mut self,
        inputs: &Inputs<S, N>,
        control: impl FnOnce(Ask<'_, S, N>) -> Command<S, N>,
    ) -> Output<S, N> {
        let (config, rules) = (self.config.get(), self.config.rules());
        // An arm that gave way did not follow its reference, and knows no acceleration.
        let still = [S::zero(); N];
        let acceleration = if self.gave_way { &still } else { &self.reference.qdd };
        let seen = self.sensors.look(inputs, acceleration, config, rules);
        self.homed &= !seen.jumped;
        let silent = inputs.heartbeat_age > rules.heartbeat_max;
        let external = external(inputs, rules);

        if let State::Fault(fault) = self.state {
            let refused = match inputs.request {
                None => None,
                Some(Request::Clear) => self.clear(external, &seen),
                Some(_) => Some(Refusal::Fault(fault)),
            };
            return self.safe(refused);
        }
        let drove = self.state.drives();
        self.alone = if drove && silent { self.alone.saturating_add(1) } else { 0 };
        let fault = external.or(if drove { seen.fault } else { None }).or(if self.alone > rules.hold_max {
            Some(Fault::HeartbeatLost)
        } else {
            None
        });
        if let Some(fault) = fault {
            return self.fail(fault, inputs.request);
        }

        let refused = self.grant(inputs, &seen, silent).err();
        if !self.state.drives() {
            return self.safe(refused);
        }
        match self.follow(inputs, &seen, silent) {
            Ok(()) => self.drive(inputs, &seen, !drove, refused, control),
            Err(fault) => self.fail(fault, inputs.request),
        }
    }

    /// Leave the fault when its cause is gone, and nothing would raise a fault again at once.
    fn clear(&mut self, external: Option<Fault>, seen: &Seen<S, N>) -> Option<Refusal> {
        let seen_fault = match seen.fault {
            // Without a known zero a position has no meaning, and only an idle machine can be homed.
            Some(Fault::PositionOutOfBounds { .. }) if !self.homed => None,
            fault => fault,
        };
        if let Some(fault) = external.or(seen_fault) {
            return Some(Refusal::Fault(fault));
        }
        if !seen.at_rest(self.config.rules()) {
            return Some(Refusal::NotAtRest);
        }
        self.state = State::Idle;
        None
    }

    /// Do as requested, or say why not.
    #[inline]
    fn grant(&mut self, inputs: &Inputs<S, N>, seen: &Seen<S, N>, silent: bool) -> Result<(), Refusal> {
        let Some(request) = inputs.request else { return Ok(()) };
        match (self.state, request) {
            (State::Idle, Request::Home) => {
                self.homed = false;
                self.state = State::Homing;
            }
            (State::Homing, Request::Confirm) => {
                if !inputs.zeroed {
                    return Err(Refusal::NotZeroed);
                }
                standing(seen, self.config.rules())?;
                self.homed = true;
                self.state = State::Idle;
            }
            (State::Idle, Request::Arm) => {
                if !self.homed {
                    return Err(Refusal::NotHomed);
                }
                standing(seen, self.config.rules())?;
                if silent {
                    return Err(Refusal::HeartbeatLost);
                }
                self.reference = Reference::at_rest(seen.q);
                self.state = State::Armed;
            }
            (State::Homing, Request::Disarm) => self.state = State::Idle,
            (State::Armed | State::Holding(_), Request::Disarm) => {
                if !seen.at_rest(self.config.rules()) {
                    return Err(Refusal::NotAtRest);
                }
                self.state = State::Idle;
            }
            (State::Armed | State::Holding(_), Request::Run) => {
                if silent {
                    return Err(Refusal::HeartbeatLost);
                }
                let (config, rules) = (self.config.get(), self.config.rules());
                let reference = fit(inputs, seen, config, rules).map_err(|unfit| match unfit {
                    Unfit::Missing => Refusal::NoReference,
                    Unfit::NonFinite(fault) => Refusal::Implausible(fault),
                    Unfit::NoRoom { joint } => Refusal::NoRoom { joint },
                    Unfit::OutOfReach { joint } => Refusal::OutOfReach { joint },
                })?;
                for i in 0..N {
                    let near = (reference.qd[i] - seen.qd[i]).abs() <= rules.joints[i].reach_speed;
                    if !near {
                        return Err(Refusal::OutOfReach { joint: i as u8 });
                    }
                }
                self.state = State::Running;
            }
            (State::Running, Request::Hold) => self.state = State::Holding(HoldCause::Requested),
            _ => return Err(Refusal::WrongState),
        }
        Ok(())
    }

    /// Find the reference of this tick: the host's, or that of a stop.
    #[inline]
    fn follow(&mut self, inputs: &Inputs<S, N>, seen: &Seen<S, N>, silent: bool) -> Result<(), Fault> {
        let (config, rules) = (self.config.get(), self.config.rules());
        let cause = match self.state {
            State::Running => match fit(inputs, seen, config, rules) {
                Err(Unfit::NonFinite(fault)) => return Err(fault),
                _ if silent => Some(HoldCause::HeartbeatLost),
                Err(Unfit::Missing) => Some(HoldCause::NoReference),
                Err(Unfit::NoRoom { joint }) => Some(HoldCause::NoRoom { joint }),
                Err(Unfit::OutOfReach { joint }) => Some(HoldCause::OutOfReach { joint }),
                Ok(reference) => {
                    self.reference = *reference;
                    None
                }
            },
            State::Armed if silent => Some(HoldCause::HeartbeatLost),
            _ => None,
        };
        if let Some(cause) = cause {
            self.state = State::Holding(cause);
        }
        let beyond = match self.state {
            State::Armed => S::literal(ARMED_REACH),
            State::Holding(_) => {
                self.reference = slowed(&self.reference, rules, &config.limits);
                S::literal(HOLDING_REACH)
            }
            _ => return Ok(()),
        };
        match astray(&self.reference, seen, rules, beyond) {
            Some(joint) if !self.gave_way => Err(Fault::FollowingError { joint }),
            _ => Ok(()),
        }
    }

    /// Call the controller, and hold its torque inside its limits and near the torque that acts.
    #[inline]
    fn drive(
        &mut self,
        inputs: &Inputs<S, N>,
        seen: &Seen<S, N>,
        start: bool,
        refused: Option<Refusal>,
        control: impl FnOnce(Ask<'_, S, N>) -> Command<S, N>,
    ) -> Output<S, N> {
        let (mut torque, mut limits) =
            match control(Ask { start, reference: &self.reference, q: &seen.q, qd: &seen.qd }) {
                Command::Drive { torque, limits } => (torque, limits),
                Command::Brake(fault) => return self.fail(fault, inputs.request),
            };
        // The controller limits its torque too, but from its first one on: it does not know the torque before.
        self.gave_way = limits.iter().any(|flags| flags.contains(LimitFlags::COLLISION));
        let config = self.config.get();
        let step = &config.torque_step;
        match hold_torques(&mut torque, &mut limits, &config.limits, &self.torque, step, step) {
            Ok(()) => {
                self.torque = torque;
                self.output(Actuation::Drive { torque, limits }, refused)
            }
            Err(fault) => self.fail(fault, inputs.request),
        }
    }

    #[cold]
    fn fail(&mut self, fault: Fault, request: Option<Request>) -> Output<S, N> {
        self.state = State::Fault(fault);
        self.safe(request.map(|_| Refusal::Fault(fault)))
    }

    /// Stop the torque and forget it.
    fn safe(&mut self, refused: Option<Refusal>) -> Output<S, N> {
        let zero = [S::zero(); N];
        (self.torque, self.reference.qdd, self.alone, self.gave_way) = (zero, zero, 0, false);
        self.output(Actuation::Safe(self.config.rules().safe_action), refused)
    }

    fn output(&self, actuation: Actuation<S, N>, refused: Option<Refusal>) -> Output<S, N> {
        Output { actuation, state: self.state, homed: self.homed, refused }
    }
}

/// How far the arm may be from where it holds, as a multiple of the joint's reach. A stop may begin because the reference is out
/// of reach, and the arm then needs room to come back.
const ARMED_REACH: f64 = 1.0;
const HOLDING_REACH: f64 = 1.5;

/// The first joint that is farther from the reference than this multiple of its reach.
#[inline]
fn astray<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    seen: &Seen<S, N>,
    rules: &Rules<S, N>,
    beyond: S,
) -> Option<u8> {
    for i in 0..N {
        let near = (reference.q[i] - seen.q[i]).abs() <= rules.joints[i].reach * beyond;
        if !near {
            return Some(i as u8);
        }
    }
    None
}

/// Fault from outside, in any state: the emergency stop first, then the board's other faults.
#[inline]
fn external<S: Real, const N: usize>(inputs: &Inputs<S, N>, rules: &Rules<S, N>) -> Option<Fault> {
    // False for NaN.
    let inside = |value: Option<S>, (lo, hi): (S, S)| value.is_none_or(|x| x >= lo && x <= hi);
    if inputs.emergency_stop {
        return Some(Fault::EmergencyStop);
    }
    if inputs.overrun {
        return Some(Fault::Overrun);
    }
    if let Some(joint) = inputs.drive_fault.iter().position(|fault| *fault) {
        return Some(Fault::DriveFault { joint: joint as u8 });
    }
    if !inside(inputs.supply, rules.supply) {
        return Some(Fault::SupplyOutOfBounds);
    }
    if !inside(inputs.temperature, rules.temperature) {
        return Some(Fault::TemperatureOutOfBounds);
    }
    None
}

/// Whether the measurement is free of faults and the arm at rest, as homing and arming need.
fn standing<S: Real, const N: usize>(seen: &Seen<S, N>, rules: &Rules<S, N>) -> Result<(), Refusal> {
    match seen.fault {
        Some(fault) => Err(Refusal::Implausible(fault)),
        None if !seen.at_rest(rules) => Err(Refusal::NotAtRest),
        None => Ok(()),
    }
}

/// The reference of this tick, if the arm can follow it: finite, with room to stop, and near the arm.
///
/// The reference must be able to stop at the joint's limit; the arm itself at the guard's bound.
#[inline]
fn fit<'a, S: Real, const N: usize>(
    inputs: &'a Inputs<S, N>,
    seen: &Seen<S, N>,
    config: &ControllerConfig<S, N>,
    rules: &Rules<S, N>,
) -> Result<&'a Reference<S, N>, Unfit> {
    let reference = inputs.reference.as_ref().ok_or(Unfit::Missing)?;
    // Loops, not iterators: for an iterator that is not inlined the compiler keeps the panic on the index.
    let (mut cramped, mut far) = (None, None);
    // A NaN or infinite acceleration shows in the sum.
    let mut sum = S::zero();
    for i in 0..N {
        let (lo, hi, _) = believed(config, i);
        let (q, qd) = (reference.q[i], reference.qd[i]);
        let (a, latency) = (rules.joints[i].deceleration, rules.latency);
        let room = can_stop(q, qd, config.limits[i].position, a, latency)
            && can_stop(seen.q[i], seen.qd[i], (lo, hi), a, latency);
        let near = (q - seen.q[i]).abs() <= rules.joints[i].reach;
        if !room {
            cramped = cramped.or(Some(i as u8));
        }
        if !near {
            far = far.or(Some(i as u8));
        }
        sum += reference.qdd[i] * S::zero();
    }
    match (cramped, far) {
        (None, None) if sum <= S::zero() => Ok(reference),
        _ => Err(match (name_reference(reference), cramped, far) {
            (Some(fault), ..) => Unfit::NonFinite(fault),
            (None, Some(joint), _) => Unfit::NoRoom { joint },
            (None, None, joint) => Unfit::OutOfReach { joint: joint.unwrap_or(0) },
        }),
    }
}
