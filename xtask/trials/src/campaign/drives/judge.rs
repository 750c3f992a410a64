//! Safety of the motion: compares the true state of the simulated joints and drives with docs/safety.md.
//!
//! The judge reads the true state of the arm, the shafts, the brakes and the drives from the simulation. From the board it knows only what is
//! announced: its state, and if it is homed. It reads no frame and calls none of the machine's rules.
//!
//! | module | holds |
//! |---|---|
//! | `truth` | the true state of a tick |
//! | `held` | joints that torque must hold |
//! | `released` | joints on which no torque may act |

mod held;
mod released;
mod truth;

pub(super) use truth::{Known, Truth};

use crate::campaign::judge::{SafetyProperty, Unsafe, broken};
use crate::campaign::outcome::{Exemption, Motion};
use dynamics_core::safety::Rules;
use link::Request;
use link::StateCode;
use sim::plant::Arm;
use truth::Released;

/// Distance from the rest pose within which a released arm lies on its stops, rad.
const REST_MAX: f64 = 0.05;

/// Ticks in which a drive that goes off must be detected, in addition to those allowed for a missing reading: its reply is one tick old, and one more
/// may be late.
const FOUND_TICKS: u32 = 3;

/// The same for replies without a drive state: six replies in a row without torque.
const FOUND_TICKS_WITHOUT_STATE: u32 = 7;

/// Ticks in which a shifted zero of a drive must be detected, in addition to those allowed for a missing reading.
const ZERO_TICKS: u32 = 6;

/// Share of a drive's torque range below which its torque gives no evidence, if replies carry no state.
const VISIBLE: f64 = 0.02;

/// Judge of one run.
#[derive(Clone, Debug)]
pub(super) struct DriveJudge<'a, const N: usize> {
    arm: &'a Arm<N>,
    rules: &'a Rules<f64, N>,
    drives: &'a [Known; N],
    age_max: u32,
    /// True if the arm has brakes.
    brakes: bool,
    /// True if replies carry the state of a drive.
    tells_state: bool,
    /// State, positions (rad) and velocities (rad/s) of the previous tick.
    before: StateCode,
    q: [f64; N],
    qd: [f64; N],
    /// Lowest and highest allowed position of each joint while torque must hold it, rad.
    place: [(f64, f64); N],
    /// Ticks in the present state, and ticks of a hold after which the arm must be at rest.
    ticks: u32,
    settled: u32,
    /// Position of the arm when arming began, rad.
    armed_at: [f64; N],
    /// Position and speed of the arm when disarming began; `None` unless every drive is on and receives frames.
    disarmed: Option<([f64; N], [f64; N])>,
    released: Option<Released<N>>,
    was_open: bool,
    was_on: [bool; N],
    /// Consecutive ticks in which torque must act on a drive that is off, and those in which nothing could show it.
    off_for: [u32; N],
    unseen_for: [u32; N],
    /// True if such a drive has been undetectable for a while since torque must act.
    invisible: bool,
    zero: Option<[f64; N]>,
    moved_for: [u32; N],
    silent: u32,
    /// Motion of the joints so far.
    pub(super) motion: Motion,
}

fn drives(state: StateCode) -> bool {
    matches!(state, StateCode::Armed | StateCode::Running | StateCode::Holding | StateCode::Lowering)
}

impl<'a, const N: usize> DriveJudge<'a, N> {
    /// Creates the judge of an arm at rest at `q`.
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
            before: StateCode::Idle,
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

