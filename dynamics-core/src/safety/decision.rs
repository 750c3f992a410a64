//! The exact rules: from a tick's inputs to the decision and its reason, in every state.
//!
//! A tick that is not [ordinary](super::ordinary) is decided here, from the beginning.

use super::heat::FAULT;
use super::lowering::{drawn_back, followed, lowered};
use super::measured::{JudgedInput, Judgement, astray};
use super::memory::{Action, Decision, MachineMemory, Now};
use super::stop::{can_stop, slowed};
use super::{HoldCause, Inputs, LiveInput, Refusal, Request, Rules, State};
use crate::control::{
    ControllerConfig, Fault, LimitFlags, Reference, believed, hold_near, name_reference, reference_is_inside,
};
use crate::scalar::Real;

/// Reason why a reference is rejected.
enum Unfit {
    Missing,
    NonFinite(Fault),
    NoRoom { joint: u8 },
    OutOfReach { joint: u8 },
    FirstMotion { joint: u8 },
}

impl<S: Real, const N: usize> MachineMemory<S, N> {
    /// Applies every rule.
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
        self.homed &= !(jumped || inputs.zero_lost);
        let external = external(inputs, rules);

        if let State::Fault(fault) = self.state {
            return Decision::safe(match inputs.request {
                // No torque acts in a fault: the stop has already happened.
                None | Some(Request::Stop) => None,
                Some(Request::Clear) => self.clear(external, judged, seen, rules),
                Some(_) => Some(Refusal::Fault(fault)),
            });
        }
        let stop = (inputs.request == Some(Request::Stop)).then_some(Fault::EmergencyStop);
        let drove = self.state.has_torque();
        self.alone = if drove && silent { self.alone.saturating_add(1) } else { 0 };
        let fault = external.or(stop).or(self.of_drives(inputs)).or(if drove {
            judged.or(self.hasty(seen, config, rules))
        } else {
            None
        });
        if let Some(fault) = fault {
            return self.fail(fault, inputs.request);
        }
        if let Some(fault) = self.overheated()
            && self.let_go(fault, rules)
        {
            return self.fail(fault, inputs.request);
        }
        let alone = self.alone > rules.hold_max && !matches!(self.state, State::Lowering | State::Disarming);
        if alone && rules.rest.is_some() {
            (self.state, self.pace, self.along) = (State::Lowering, S::zero(), false);
            (self.settled, self.waited, self.waits) = (0, 0, false);
        } else if alone && self.let_go(Fault::HeartbeatLost, rules) {
            return self.fail(Fault::HeartbeatLost, inputs.request);
        }

