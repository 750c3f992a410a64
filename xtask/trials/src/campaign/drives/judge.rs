//! Safety of the motion: what the joints of the simulated arm do, and what their drives really are, against docs/safety.md.
//!
//! The judge sees the arm, the shafts, the brakes and the drives from their own side. Of the board it knows what it announces: its state, and
//! that it is homed. It reads no frame and calls none of the machine's rules.

use crate::campaign::judge::{Law, Unsafe, broken};
use crate::campaign::outcome::{Exemption, Motion};
use board::session::states::{ARMED, ARMING, DISARMING, FAULT, HOLDING, HOMING, IDLE, LOWERING, RUNNING};
use dynamics_core::Reference;
use dynamics_core::safety::Rules;
use link::Request;
use sim::plant::{Arm, BRAKING_TIME};

/// Distance of a joint from its place or path while torque is to hold it, rad: what it may fall until its drive is found off, and the errors
/// of following.
pub(super) const HELD_MAX: f64 = 0.03;

/// Motion of a joint from the beginning of arming on, while brakes hold it or have just opened, rad.
const ARMED_MAX: f64 = 0.02;

/// Sag of a joint at rest while the arm is disarmed, rad.
const DISARMED_MAX: f64 = 0.001;
/// Speed below which a joint stands, rad/s. One that is disarmed while it still settles on its reference is held as in every other state.
const STANDING: f64 = 0.005;

/// Distance from the rest pose at which an arm that is let go lies on its stops, rad.
const REST_MAX: f64 = 0.05;

/// Ticks after arming for which [`ARMED_MAX`] holds.
const ARMED_TICKS: u32 = 50;

/// Ticks in which a drive that goes off must be found, beside those of a missing reading: its reply is one old, and one more is late.
const FOUND_TICKS: u32 = 3;

/// The same, where replies carry no state: six replies in a row without torque.
const FOUND_TICKS_WITHOUT_STATE: u32 = 7;

/// Ticks in which a drive's other zero must be found, beside those of a missing reading.
const ZERO_TICKS: u32 = 6;

/// Greatest speed of a joint that its drive damps, as a multiple of that at which the damping carries gravity, and more, rad/s, for what the other
/// joints do to it; after so many seconds of damping.
const SINKING: f64 = 1.3;
const SINKING_MORE: f64 = 0.3;
const SINKING_AFTER: f64 = 0.15;

/// The weight's acceleration is taken from a tick's two ends; it may be larger between them.
const FALL: f64 = 1.05;

/// Share of a drive's torque range below which its torque shows nothing, where replies carry no state.
const VISIBLE: f64 = 0.02;

/// Longest time that a drive which hears nothing gives its last torque, s: its own timeout, which a mini-cheetah brings along.
const TIMEOUT: f64 = 0.05;
const TIMEOUT_WITHOUT_SETTING: f64 = 0.1;

/// A drive, as its owner knows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    /// Damping of its damped stop at the joint, N m s/rad.
    pub(super) damping: f64,
    /// Highest torque of its frames at the joint, N m.
    pub(super) torque: f64,
    /// Viscous, N m s/rad, and Coulomb friction of the joint, N m.
    pub(super) friction: (f64, f64),
}

impl Known {
    /// Friction torque at this speed, N m.
    fn friction_torque(&self, qd: f64) -> f64 {
        let (viscous, coulomb) = self.friction;
        viscous * qd + coulomb * qd.signum()
    }
}

/// True state of the arm and its drives after a tick.
pub(super) struct Truth<'a, const N: usize> {
    /// State, cause and homing that the board has announced.
    pub(super) state: (u8, u8),
    pub(super) homed: bool,
    /// The arm.
    pub(super) q: [f64; N],
    pub(super) qd: [f64; N],
    /// Torques on the joints at the end of the tick before, and of this one, N m.
    pub(super) carried: [f64; N],
    pub(super) torque: [f64; N],
    /// Torques that the drives have heard last, whether they give them or not, N m.
    pub(super) told: [f64; N],
    /// Drives that follow commands, that have power, that have heard a frame in this tick.
    pub(super) on: [bool; N],
    pub(super) powered: [bool; N],
    pub(super) heard: [bool; N],
    /// Drives that are off because of a disable frame.
    pub(super) told_off: [bool; N],
    /// Joint positions at which drives show zero, rad.
    pub(super) zero: [f64; N],
    /// The line to the brakes opens them, and they are open: they engage later.
    pub(super) released: bool,
    pub(super) open: bool,
    /// The host's motion, so many ticks from now.
    pub(super) motion: &'a dyn Fn(u32) -> Reference<f64, N>,
    /// Requests of the host that arrived before the tick, and whether anything did.
    pub(super) requests: &'a [Request],
    pub(super) spoke: bool,
}

