//! Who says whether a command was safe: from what `docs/safety.md` says, without a line of the machine that it judges.
//!
//! After every tick it is shown what the machine was told, what the host may have asked for, and what the machine did. It keeps its own
//! account of homing, latched faults, acting torque and silence. Numbers (limits, guards, times) are the scene's; arithmetic is f64.

mod eyes;

use super::host::Sent;
use super::machine::{Said, Told};
use crate::session::states::{self, ARMED, FAULT, HOLDING, HOMING, IDLE, RUNNING};
use dynamics_core::ControllerConfig;
use dynamics_core::safety::{Rules, SafeAction};
use eyes::{Eyes, Seen, beyond};
use link::{Actuation, Request, Status};
use serde::Serialize;
use session::Drives;

/// What an unsafe command breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// Torque is a number.
    Finite,
    /// Torque is inside its limit.
    Limit,
    /// Torque changes by no more than its rate allows, and rises from nothing.
    Rate,
    /// Torque acts in Armed, Running and Holding alone; elsewhere the robot's safe action does.
    SafeAction,
    /// No torque before the joints were homed and confirmed.
    Homed,
    /// No torque in a tick whose inputs are at fault, and the machine is in its fault then.
    Fault,
    /// Of several faults of the board the first of the list is named.
    Named,
    /// A fault stays until a clear that nothing stands against.
    Latched,
    /// No state is left but along the diagram, by a request or for a stated cause.
    Transition,
    /// A silent host is noticed in time.
    Silence,
    /// The reference that is followed is a number, within reach, and can stop.
    Reference,
    /// A reference beyond a limit is held, and flagged.
    Held,
    /// An arm that holds comes to rest.
    Rest,
    /// What the drives do is what is reported.
    Reported,
    /// The arm can be simulated to the end.
    RanAway,
}

/// An unsafe command.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unsafe {
    /// What it breaks.
    pub law: Law,
    /// With its numbers.
    pub what: String,
}

/// Says that this is broken.
fn broken(law: Law, what: impl Into<String>) -> Result<(), Unsafe> {
    Err(Unsafe { law, what: what.into() })
}

/// The judge of one run.
#[derive(Clone, Debug)]
pub(super) struct Judge<const N: usize> {
    config: ControllerConfig<f64, N>,
    rules: Rules<f64, N>,
    eyes: Eyes<N>,
    now: i64,
    /// State and cause of the tick before.
    before: (u8, u8),
    homed: bool,
    /// The torque that acted in the tick before, N m or N.
    torque: Option<[f64; N]>,
    /// Ticks in a row that torque has acted.
    acted: usize,
    /// Ticks since the host may have been heard.
    silent: u32,
    /// Ticks in a row that the arm has held.
    held: u32,
    /// Ticks after which an arm that holds rests.
    rest_after: u32,
    /// Whether what is measured and what the model knows is true, so that holding must lead to rest.
    pub(super) trusts: bool,
}

impl<const N: usize> Judge<N> {
    /// A judge of a machine that has just been started.
    pub(super) fn new(config: &ControllerConfig<f64, N>, rules: &Rules<f64, N>) -> Self {
        let stop = |i: usize| {
            let velocity = config.limits[i].velocity;
            let slowing = if velocity.is_finite() { velocity / rules.joints[i].deceleration } else { 1.0 };
            // The error that is left of the way: at five time constants 4 % of its speed.
            slowing + 5.0 / config.gains[i].position.sqrt() + 0.02
        };
        let rest = (0..N).map(stop).fold(0.0, f64::max);
        Self {
            config: *config,
            rules: *rules,
            eyes: Eyes::new(config),
            now: 0,
            before: (IDLE, 0),
            homed: false,
            torque: None,
            acted: 0,
            silent: u32::MAX,
            held: 0,
            rest_after: (rest / rules.period).ceil() as u32,
            trusts: true,
        }
    }

    /// Judge a tick.
    ///
    /// # Errors
    /// [`Unsafe`]: the first law that is broken.
    pub(super) fn watch(&mut self, told: &Told<N>, sent: &Sent, said: &Said<N>) -> Result<(), Unsafe> {
        self.now += 1;
        self.silent = if sent.spoke { 0 } else { self.silent.saturating_add(1) };
        let seen = self.eyes.look(self.now, told, &self.config, &self.rules, self.acted);
        let board = self.board(told);
        let status = &said.status;
        if seen.faults.contains(&8) {
            self.homed = false;
        }

        self.reported(said)?;
        self.moved(told, sent, status)?;
        self.torque(said)?;
        self.faults(&board, &seen, said)?;
        self.silence(said)?;
        self.reference(&seen, status)?;
        self.rest(status)?;

        self.before = (status.state, status.cause);
        self.torque = torque(&said.drives);
        self.acted = if self.torque.is_some() { self.acted + 1 } else { 0 };
        Ok(())
    }