        let refused = self.grant(now, judged, config, rules).err();
        if self.state == State::Arming {
            let decision = self.arming(now, judged, rules);
            self.hold_beyond_limits(config);
            return decision.refusing(refused);
        }
        if !self.state.has_torque() {
            return Decision::safe(refused);
        }
        match self.follow(now, config, rules) {
            Ok(()) if self.state.drives() => Decision { action: Action::Drive, refused },
            Ok(()) if self.state == State::Disarming => Decision { action: Action::Preload, refused },
            Ok(()) => Decision::safe(refused),
            Err(fault) => self.fail(fault, inputs.request),
        }
    }

    /// Share of its velocity limit that the reference may use.
    fn speed_share(&self, rules: &Rules<S, N>) -> S {
        self.first_motion(rules).unwrap_or(S::one())
    }

    /// Share of the limits that the arm may use before they are lifted; `None` once they are.
    #[inline]
    pub(super) fn first_motion(&self, rules: &Rules<S, N>) -> Option<S> {
        rules.first_motion.filter(|_| !self.full_range)
    }

    /// True if some motor is warm.
    #[inline]
    pub(super) fn is_warm(&self, rules: &Rules<S, N>) -> bool {
        rules.heat.is_some() && self.heats.warm != 0
    }

    /// Share of the torque limit that may act beyond the weight; `None` for all of it.
    #[inline]
    pub(super) fn beyond_weight(&self, rules: &Rules<S, N>) -> Option<S> {
        let first = self.first_motion(rules);
        if self.is_warm(rules) { Some(self.heats.left(first.unwrap_or(S::one()))) } else { first }
    }

    /// Flags the joints whose motors are warm.
    #[cold]
    pub(super) fn flag_warm(&self, limits: &mut [LimitFlags; N]) {
        for i in 0..N {
            limits[i] |= LimitFlags::HEAT.when(self.heats.warm & (1 << i) != 0);
        }
    }

    /// The first joint that is too fast for the first motion. Not applied in lowering and disarming: there the machine itself moves the arm, slowly
    /// and in a known direction. A joint that an obstacle releases is fast for a moment, and an arm without brakes would be dropped because of it.
    fn hasty(
        &self,
        seen: &JudgedInput<'_, S, N>,
        config: &ControllerConfig<S, N>,
        rules: &Rules<S, N>,
    ) -> Option<Fault> {
        let share = self.first_motion(rules)?;
        if matches!(self.state, State::Lowering | State::Disarming) {
            return None;
        }
        for i in 0..N {
            let (_, _, velocity_max) = believed(config, i);
            let slow = seen.qd[i].abs() <= share * velocity_max;
            if !slow {
                return Some(Fault::VelocityOutOfBounds { joint: i as u8 });
            }
        }
        None
    }

    /// Fault of the drives while torque acts or is about to.
    fn of_drives(&self, inputs: &Inputs<S, N>) -> Option<Fault> {
        if !self.state.has_or_awaits_torque() {
            return None;
        }
        if inputs.zero_lost {
            return Some(Fault::ZeroLost);
        }
        match inputs.on.iter().position(|on| !*on) {
            Some(joint) if self.state != State::Arming => Some(Fault::DriveOff { joint: joint as u8 }),
            _ => None,
        }
    }

    /// The fault of a motor that is too hot while torque acts or is about to. A motor of an arm that is being disarmed cools soon.
    fn overheated(&self) -> Option<Fault> {
        let acts = self.state.drives() || self.state == State::Arming;
        if acts { self.heats.above(FAULT).map(|joint| Fault::Overheated { joint }) } else { None }
    }

    /// Raises the fault. The request is rejected because of it, unless it was the stop.
    pub(super) fn fail(&mut self, fault: Fault, request: Option<Request>) -> Decision {
        self.state = State::Fault(fault);
        Decision::safe(request.filter(|request| *request != Request::Stop).map(|_| Refusal::Fault(fault)))
    }

    /// Clears the torque: it has ended.
    pub(super) fn rest(&mut self) {
        let zero = [S::zero(); N];
        (self.torque, self.reference.qdd, self.alone, self.gave_way, self.held) = (zero, zero, 0, false, None);
        (self.along, self.ends_in, self.waits) = (false, None, false);
    }

    /// Leaves the fault if its cause is gone and nothing would raise a fault again at once.
    fn clear(
        &mut self,
        external: Option<Fault>,
        judged: Option<Fault>,
        seen: &JudgedInput<'_, S, N>,
        rules: &Rules<S, N>,
    ) -> Option<Refusal> {
        let judged = match judged {
            // Without a known zero a position has no meaning, and only an idle machine can be homed. So this fault does not block the clear.
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

    /// Carries out the request, or returns why it is rejected.
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
                (self.homed, self.full_range) = (true, rules.first_motion.is_none());
                self.state = State::Idle;
            }
            (State::Idle, Request::Arm) => {
                if !self.homed {
                    return Err(Refusal::NotHomed);
                }
                standing(seen, judged, rules)?;
                if let Some(joint) = self.heats.above(1.0) {
                    return Err(Refusal::Fault(Fault::Overheated { joint }));
                }
                if silent {
                    return Err(Refusal::HeartbeatLost);
                }
                if rules.live != 0 && inputs.live_age == u32::MAX {
                    return Err(Refusal::MissingInput(LiveInput::first(rules.live)));
                }
                if inputs_are_old(inputs, rules) {
                    return Err(Refusal::StaleInput(LiveInput::first(rules.live)));
                }
                self.begin_arming(seen.q);
            }
            (State::Homing, Request::Disarm) => self.state = State::Idle,
            (State::Arming, request) if Self::ends_arming(request) => self.state = State::Idle,
            (State::Armed | State::Holding(_), Request::Disarm) => {
                if !seen.at_rest(rules) {
                    return Err(Refusal::NotAtRest);
                }
                self.disarm(rules);
            }
            (State::Armed | State::Holding(_), Request::Run) => {
                if silent {
                    return Err(Refusal::HeartbeatLost);
                }
                // The rest of the path can be followed at its own pace only after a new start.
                if self.along {
                    return Err(Refusal::NotAtRest);
                }
                if inputs_are_old(inputs, rules) {
                    return Err(Refusal::StaleInput(LiveInput::first(rules.live)));
                }
                let reference = fit(now, config, rules, self.speed_share(rules)).map_err(|unfit| match unfit {
                    Unfit::Missing => Refusal::NoReference,
                    Unfit::NonFinite(fault) => Refusal::Implausible(fault),
                    Unfit::NoRoom { joint } => Refusal::NoRoom { joint },
                    Unfit::OutOfReach { joint } => Refusal::OutOfReach { joint },
                    Unfit::FirstMotion { joint } => Refusal::FirstMotion { joint },
                })?;
                for i in 0..N {
                    let near = (reference.qd[i] - seen.qd[i]).abs() <= rules.joints[i].reach_speed;
                    if !near {
                        return Err(Refusal::OutOfReach { joint: i as u8 });
                    }
                }
                (self.state, self.waits) = (State::Running, false);
            }
            (State::Idle | State::Armed | State::Holding(_), Request::FullRange) => {
                if !self.homed {
                    return Err(Refusal::NotHomed);
                }
                // Torque that the limit holds back would act at once.
                let held_back = self.limits.iter().any(|flags| flags.contains(LimitFlags::TORQUE));
                let free = stands(&self.reference) && seen.at_rest(rules) && !held_back;
                if self.state != State::Idle && !free {
                    return Err(Refusal::NotAtRest);
                }
                self.full_range = true;
            }
            (State::Running, Request::Hold) => {
                self.state = State::Holding(HoldCause::Requested);
                self.stop_along(!now.hand_guided, rules);
            }
            // A second hold request stops an arm joint by joint that was stopping along its path.
            (State::Holding(_), Request::Hold) if self.along => self.along = false,
            (State::Lowering, Request::Hold) => {
                (self.state, self.waits) = (State::Holding(HoldCause::Requested), true);
            }
            _ => return Err(Refusal::WrongState),
        }
        Ok(())
    }

    /// Finds the reference of this tick: the host's, or that of a stop.
    fn follow(
        &mut self,
        now: &Now<'_, S, N>,
        config: &ControllerConfig<S, N>,
        rules: &Rules<S, N>,
    ) -> Result<(), Fault> {
        let Now { inputs, seen, silent, hand_guided, .. } = *now;
        self.held = None;
        let drove_along = self.state == State::Running && !hand_guided;
        let cause = match self.state {
            State::Running => match fit(now, config, rules, self.speed_share(rules)) {
                Err(Unfit::NonFinite(fault)) => return Err(fault),
                _ if silent => Some(HoldCause::HeartbeatLost),
                Err(Unfit::Missing) => Some(HoldCause::NoReference),
                Err(Unfit::NoRoom { joint }) => Some(HoldCause::NoRoom { joint }),
                Err(Unfit::OutOfReach { joint }) => Some(HoldCause::OutOfReach { joint }),
                Err(Unfit::FirstMotion { joint }) => Some(HoldCause::FirstMotion { joint }),
                Ok(_) if inputs_are_old(inputs, rules) => Some(HoldCause::StaleInput),
                Ok(reference) => {
                    if reference_is_inside(reference, &config.limits) {
                        self.reference = *reference;
                    } else {
                        let mut flags = [LimitFlags::NONE; N];
                        let near = if hand_guided { &reference.q } else { &self.reference.q };
                        self.reference = hold_near(reference, near, &config.limits, &mut flags);
                        self.held = Some(flags);
                    }
                    return Ok(());
                }
            },
            State::Armed if silent => Some(HoldCause::HeartbeatLost),
            _ => None,
        };
        if let Some(cause) = cause {
            self.state = State::Holding(cause);
            let on_path = matches!(cause, HoldCause::HeartbeatLost | HoldCause::StaleInput) && drove_along;
            self.stop_along(on_path, rules);
        }
        let beyond = match self.state {
            State::Armed => S::literal(ARMED_REACH),
            State::Holding(_) => {
                self.along_left -= rules.period;
                let in_time = self.along_left > S::zero();
                let along = if self.along && in_time { fit(now, config, rules, S::one()).ok() } else { None };
                self.reference = match along {
                    Some(reference) => {
                        self.along = !rests(reference);
                        hold_near(reference, &self.reference.q, &config.limits, &mut [LimitFlags::NONE; N])
                    }
                    // The path has ended, or leads to where the arm cannot go.
                    None => {
                        self.along = false;
                        slowed(&self.reference, rules, &config.limits)
                    }
                };
                if self.waits && stands(&self.reference) {
                    self.relieve(seen, rules);
                }
                S::literal(HOLDING_REACH)
            }
            State::Lowering => {
                self.lower(seen, config, rules)?;
                S::literal(HOLDING_REACH)
            }
            State::Disarming => {
                if self.arming.ticks >= rules.brake_delay {
                    self.state = State::Idle;
                    return self.ends_in.map_or(Ok(()), Err);
                }
                self.reference = slowed(&self.reference, rules, &config.limits);
                S::literal(HOLDING_REACH)
            }
            _ => return Ok(()),
        };
        self.hold_beyond_limits(config);
        match astray(&self.reference, seen, rules, beyond) {
            Some(joint) if !self.gave_way => Err(Fault::FollowingError { joint }),
            _ => Ok(()),
        }
    }

    /// Begins a stop along the path, or joint by joint. On some paths a joint can hardly be slowed down. So the stop leaves the path after twice
    /// the time that the joints need when each stops alone.
    fn stop_along(&mut self, on_path: bool, rules: &Rules<S, N>) {
        self.along = on_path;
        let mut longest = S::zero();
        for i in 0..N {
            let own = self.reference.qd[i].abs() / rules.joints[i].deceleration;
            longest = if own > longest { own } else { longest };
        }
        self.along_left = S::literal(2.0) * longest + S::literal(4.0) * rules.period;
    }

    /// Holds an arm that was armed beyond a limit at its position, instead of pushing it to the limit.
    fn hold_beyond_limits(&mut self, config: &ControllerConfig<S, N>) {
        self.held = None;
        if !reference_is_inside(&self.reference, &config.limits) {
            let mut flags = [LimitFlags::NONE; N];
            self.reference = hold_near(&self.reference, &self.reference.q, &config.limits, &mut flags);
            self.held = Some(flags);
        }
    }

    /// Ends torque in an orderly way; returns the fault if torque ends in this tick.
    fn end(&mut self, fault: Fault, rules: &Rules<S, N>) -> Result<(), Fault> {
        if self.let_go(fault, rules) { Err(fault) } else { Ok(()) }
    }

    /// Draws the reference back for an arm that was put on hold while it was lowered, so that it does not push an obstacle for ever. Only for a
    /// bounded time: the reference must not follow a joint that sinks under its load down to the ground.
    #[cold]
    #[inline(never)]
    fn relieve(&mut self, seen: &JudgedInput<'_, S, N>, rules: &Rules<S, N>) {
        self.waited = self.waited.saturating_add(1);
        self.waits = !too_long(self.waited, rules);
        drawn_back(&mut self.reference, seen, rules);
    }

    /// Computes the next reference on the path to the rest pose. Returns [`Fault::HeartbeatLost`] once the arm is there, and
    /// [`Fault::FollowingError`] if the total wait for joints was too long: something blocks the arm, or it is too weak for its load.
    fn lower(
        &mut self,
        seen: &JudgedInput<'_, S, N>,
        config: &ControllerConfig<S, N>,
        rules: &Rules<S, N>,
    ) -> Result<(), Fault> {
        // Without a rest pose there is no lowering.
        let Some(rest) = &rules.rest else { return Err(Fault::HeartbeatLost) };
        let (share, joint) = followed(&mut self.waits, &self.reference, seen, rules);
        if self.waits {
            self.waited = self.waited.saturating_add(1);
            if too_long(self.waited, rules) {
                return self.end(Fault::FollowingError { joint }, rules);
            }
            if stands(&self.reference) {
                self.pace = S::zero();
                drawn_back(&mut self.reference, seen, rules);
                return Ok(());
            }
        }
        match lowered(&self.reference, &mut self.pace, share, rest, rules, &config.limits) {
            Some(next) => {
                // The speed is too low for single precision: the arm would never arrive.
                let stuck = !self.waits && self.pace >= share && next.q == self.reference.q;
                self.reference = next;
                self.settled = self.settled.saturating_add(u32::from(stuck));
                if stuck && too_long(self.settled, rules) { self.end(Fault::HeartbeatLost, rules) } else { Ok(()) }
            }
            None => {
                self.settled = self.settled.saturating_add(1);
                // The arm follows a little later. If it does not come to rest there, torque ends after the time for which it may hold without a host.
                let there = astray(&self.reference, seen, rules, S::literal(REST_REACH)).is_none();
                let over = (there && seen.at_rest(rules)) || too_long(self.settled, rules);
                self.reference = Reference::at_rest(*rest);
                if over { self.end(Fault::HeartbeatLost, rules) } else { Ok(()) }
            }
        }
    }
}