/// The time since the safe action was due.
#[derive(Clone, Copy, Debug)]
struct Released<const N: usize> {
    ticks: u32,
    from: [f64; N],
    /// Greatest speed and way of each joint until the brakes engage, and the ticks in which they may yet do so.
    speed: [f64; N],
    way: [f64; N],
    engaging: u32,
    /// Some drive has not heard that its torque is to end: what the drives then give counts until the brakes engage.
    unheard: bool,
    /// Drives that have heard a frame since.
    heard: [bool; N],
    /// Ticks in which every drive was on and heard the board, one after the other, and the greatest torque of gravity on each joint in them.
    damped: u32,
    gravity: [f64; N],
    /// Where the arm was before them.
    all_on_from: [f64; N],
}

/// Judge of one run.
#[derive(Clone, Debug)]
pub(super) struct Judge<'a, const N: usize> {
    arm: &'a Arm<N>,
    rules: &'a Rules<f64, N>,
    drives: &'a [Known; N],
    age_max: u32,
    /// The arm has brakes.
    brakes: bool,
    /// Replies carry the state of a drive.
    tells_state: bool,
    /// State of the tick before, and where the arm was.
    before: u8,
    q: [f64; N],
    qd: [f64; N],
    /// Lowest and highest place of each joint while torque is to hold it.
    place: [(f64, f64); N],
    /// Ticks in this state, and ticks of a hold after which the arm rests.
    ticks: u32,
    settled: u32,
    /// Where the arm was when it was to be armed.
    armed_at: [f64; N],
    /// Where and how fast the arm was when it was disarmed, while every drive is on and hears the board.
    disarmed: Option<([f64; N], [f64; N])>,
    released: Option<Released<N>>,
    was_open: bool,
    was_on: [bool; N],
    /// Ticks in which torque is to act on a drive that is off, in a row, and those in which nothing could show it.
    off_for: [u32; N],
    unseen_for: [u32; N],
    /// Nothing has shown such a drive for a while, since torque is to act.
    invisible: bool,
    zero: Option<[f64; N]>,
    moved_for: [u32; N],
    silent: u32,
    /// Motion of the joints so far.
    pub(super) motion: Motion,
}

fn drives(state: u8) -> bool {
    matches!(state, ARMED | RUNNING | HOLDING | LOWERING)
}

impl<'a, const N: usize> Judge<'a, N> {
    /// The judge of an arm that lies or stands at `q`.
    pub(super) fn new(
        (arm, drives): (&'a Arm<N>, &'a [Known; N]),
        rules: &'a Rules<f64, N>,
        (age_max, tells_state): (u32, bool),
        q: [f64; N],
    ) -> Self {
        Self {
            arm,
            rules,
            drives,
            age_max,
            brakes: rules.safe_action == dynamics_core::safety::SafeAction::Brake,
            tells_state,
            before: 0,
            q,
            qd: [0.0; N],
            place: q.map(|q| (q, q)),
            ticks: 0,
            settled: 0,
            armed_at: q,
            disarmed: None,
            released: None,
            was_open: false,
            was_on: [false; N],
            off_for: [0; N],
            unseen_for: [0; N],
            invisible: false,
            zero: None,
            moved_for: [0; N],
            silent: 0,
            motion: Motion::default(),
        }
    }

    /// Judge a tick.
    ///
    /// # Errors
    /// [`Unsafe`]: the first broken law.
    pub(super) fn watch(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        let (state, _) = truth.state;
        self.ticks = if state == self.before { self.ticks.saturating_add(1) } else { 0 };
        self.silent = if truth.spoke { 0 } else { self.silent.saturating_add(1) };
        self.host(truth)?;
        self.brake_line(truth)?;
        self.zeros(truth)?;
        self.place(truth);
        if drives(state) || state == DISARMING || (state == ARMING && self.brakes) {
            self.released = None;
            self.held(truth)?;
            self.disarms(truth)?;
        } else {
            self.released(truth)?;
        }
        (self.before, self.q, self.qd) = (state, truth.q, truth.qd);
        (self.was_open, self.was_on) = (truth.released, truth.on);
        Ok(())
    }

