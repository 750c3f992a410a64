//! Joints that torque must hold: their positions, and their distance from them.

use super::DriveJudge;
use super::truth::{ARMED_MAX, HELD_MAX, Truth};
use crate::campaign::judge::{SafetyProperty, Unsafe, broken};
use link::StateCode;
use sim::plant::BRAKING_TIME;

/// Sag of a joint at rest while the arm is disarmed, rad.
const DISARMED_MAX: f64 = 0.001;
/// Speed below which a joint counts as at rest, rad/s. A joint that is disarmed while it still settles on its reference is judged as in every other
/// state.
const STANDING: f64 = 0.005;

/// Ticks after arming for which [`ARMED_MAX`] holds.
const ARMED_TICKS: u32 = 50;

impl<const N: usize> DriveJudge<'_, N> {
    /// Updates the positions that the joints must keep while torque holds them.
    pub(super) fn place(&mut self, truth: &Truth<'_, N>) {
        let (state, entered) = (truth.state.0, truth.state.0 != self.before);
        let q = self.q;
        match state {
            StateCode::Arming if entered => (self.place, self.armed_at) = (q.map(|q| (q, q)), q),
            StateCode::Armed if entered && self.before != StateCode::Arming => {
                (self.place, self.armed_at) = (q.map(|q| (q, q)), q)
            }
            StateCode::Armed if entered && !self.brakes => self.place = q.map(|q| (q, q)),
            StateCode::Running => self.place = (truth.motion)(0).q.map(|q| (q, q)),
            StateCode::Holding if entered => self.stop(truth),
            StateCode::Holding if self.ticks == self.settled => self.place = truth.q.map(|q| (q, q)),
            StateCode::Lowering if entered => {
                let rest = self.rules.rest.unwrap_or(q);
                self.place = core::array::from_fn(|i| {
                    let (low, high) = self.place[i];
                    (low.min(rest[i]), high.max(rest[i]))
                });
            }
            _ => {}
        }
    }

    /// Extends the allowed positions to everywhere that the arm can stop with its deceleration, on its path or next to it.
    fn stop(&mut self, truth: &Truth<'_, N>) {
        let rules = &self.rules.joints;
        let reference = (truth.motion)(0);
        let ran = self.before == StateCode::Running || self.before == StateCode::Lowering;
        let speed = |i: usize| if ran { reference.qd[i].abs().max(self.qd[i].abs()) } else { 0.0 };
        let time = (0..N).map(|i| speed(i) / rules[i].deceleration).fold(0.0, f64::max);
        let ticks = (time / self.rules.period).ceil() as u32;
        for i in 0..N {
            let (low, high) = self.place[i];
            let way = speed(i) * time;
            let (mut low, mut high) = (low.min(self.q[i] - way), high.max(self.q[i] + way));
            if self.before == StateCode::Running {
                for k in (0..=ticks).step_by(10) {
                    let on_path = (truth.motion)(k).q[i];
                    (low, high) = (low.min(on_path), high.max(on_path));
                }
            }
            self.place[i] = (low, high);
        }
        self.settled = ticks + (0.3 / self.rules.period) as u32;
    }

    /// Checks the joints that torque must hold.
    pub(super) fn held(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        let (state, _) = truth.state;
        let all_on = truth.on == [true; N];
        let just_armed = state == StateCode::Arming
            || all_on && (state == StateCode::Armed && self.ticks < ARMED_TICKS && self.brakes);
        for i in 0..N {
            let (q, rule) = (truth.q[i], &self.rules.joints[i]);
            let (low, high) = self.place[i];
            let away = (low - q).max(q - high).max(0.0);
            if just_armed && (q - self.armed_at[i]).abs() > ARMED_MAX {
                let what = format!("joint {}: {} rad from where it was armed", i + 1, q - self.armed_at[i]);
                return broken(SafetyProperty::Fell, what);
            }
            let invisible = self.invisible;
            self.motion.worst = self.motion.worst.max(if invisible { 0.0 } else { away });
            let most = if invisible { 1.5 * rule.reach } else { HELD_MAX };
            if away > most {
                return broken(
                    SafetyProperty::Fell,
                    format!("joint {}: {away} rad from its place in state {state}", i + 1),
                );
            }
            if state == StateCode::Lowering && self.ticks > 300 && truth.qd[i].abs() > 1.5 * rule.lowering_speed + 0.1 {
                return broken(SafetyProperty::Lowered, format!("joint {} is lowered at {} rad/s", i + 1, truth.qd[i]));
            }
            // A drive that has just gone off lets its joint fall.
            let rests =
                state == StateCode::Holding && self.ticks > self.settled && all_on && truth.heard[i] && !invisible;
            if rests && truth.qd[i].abs() > 2.0 * rule.rest_speed {
                return broken(SafetyProperty::Rest, format!("joint {} holds at {} rad/s", i + 1, truth.qd[i]));
            }
        }
        Ok(())
    }

    /// Checks disarming: torque holds the arm for as long as its brakes may need, and no longer.
    pub(super) fn disarms(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        if truth.state.0 != StateCode::Disarming {
            self.disarmed = None;
            return Ok(());
        }
        if self.ticks >= self.rules.brake_delay {
            return broken(SafetyProperty::Disarmed, format!("torque for more than {} ticks", self.rules.brake_delay));
        }
        if self.before != StateCode::Disarming {
            self.disarmed = Some((self.q, self.qd));
        }
        // A drive that goes off, or receives no frames, lets its joint fall. That is judged as in every other state.
        self.disarmed = self.disarmed.filter(|_| truth.on == [true; N] && truth.heard == [true; N]);
        let Some((from, speed)) = self.disarmed else { return Ok(()) };
        let time = f64::from(self.rules.brake_delay) * self.rules.period + BRAKING_TIME;
        for i in 0..N {
            let stood = speed.iter().all(|speed| speed.abs() <= STANDING);
            let most = if stood { DISARMED_MAX + speed[i].abs() * time } else { HELD_MAX };
            let moved = (truth.q[i] - from[i]).abs();
            if moved > most {
                let what = format!("joint {} sags by {moved} rad while it is disarmed, at most {most}", i + 1);
                return broken(SafetyProperty::Fell, what);
            }
        }
        Ok(())
    }
}
