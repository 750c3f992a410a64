//! The exact rules: what follows from a tick's inputs in every state, and why.
//!
//! A tick that is not [ordinary](super::ordinary) comes here, and is decided from the beginning.

use super::measured::{Judgement, Seen, Sensors};
use super::stop::{can_stop, slowed};
use super::{HoldCause, Inputs, Refusal, Request, Rules, State};
use crate::control::{ControllerConfig, Fault, LimitFlags, Reference, believed, name_reference};
use crate::scalar::Real;

/// State of the machine from tick to tick, but for the observer's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Memory<S, const N: usize> {
    pub(super) state: State,
    pub(super) homed: bool,
    pub(super) sensors: Sensors<S, N>,
    /// Reference of the controller while torque acts.
    pub(super) reference: Reference<S, N>,
    /// The torque that acts, and the limits that held it.
    pub(super) torque: [S; N],
    pub(super) limits: [LimitFlags; N],
    /// Ticks that torque has acted without the host.
    pub(super) alone: u32,
    /// The controller gave way to a collision in the last tick, and did not follow its reference.
    pub(super) gave_way: bool,
}

/// What a tick has to go by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Now<'a, S, const N: usize> {
    pub(super) inputs: &'a Inputs<S, N>,
    /// The host's reference, or that of an arm that is led by hand.
    pub(super) reference: Option<&'a Reference<S, N>>,
    pub(super) seen: &'a Seen<'a, S, N>,
    /// The host has not been heard for too long.
    pub(super) silent: bool,
}

/// What follows from the rules, and the request that was not granted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Decision {
    /// Torque may act, along the memory's reference.
    Drive(Option<Refusal>),
    /// The safe action.
    Safe(Option<Refusal>),
}

/// Reason why a reference is refused.
enum Unfit {
    Missing,
    NonFinite(Fault),
    NoRoom { joint: u8 },
    OutOfReach { joint: u8 },
}

impl<S: Real, const N: usize> Memory<S, N> {
    /// Idle, not homed.
    pub(super) fn new() -> Self {
        let zero = [S::zero(); N];
        Self {
            state: State::Idle,
            homed: false,
            sensors: Sensors::new(),
            reference: Reference { q: zero, qd: zero, qdd: zero },
            torque: zero,
            limits: [LimitFlags::NONE; N],
            alone: 0,
            gave_way: false,
        }
    }

    /// The next tick of an arm that goes on. Out of line the compiler knows that nothing overlaps, and copies without a call.
    #[inline(never)]
    pub(super) fn go_on(&mut self, read: &[S; N], reference: &Reference<S, N>) {
        self.sensors.last = *read;
        self.reference.q = reference.q;
        self.reference.qd = reference.qd;
        self.reference.qdd = reference.qdd;
        self.alone = 0;
    }

    /// Apply every rule.
    #[cold]
    #[inline(never)]
    pub(super) fn decide(
        &mut self,
        now: &Now<'_, S, N>,
        config: &ControllerConfig<S, N>,
        rules: &Rules<S, N>,
    ) -> Decision {
        let Now { inputs, seen, silent, .. } = *now;
        let Judgement { fault: judged, jumped } = self.sensors.judge(inputs, seen, config, rules);
        self.homed &= !jumped;
        let external = external(inputs, rules);

        if let State::Fault(fault) = self.state {
            return Decision::Safe(match inputs.request {
                None => None,
                Some(Request::Clear) => self.clear(external, judged, seen, rules),
                Some(_) => Some(Refusal::Fault(fault)),
            });
        }
        let drove = self.state.drives();
        self.alone = if drove && silent { self.alone.saturating_add(1) } else { 0 };
        let fault = external.or(if drove { judged } else { None }).or(if self.alone > rules.hold_max {
            Some(Fault::HeartbeatLost)
        } else {
            None
        });
        if let Some(fault) = fault {
            return self.fail(fault, inputs.request);
        }

        let refused = self.grant(now, judged, config, rules).err();
        if !self.state.drives() {
            return Decision::Safe(refused);
        }
        match self.follow(now, config, rules) {
            Ok(()) => Decision::Drive(refused),
            Err(fault) => self.fail(fault, inputs.request),
        }
    }