    fn exempt(&mut self, exemption: Exemption) {
        self.motion.exempt |= exemption as u8;
    }

    /// Requests and silence of the host.
    fn host(&self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        let (state, cause) = truth.state;
        if truth.requests.contains(&Request::Stop) && state != FAULT {
            return broken(Law::Strongest, format!("state {state} after a stop"));
        }
        if truth.requests.contains(&Request::Hold) && matches!(state, RUNNING | ARMING | LOWERING) {
            return broken(Law::Strongest, format!("state {state} after a hold"));
        }
        let Rules { heartbeat_max, hold_max, .. } = *self.rules;
        let (first, last) = (heartbeat_max + 2, heartbeat_max.saturating_add(hold_max) + 3);
        if (self.silent > first && matches!(state, ARMED | RUNNING | ARMING))
            || (self.silent > last && state == HOLDING)
        {
            return broken(Law::Silence, format!("state {state} after {} ticks without the host", self.silent));
        }
        if let Some(rest) = &self.rules.rest
            && (drives(self.before) || self.before == DISARMING)
            && (state, cause) == (FAULT, 10)
        {
            let far = (0..N).find(|&i| (truth.q[i] - rest[i]).abs() > REST_MAX);
            if let Some(i) = far {
                let (q, rest) = (truth.q[i], rest[i]);
                return broken(Law::Lowered, format!("joint {} is let go at {q} rad, its rest is {rest} rad", i + 1));
            }
        }
        Ok(())
    }

    /// When brakes open, and what they open on.
    fn brake_line(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        let (state, _) = truth.state;
        if self.brakes && truth.released && !drives(state) {
            return broken(Law::BrakesOpen, format!("they are opened in state {state}"));
        }
        let gravity = self.arm.terms(&truth.q, &[0.0; N]).gravity;
        if self.brakes && truth.released && !self.was_open {
            for i in 0..N {
                if !self.was_on[i] {
                    if self.is_visible(i, gravity[i]) {
                        return broken(Law::BrakesOpen, format!("the drive of joint {} is off", i + 1));
                    }
                    self.exempt(Exemption::Invisible);
                    self.invisible = true;
                    continue;
                }
                let lacks = gravity[i] - truth.carried[i];
                if lacks.abs() > 0.1 * self.drives[i].torque.min(gravity[i].abs()) + 0.01 * self.drives[i].torque {
                    let what = format!("joint {}: {} of {} N m", i + 1, truth.carried[i], gravity[i]);
                    return broken(Law::Carried, what);
                }
            }
        }
        let without_state = if self.tells_state { 0 } else { FOUND_TICKS_WITHOUT_STATE };
        let found = self.age_max + FOUND_TICKS + without_state;
        for i in 0..N {
            let acts = (drives(state) || state == DISARMING) && !truth.on[i] && (truth.open || !self.brakes);
            if !acts {
                (self.off_for[i], self.unseen_for[i]) = (0, 0);
            } else if self.is_visible(i, truth.told[i]) {
                self.off_for[i] += 1;
            } else {
                // What its replies show has to be there in a row.
                (self.off_for[i], self.unseen_for[i]) = (0, self.unseen_for[i] + 1);
            }
            if self.off_for[i] > found {
                let what = format!("joint {}: {} ticks in state {state}", i + 1, self.off_for[i]);
                return broken(Law::OffUnnoticed, what);
            }
            if self.unseen_for[i] > self.age_max {
                self.exempt(Exemption::Invisible);
                self.invisible = true;
            }
        }
        Ok(())
    }

    /// True if a drive that is off shows it: by its state, or by the torque that is missing.
    fn is_visible(&self, i: usize, torque: f64) -> bool {
        self.tells_state || torque.abs() > 1.1 * VISIBLE * self.drives[i].torque
    }