    /// What is wrong on the board, by code, in the order in which it is named.
    fn board(&self, told: &Told<N>) -> Vec<u8> {
        let outside = |value: Option<f32>, (low, high): (f64, f64)| {
            value.map(f64::from).is_some_and(|x| x.is_nan() || x < low || x > high)
        };
        [
            (9, told.emergency_stop),
            (6, told.overrun),
            (11, told.drive_fault.contains(&true)),
            (12, outside(told.supply, self.rules.supply)),
            (13, outside(told.temperature, self.rules.temperature)),
        ]
        .into_iter()
        .filter_map(|(code, wrong)| wrong.then_some(code))
        .collect()
    }

    /// Law of the report.
    fn reported(&self, said: &Said<N>) -> Result<(), Unsafe> {
        let same = match (&said.drives, &said.status.actuation) {
            (Drives::Drive(torque), Some(Actuation::Drive { torque: reported, .. })) => {
                reported.len() == N && torque.iter().zip(reported).all(|(a, b)| a.to_bits() == b.to_bits())
            }
            (Drives::Safe(SafeAction::Brake), Some(Actuation::Brake))
            | (Drives::Safe(SafeAction::DampedStop), Some(Actuation::DampedStop))
            | (Drives::Safe(SafeAction::Off), Some(Actuation::Off)) => true,
            _ => false,
        };
        if same {
            return Ok(());
        }
        broken(Law::Reported, format!("the drives do {:?}, reported is {:?}", said.drives, said.status.actuation))
    }

    /// Laws of the states: how one leads to another, and what of it takes a homing.
    fn moved(&mut self, told: &Told<N>, sent: &Sent, status: &Status) -> Result<(), Unsafe> {
        let asked = |request| sent.requests.contains(&request);
        let (before, now) = (self.before.0, status.state);
        if before == FAULT && now == FAULT && status.cause != self.before.1 {
            return broken(Law::Latched, format!("fault {} became fault {}", self.before.1, status.cause));
        }
        let allowed = states::may_lead(self.before, status, asked);
        if !allowed && before == FAULT {
            return broken(Law::Latched, format!("fault {} was left for state {now}", self.before.1));
        }
        if !allowed {
            return broken(
                Law::Transition,
                format!("state {before} to {now}, cause {}, asked for {:?}", status.cause, sent.requests),
            );
        }
        match (before, now) {
            (IDLE, HOMING) => self.homed = false,
            (HOMING, IDLE) if status.homed => self.homed = asked(Request::Confirm) && told.zeroed,
            _ => {}
        }
        if status.homed && !self.homed {
            return broken(Law::Homed, "it takes itself for homed, and is not");
        }
        Ok(())
    }

    /// Laws of the torque by itself.
    fn torque(&self, said: &Said<N>) -> Result<(), Unsafe> {
        let state = said.status.state;
        let Some(torque) = torque(&said.drives) else {
            if matches!(state, ARMED | RUNNING | HOLDING) {
                return broken(Law::SafeAction, format!("no torque in state {state}"));
            }
            return match said.drives {
                Drives::Safe(action) if action != self.rules.safe_action => {
                    broken(Law::SafeAction, format!("{action:?} in place of {:?}", self.rules.safe_action))
                }
                _ => Ok(()),
            };
        };
        if !matches!(state, ARMED | RUNNING | HOLDING) {
            return broken(Law::SafeAction, format!("torque in state {state}"));
        }
        if !self.homed {
            return broken(Law::Homed, "torque, and the arm is not homed");
        }
        for i in 0..N {
            let (tau, limit) = (torque[i], self.config.limits[i].torque);
            let (last, step) = (self.torque.map_or(0.0, |torque| torque[i]), self.config.torque_step[i]);
            if !tau.is_finite() {
                return broken(Law::Finite, format!("joint {}: torque {tau}", i + 1));
            }
            if beyond(tau.abs(), limit) {
                return broken(Law::Limit, format!("joint {}: torque {tau}, limit {limit}", i + 1));
            }
            if beyond((tau - last).abs(), step) {
                return broken(Law::Rate, format!("joint {}: torque {tau} after {last}, step {step}", i + 1));
            }
        }
        Ok(())
    }