/// Longest total wait of lowering for joints, and longest wait for the arm to come to rest at the end, s; a shorter [`Rules::hold_max`] takes
/// precedence. An arm without a host must not press against something for longer.
const WAIT_MAX: f64 = 0.5;

/// True if this many ticks are more than an arm without a host may press against something.
fn too_long<S: Real, const N: usize>(ticks: u32, rules: &Rules<S, N>) -> bool {
    let few = S::from_i32(ticks.min(i32::MAX as u32) as i32);
    ticks > rules.hold_max || few * rules.period > S::literal(WAIT_MAX)
}

/// True if a reference has no speed.
fn stands<S: Real, const N: usize>(reference: &Reference<S, N>) -> bool {
    (0..N).all(|i| reference.qd[i] == S::zero())
}

/// True if a reference does not move.
fn rests<S: Real, const N: usize>(reference: &Reference<S, N>) -> bool {
    (0..N).all(|i| reference.qd[i] == S::zero() && reference.qdd[i] == S::zero())
}

/// True if the live inputs are older than the arm may run with.
fn inputs_are_old<S, const N: usize>(inputs: &Inputs<S, N>, rules: &Rules<S, N>) -> bool {
    rules.live != 0 && rules.live_max != 0 && inputs.live_age > rules.live_max
}