    /// Drives whose zero has moved since the homing.
    fn zeros(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        let (state, _) = truth.state;
        if self.before == HOMING && truth.homed {
            self.zero = Some(truth.zero);
        }
        let Some(zero) = self.zero else { return Ok(()) };
        for i in 0..N {
            let rule = &self.rules.joints[i];
            // What is nearer than a jump nobody can tell from a motion.
            let moved = (truth.zero[i] - zero[i]).abs() > 3.0 * rule.jump_step + 2.0 * rule.resolution;
            self.moved_for[i] = if moved && truth.powered[i] && drives(state) { self.moved_for[i] + 1 } else { 0 };
            if self.moved_for[i] > self.age_max + ZERO_TICKS {
                let way = truth.zero[i] - zero[i];
                return broken(Law::ZeroMoved, format!("joint {}: by {way} rad, in state {state}", i + 1));
            }
        }
        Ok(())
    }

    /// Where the joints are to be while torque holds them.
    fn place(&mut self, truth: &Truth<'_, N>) {
        let (state, entered) = (truth.state.0, truth.state.0 != self.before);
        let q = self.q;
        match state {
            ARMING if entered => (self.place, self.armed_at) = (q.map(|q| (q, q)), q),
            ARMED if entered && self.before != ARMING => (self.place, self.armed_at) = (q.map(|q| (q, q)), q),
            ARMED if entered && !self.brakes => self.place = q.map(|q| (q, q)),
            RUNNING => self.place = (truth.motion)(0).q.map(|q| (q, q)),
            HOLDING if entered => self.stop(truth),
            HOLDING if self.ticks == self.settled => self.place = truth.q.map(|q| (q, q)),
            LOWERING if entered => {
                let rest = self.rules.rest.unwrap_or(q);
                self.place = core::array::from_fn(|i| {
                    let (low, high) = self.place[i];
                    (low.min(rest[i]), high.max(rest[i]))
                });
            }
            _ => {}
        }
    }

    /// The places between here and where the arm can have stopped: on its path or beside it, at its deceleration.
    fn stop(&mut self, truth: &Truth<'_, N>) {
        let rules = &self.rules.joints;
        let reference = (truth.motion)(0);
        let ran = self.before == RUNNING || self.before == LOWERING;
        let speed = |i: usize| if ran { reference.qd[i].abs().max(self.qd[i].abs()) } else { 0.0 };
        let time = (0..N).map(|i| speed(i) / rules[i].deceleration).fold(0.0, f64::max);
        let ticks = (time / self.rules.period).ceil() as u32;
        for i in 0..N {
            let (low, high) = self.place[i];
            let way = speed(i) * time;
            let (mut low, mut high) = (low.min(self.q[i] - way), high.max(self.q[i] + way));
            if self.before == RUNNING {
                for k in (0..=ticks).step_by(10) {
                    let on_path = (truth.motion)(k).q[i];
                    (low, high) = (low.min(on_path), high.max(on_path));
                }
            }
            self.place[i] = (low, high);
        }
        self.settled = ticks + (0.3 / self.rules.period) as u32;
    }

    /// Torque is to hold every joint.
    fn held(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        let (state, _) = truth.state;
        let all_on = truth.on == [true; N];
        let just_armed = state == ARMING || all_on && (state == ARMED && self.ticks < ARMED_TICKS && self.brakes);
        for i in 0..N {
            let (q, rule) = (truth.q[i], &self.rules.joints[i]);
            let (low, high) = self.place[i];
            let away = (low - q).max(q - high).max(0.0);
            if just_armed && (q - self.armed_at[i]).abs() > ARMED_MAX {
                let what = format!("joint {}: {} rad from where it was armed", i + 1, q - self.armed_at[i]);
                return broken(Law::Fell, what);
            }
            let invisible = self.invisible;
            self.motion.worst = self.motion.worst.max(if invisible { 0.0 } else { away });
            let most = if invisible { 1.5 * rule.reach } else { HELD_MAX };
            if away > most {
                return broken(Law::Fell, format!("joint {}: {away} rad from its place in state {state}", i + 1));
            }
            if state == LOWERING && self.ticks > 300 && truth.qd[i].abs() > 1.5 * rule.lowering_speed + 0.1 {
                return broken(Law::Lowered, format!("joint {} is lowered at {} rad/s", i + 1, truth.qd[i]));
            }
            // A drive that has just gone off lets its joint fall.
            let rests = state == HOLDING && self.ticks > self.settled && all_on && truth.heard[i] && !invisible;
            if rests && truth.qd[i].abs() > 2.0 * rule.rest_speed {
                return broken(Law::Rest, format!("joint {} holds at {} rad/s", i + 1, truth.qd[i]));
            }
        }
        Ok(())
    }