    /// Laws of the faults: none is driven over, each is named, and what stands is not cleared.
    fn faults(&self, board: &[u8], seen: &Seen<N>, said: &Said<N>) -> Result<(), Unsafe> {
        let status = &said.status;
        let (before, now) = (self.before.0, status.state);
        let drove = matches!(before, ARMED | RUNNING | HOLDING);
        let all = || board.iter().chain(&seen.faults);
        if let Some(code) = all().next()
            && (torque(&said.drives).is_some() || (drove && now != FAULT))
        {
            return broken(Law::Fault, format!("state {now} in spite of fault {code}"));
        }
        if let Some(first) = board.first() {
            if now != FAULT {
                return broken(Law::Fault, format!("state {now} in spite of fault {first}"));
            }
            if before != FAULT && status.cause != *first {
                return broken(Law::Named, format!("fault {} in place of {first}", status.cause));
            }
        }
        let starts = (before, now) == (IDLE, ARMED) || (before == HOMING && now == IDLE && status.homed);
        let cleared = (before, now) == (FAULT, IDLE);
        // Where zero is not known no position says anything.
        let stands = seen.faults.iter().find(|code| !cleared || **code != 4 || status.homed);
        if (cleared || starts)
            && let Some(code) = stands
        {
            return broken(Law::Latched, format!("state {before} to {now} while fault {code} stands"));
        }
        if seen.moves && (cleared || starts || (drove && now == IDLE)) {
            return broken(Law::Transition, format!("state {before} to {now} in motion"));
        }
        Ok(())
    }

    /// Law of the host's silence.
    fn silence(&self, said: &Said<N>) -> Result<(), Unsafe> {
        let Rules { heartbeat_max, hold_max, .. } = self.rules;
        let (state, silent) = (said.status.state, self.silent);
        if silent > heartbeat_max && matches!(state, ARMED | RUNNING) {
            return broken(Law::Silence, format!("state {state} after {silent} ticks without the host"));
        }
        if silent > heartbeat_max.saturating_add(hold_max) && torque(&said.drives).is_some() {
            return broken(Law::Silence, format!("torque after {silent} ticks without the host"));
        }
        Ok(())
    }

    /// Laws of the reference that is followed.
    fn reference(&self, seen: &Seen<N>, status: &Status) -> Result<(), Unsafe> {
        if status.state != RUNNING {
            return Ok(());
        }
        let (Some(reference), Some(Actuation::Drive { limits, .. })) = (&status.reference, &status.actuation) else {
            return broken(Law::Reference, "it runs without a reference");
        };
        for i in 0..N {
            let at = |list: &link::Joints<f32>| list.get(i).map_or(f64::NAN, |x| f64::from(*x));
            let (q, qd, qdd) = (at(&reference.q), at(&reference.qd), at(&reference.qdd));
            if !(q.is_finite() && qd.is_finite() && qdd.is_finite()) {
                return broken(Law::Reference, format!("joint {}: reference {q}, {qd}, {qdd}", i + 1));
            }
            let joint = &self.rules.joints[i];
            // The machine measures the way from its observer's estimate, which may be behind by what is no jump yet.
            let lag = 2.0 * joint.jump_step.min(1.0) + joint.resolution;
            if let Some(position) = seen.position
                && beyond((q - position[i]).abs(), joint.reach + lag)
            {
                return broken(Law::Reference, format!("joint {}: reference {q}, the arm at {}", i + 1, position[i]));
            }
            let (low, high) = self.config.limits[i].position;
            let room = if qd > 0.0 { high - q } else { q - low };
            let way = qd.abs() * self.rules.latency + qd * qd / (2.0 * joint.deceleration);
            if qd.abs() > 1e-4 && beyond(way, room) {
                return broken(Law::Reference, format!("joint {}: needs {way} to stop, has {room}", i + 1));
            }
            let flags = limits.get(i).copied().unwrap_or(0);
            let outside = beyond(q, high) || beyond(low, q);
            let fast = beyond(qd.abs(), self.config.limits[i].velocity);
            if (outside && flags & 1 == 0) || (fast && flags & 2 == 0) {
                return broken(Law::Held, format!("joint {}: reference {q}, {qd} is followed, flags {flags}", i + 1));
            }
        }
        Ok(())
    }

    /// Law of rest.
    fn rest(&mut self, status: &Status) -> Result<(), Unsafe> {
        self.held = if status.state == HOLDING { self.held + 1 } else { 0 };
        if !self.trusts || self.held < self.rest_after + self.eyes.window as u32 {
            return Ok(());
        }
        for i in 0..N {
            let rest = self.rules.joints[i].rest_speed;
            if let Some(speed) = self.eyes.mean(i, 0, self.rules.period)
                && speed.abs() > rest
            {
                return broken(Law::Rest, format!("joint {}: {speed} after {} ticks of holding", i + 1, self.held));
            }
        }
        Ok(())
    }
}

/// What acts, in f64.
fn torque<const N: usize>(drives: &Drives<N>) -> Option<[f64; N]> {
    match drives {
        Drives::Drive(torque) => Some(torque.map(f64::from)),
        Drives::Safe(_) => None,
    }
}