/// Greatest distance of the arm from its reference in `Armed`, and while it holds or is lowered, as a multiple of the joint's reach. A stop may
/// begin because the reference is out of reach; the arm then needs a margin to come back.
const ARMED_REACH: f64 = 1.0;
const HOLDING_REACH: f64 = 1.5;

/// Greatest distance from the rest pose at which the torque is removed, as a multiple of the joint's reach.
const REST_REACH: f64 = 0.05;

/// The fault from outside in any state: the emergency stop first, then the board's other faults.
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

/// Checks that the measurement is free of faults and the arm at rest, as homing and arming need.
fn standing<S: Real, const N: usize>(
    seen: &JudgedInput<'_, S, N>,
    judged: Option<Fault>,
    rules: &Rules<S, N>,
) -> Result<(), Refusal> {
    match judged {
        Some(fault) => Err(Refusal::Implausible(fault)),
        None if !seen.at_rest(rules) => Err(Refusal::NotAtRest),
        None => Ok(()),
    }
}

/// The reference of this tick, if the arm can follow it: finite, with enough distance to stop, and near the arm.
///
/// The reference must be able to stop at the joint's limit; the arm itself at the guard's bound.
fn fit<'a, S: Real, const N: usize>(
    now: &Now<'a, S, N>,
    config: &ControllerConfig<S, N>,
    rules: &Rules<S, N>,
    speed_share: S,
) -> Result<&'a Reference<S, N>, Unfit> {
    let seen = now.seen;
    let reference = now.reference.ok_or(Unfit::Missing)?;
    // Loops, not iterators: for an iterator that is not inlined the compiler keeps the panic on the index.
    let (mut cramped, mut far, mut hasty) = (None, None, None);
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
        if speed_share < S::one() && qd.abs() > speed_share * config.limits[i].velocity {
            hasty = hasty.or(Some(i as u8));
        }
        sum += reference.qdd[i] * S::zero();
    }
    match (cramped, far) {
        (None, None) if sum <= S::zero() => match hasty {
            None => Ok(reference),
            Some(joint) => Err(Unfit::FirstMotion { joint }),
        },
        _ => Err(match (name_reference(reference), cramped, far) {
            (Some(fault), ..) => Unfit::NonFinite(fault),
            (None, Some(joint), _) => Unfit::NoRoom { joint },
            (None, None, joint) => Unfit::OutOfReach { joint: joint.unwrap_or(0) },
        }),
    }
}