    /// While the arm is disarmed torque holds it, for as long as its brakes may need and no longer.
    fn disarms(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        if truth.state.0 != DISARMING {
            self.disarmed = None;
            return Ok(());
        }
        if self.ticks >= self.rules.brake_delay {
            return broken(Law::Disarmed, format!("torque for more than {} ticks", self.rules.brake_delay));
        }
        if self.before != DISARMING {
            self.disarmed = Some((self.q, self.qd));
        }
        // A drive that goes off, or is not heard, lets its joint fall: it is found as in every other state.
        self.disarmed = self.disarmed.filter(|_| truth.on == [true; N] && truth.heard == [true; N]);
        let Some((from, speed)) = self.disarmed else { return Ok(()) };
        let time = f64::from(self.rules.brake_delay) * self.rules.period + BRAKING_TIME;
        for i in 0..N {
            let stood = speed.iter().all(|speed| speed.abs() <= STANDING);
            let most = if stood { DISARMED_MAX + speed[i].abs() * time } else { HELD_MAX };
            let moved = (truth.q[i] - from[i]).abs();
            if moved > most {
                let what = format!("joint {} sags by {moved} rad while it is disarmed, at most {most}", i + 1);
                return broken(Law::Fell, what);
            }
        }
        Ok(())
    }

    /// The way that the weight, and drives that do not hear the board, can make until the brakes engage.
    fn falls(&mut self, truth: &Truth<'_, N>, released: &mut Released<N>) {
        if !truth.open || released.ticks >= released.engaging {
            return;
        }
        let timeout = if self.tells_state { TIMEOUT } else { TIMEOUT_WITHOUT_SETTING };
        let timeout = timeout.max(10.0 * self.rules.period) / self.rules.period + 3.0;
        let deaf = |i: usize| !released.heard[i] && f64::from(released.ticks) <= timeout;
        if released.ticks > 1 && (0..N).any(|i| deaf(i) && truth.on[i]) {
            self.exempt(Exemption::Unheard);
            released.unheard = true;
        }
        let counts = |i: usize| deaf(i) || released.unheard;
        let torque: [f64; N] = core::array::from_fn(|i| if counts(i) { truth.torque[i] } else { 0.0 });
        let before: [f64; N] = core::array::from_fn(|i| if counts(i) { truth.carried[i] } else { 0.0 });
        // Friction of one joint can move another one faster, so the arm with it counts, and the arm without.
        let less_friction = |torque: &[f64; N], qd: &[f64; N]| {
            core::array::from_fn(|i| torque[i] - self.drives[i].friction_torque(qd[i]))
        };
        let states = [
            (truth.q, truth.qd, torque),
            (self.q, self.qd, before),
            (truth.q, truth.qd, less_friction(&torque, &truth.qd)),
            (self.q, self.qd, less_friction(&before, &self.qd)),
        ];
        let accelerations = states.map(|(q, qd, torque)| self.arm.acceleration(&q, &qd, &torque).unwrap_or([0.0; N]));
        for i in 0..N {
            let fastest = accelerations.iter().fold(0.0, |most: f64, qdd| most.max(qdd[i].abs()));
            released.speed[i] += FALL * fastest * self.rules.period;
            released.way[i] += released.speed[i] * self.rules.period;
        }
    }