    /// The fault is in force, and the request is refused for it.
    pub(super) fn fail(&mut self, fault: Fault, request: Option<Request>) -> Decision {
        self.state = State::Fault(fault);
        Decision::Safe(request.map(|_| Refusal::Fault(fault)))
    }

    /// Forget the torque: it has ended.
    pub(super) fn rest(&mut self) {
        let zero = [S::zero(); N];
        (self.torque, self.reference.qdd, self.alone, self.gave_way) = (zero, zero, 0, false);
    }

    /// Leave the fault when its cause is gone, and nothing would raise a fault again at once.
    fn clear(
        &mut self,
        external: Option<Fault>,
        judged: Option<Fault>,
        seen: &Seen<'_, S, N>,
        rules: &Rules<S, N>,
    ) -> Option<Refusal> {
        let judged = match judged {
            // Without a known zero a position has no meaning, and only an idle machine can be homed.
            Some(Fault::PositionOutOfBounds { .. }) if !self.homed => None,
            fault => fault,
        };
        if let Some(fault) = external.or(judged) {
            return Some(Refusal::Fault(fault));
        }
        if !seen.at_rest(rules) {
            return Some(Refusal::NotAtRest);
        }
        self.state = State::Idle;
        None
    }

    /// Do as requested, or say why not.
    fn grant(
        &mut self,
        now: &Now<'_, S, N>,
        judged: Option<Fault>,
        config: &ControllerConfig<S, N>,
        rules: &Rules<S, N>,
    ) -> Result<(), Refusal> {
        let Now { inputs, seen, silent, .. } = *now;
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
                standing(seen, judged, rules)?;
                self.homed = true;
                self.state = State::Idle;
            }
            (State::Idle, Request::Arm) => {
                if !self.homed {
                    return Err(Refusal::NotHomed);
                }
                standing(seen, judged, rules)?;
                if silent {
                    return Err(Refusal::HeartbeatLost);
                }
                self.reference = Reference::at_rest(*seen.q);
                self.state = State::Armed;
            }
            (State::Homing, Request::Disarm) => self.state = State::Idle,
            (State::Armed | State::Holding(_), Request::Disarm) => {
                if !seen.at_rest(rules) {
                    return Err(Refusal::NotAtRest);
                }
                self.state = State::Idle;
            }
            (State::Armed | State::Holding(_), Request::Run) => {
                if silent {
                    return Err(Refusal::HeartbeatLost);
                }
                let reference = fit(now, config, rules).map_err(|unfit| match unfit {
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
    fn follow(
        &mut self,
        now: &Now<'_, S, N>,
        config: &ControllerConfig<S, N>,
        rules: &Rules<S, N>,
    ) -> Result<(), Fault> {
        let Now { seen, silent, .. } = *now;
        let cause = match self.state {
            State::Running => match fit(now, config, rules) {
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
}

/// How far the arm may be from where it holds, as a multiple of the joint's reach. A stop may begin because the reference is out
/// of reach, and the arm then needs room to come back.
const ARMED_REACH: f64 = 1.0;
const HOLDING_REACH: f64 = 1.5;

/// The first joint that is farther from the reference than this multiple of its reach.
fn astray<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    seen: &Seen<'_, S, N>,
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
fn standing<S: Real, const N: usize>(
    seen: &Seen<'_, S, N>,
    judged: Option<Fault>,
    rules: &Rules<S, N>,
) -> Result<(), Refusal> {
    match judged {
        Some(fault) => Err(Refusal::Implausible(fault)),
        None if !seen.at_rest(rules) => Err(Refusal::NotAtRest),
        None => Ok(()),
    }
}

/// The reference of this tick, if the arm can follow it: finite, with room to stop, and near the arm.
///
/// The reference must be able to stop at the joint's limit; the arm itself at the guard's bound.
fn fit<'a, S: Real, const N: usize>(
    now: &Now<'a, S, N>,
    config: &ControllerConfig<S, N>,
    rules: &Rules<S, N>,
) -> Result<&'a Reference<S, N>, Unfit> {
    let seen = now.seen;
    let reference = now.reference.ok_or(Unfit::Missing)?;
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