    /// Judges a tick.
    ///
    /// # Errors
    /// [`Unsafe`]: the first violated property.
    pub(super) fn watch(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        let (state, _) = truth.state;
        self.ticks = if state == self.before { self.ticks.saturating_add(1) } else { 0 };
        self.silent = if truth.spoke { 0 } else { self.silent.saturating_add(1) };
        self.host(truth)?;
        self.brake_line(truth)?;
        self.zeros(truth)?;
        self.place(truth);
        if drives(state) || state == StateCode::Disarming || (state == StateCode::Arming && self.brakes) {
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

    /// Checks the reaction to requests and to silence of the host.
    fn host(&self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        let (state, cause) = truth.state;
        if truth.requests.contains(&Request::Stop) && state != StateCode::Fault {
            return broken(SafetyProperty::Strongest, format!("state {state} after a stop"));
        }
        if truth.requests.contains(&Request::Hold)
            && matches!(state, StateCode::Running | StateCode::Arming | StateCode::Lowering)
        {
            return broken(SafetyProperty::Strongest, format!("state {state} after a hold"));
        }
        let Rules { heartbeat_max, hold_max, .. } = *self.rules;
        let (first, last) = (heartbeat_max + 2, heartbeat_max.saturating_add(hold_max) + 3);
        if (self.silent > first && matches!(state, StateCode::Armed | StateCode::Running | StateCode::Arming))
            || (self.silent > last && state == StateCode::Holding)
        {
            return broken(
                SafetyProperty::Silence,
                format!("state {state} after {} ticks without the host", self.silent),
            );
        }
        if let Some(rest) = &self.rules.rest
            && (drives(self.before) || self.before == StateCode::Disarming)
            && (state, cause) == (StateCode::Fault, 10)
        {
            let far = (0..N).find(|&i| (truth.q[i] - rest[i]).abs() > REST_MAX);
            if let Some(i) = far {
                let (q, rest) = (truth.q[i], rest[i]);
                return broken(
                    SafetyProperty::Lowered,
                    format!("joint {} is let go at {q} rad, its rest is {rest} rad", i + 1),
                );
            }
        }
        Ok(())
    }

    /// Checks when the brakes open, and that the drives are then ready.
    fn brake_line(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        let (state, _) = truth.state;
        if self.brakes && truth.released && !drives(state) {
            return broken(SafetyProperty::BrakesOpen, format!("they are opened in state {state}"));
        }
        let gravity = self.arm.terms(&truth.q, &[0.0; N]).gravity;
        if self.brakes && truth.released && !self.was_open {
            for i in 0..N {
                if !self.was_on[i] {
                    if self.is_visible(i, gravity[i]) {
                        return broken(SafetyProperty::BrakesOpen, format!("the drive of joint {} is off", i + 1));
                    }
                    self.exempt(Exemption::Invisible);
                    self.invisible = true;
                    continue;
                }
                let lacks = gravity[i] - truth.carried[i];
                if lacks.abs() > 0.1 * self.drives[i].torque.min(gravity[i].abs()) + 0.01 * self.drives[i].torque {
                    let what = format!("joint {}: {} of {} N m", i + 1, truth.carried[i], gravity[i]);
                    return broken(SafetyProperty::Carried, what);
                }
            }
        }
        let without_state = if self.tells_state { 0 } else { FOUND_TICKS_WITHOUT_STATE };
        let found = self.age_max + FOUND_TICKS + without_state;
        for i in 0..N {
            let acts = (drives(state) || state == StateCode::Disarming) && !truth.on[i] && (truth.open || !self.brakes);
            if !acts {
                (self.off_for[i], self.unseen_for[i]) = (0, 0);
            } else if self.is_visible(i, truth.told[i]) {
                self.off_for[i] += 1;
            } else {
                // Evidence in the replies must be present in consecutive ticks.
                (self.off_for[i], self.unseen_for[i]) = (0, self.unseen_for[i] + 1);
            }
            if self.off_for[i] > found {
                let what = format!("joint {}: {} ticks in state {state}", i + 1, self.off_for[i]);
                return broken(SafetyProperty::OffUnnoticed, what);
            }
            if self.unseen_for[i] > self.age_max {
                self.exempt(Exemption::Invisible);
                self.invisible = true;
            }
        }
        Ok(())
    }

    /// True if a drive that is off can be detected: from its state, or from the missing torque.
    fn is_visible(&self, i: usize, torque: f64) -> bool {
        self.tells_state || torque.abs() > 1.1 * VISIBLE * self.drives[i].torque
    }

    /// Checks drives with a zero that has moved since homing.
    fn zeros(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        let (state, _) = truth.state;
        if self.before == StateCode::Homing && truth.homed {
            self.zero = Some(truth.zero);
        }
        let Some(zero) = self.zero else { return Ok(()) };
        for i in 0..N {
            let rule = &self.rules.joints[i];
            // A shift smaller than a jump cannot be distinguished from a motion.
            let moved = (truth.zero[i] - zero[i]).abs() > 3.0 * rule.jump_step + 2.0 * rule.resolution;
            self.moved_for[i] = if moved && truth.powered[i] && drives(state) { self.moved_for[i] + 1 } else { 0 };
            if self.moved_for[i] > self.age_max + ZERO_TICKS {
                let way = truth.zero[i] - zero[i];
                return broken(SafetyProperty::ZeroMoved, format!("joint {}: by {way} rad, in state {state}", i + 1));
            }
        }
        Ok(())
    }
}