    /// No torque is to act: brakes hold the arm, or its drives damp it.
    fn released(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        self.invisible = false;
        let (from, gravity) = (self.q, [0.0; N]);
        // After an orderly end the brakes have engaged already. So they have where lowering waited for too long, but fault 15 may come at once too.
        let orderly = truth.state.0 == IDLE || matches!(truth.state, (FAULT, 10 | 20));
        let fresh = Released {
            ticks: 0,
            from,
            speed: self.qd.map(f64::abs),
            way: [0.0; N],
            engaging: if orderly { 0 } else { self.rules.brake_delay },
            unheard: false,
            heard: [false; N],
            damped: 0,
            gravity,
            all_on_from: from,
        };
        let mut released = self.released.unwrap_or(fresh);
        if !self.brakes {
            self.sinks(truth, &mut released)?;
        } else {
            self.falls(truth, &mut released);
        }
        for i in 0..N {
            // A frame of the tick before the safe action may come a tick late.
            released.heard[i] |= truth.heard[i] && released.ticks > 0;
            let (from, speed) = (released.from[i], released.speed[i]);
            let moved = (truth.q[i] - from).abs();
            if self.brakes {
                let way = released.way[i] + speed * (0.5 * BRAKING_TIME + self.rules.period);
                let most = 1.01 * way + 1e-4;
                if moved > most {
                    let what = format!("joint {}: {moved} rad since the safe action, at most {most}", i + 1);
                    return broken(Law::Stopped, what);
                }
                continue;
            }
            self.unbraked(i, truth, &released, moved)?;
        }
        released.ticks += 1;
        self.released = Some(released);
        Ok(())
    }

    /// An arm that all of its drives damp comes down slowly, and stays where it is while it is armed.
    fn sinks(&self, truth: &Truth<'_, N>, released: &mut Released<N>) -> Result<(), Unsafe> {
        let arms = truth.state.0 == ARMING;
        let damped = truth.on == [true; N] && truth.heard == [true; N] && (arms == (self.before == ARMING));
        if !damped {
            (released.damped, released.gravity, released.all_on_from) = (0, [0.0; N], truth.q);
            return Ok(());
        }
        released.damped += 1;
        let gravity = self.arm.terms(&truth.q, &[0.0; N]).gravity;
        for i in 0..N {
            released.gravity[i] = released.gravity[i].max(gravity[i].abs());
            let most = SINKING * released.gravity[i] / self.drives[i].damping + SINKING_MORE;
            let speed = truth.qd[i].abs();
            if !arms && f64::from(released.damped) * self.rules.period > SINKING_AFTER && speed > most {
                return broken(Law::Damped, format!("joint {} sinks at {speed} rad/s, at most {most}", i + 1));
            }
            let moved = (truth.q[i] - released.all_on_from[i]).abs();
            let enabling = f64::from(released.damped) * self.rules.period;
            if arms && moved > ARMED_MAX + self.rules.joints[i].rest_speed * enabling {
                return broken(Law::Fell, format!("joint {} moves by {moved} rad while it is armed", i + 1));
            }
        }
        Ok(())
    }

    /// A joint that no brake holds, in the safe action.
    fn unbraked(&mut self, i: usize, truth: &Truth<'_, N>, released: &Released<N>, moved: f64) -> Result<(), Unsafe> {
        let Known { damping, torque: range, .. } = self.drives[i];
        let (torque, speed) = (truth.torque[i], truth.qd[i]);
        if !truth.on[i] {
            if truth.told_off[i] && truth.powered[i] {
                return broken(Law::Damped, format!("joint {}: its drive was told to be off", i + 1));
            }
            if moved > HELD_MAX {
                self.exempt(Exemption::NoDrive);
            }
            return Ok(());
        }
        // A drive measures and rounds, and its torque is of a moment before.
        let wanted = (-damping * speed).clamp(-range, range);
        let error = 0.15 * wanted.abs() + 0.02 * range;
        // While drives come on one that is on gives nothing for a tick, or a probe of a fiftieth.
        let enabling = truth.state.0 == ARMING && torque.abs() <= wanted.abs() + 0.03 * range;
        if (torque - wanted).abs() <= error || enabling {
            return Ok(());
        }
        let what = format!("joint {}: {torque} N m at {speed} rad/s, {} ticks after", i + 1, released.ticks);
        if released.heard[i] {
            return broken(Law::Damped, what);
        }
        let timeout = if self.tells_state { TIMEOUT } else { TIMEOUT_WITHOUT_SETTING };
        if f64::from(released.ticks) > timeout.max(10.0 * self.rules.period) / self.rules.period + 3.0 {
            return broken(Law::OldTorque, what);
        }
        if released.ticks > 1 {
            self.exempt(Exemption::Unheard);
        }
        Ok(())
    }
}
