//! Joints on which no torque may act: brakes hold the arm, or its drives damp it.

use super::DriveJudge;
use super::truth::{ARMED_MAX, HELD_MAX, Known, Released, Truth};
use crate::campaign::judge::{SafetyProperty, Unsafe, broken};
use crate::campaign::outcome::Exemption;
use link::StateCode;
use sim::plant::BRAKING_TIME;

/// Largest speed of a joint that its drive damps: a multiple of the speed at which damping balances gravity, plus an allowance, rad/s, for coupling
/// from the other joints. It applies after this time of damping, s.
const SINKING: f64 = 1.3;
const SINKING_MORE: f64 = 0.3;
const SINKING_AFTER: f64 = 0.15;

/// Factor for the acceleration by gravity, which is sampled at both ends of a tick and may be larger between them.
const FALL: f64 = 1.05;

/// Longest time for which a drive that receives nothing continues its last torque, s: the timeout that the board sets, and the fixed timeout of a
/// mini-cheetah.
const TIMEOUT: f64 = 0.05;
const TIMEOUT_WITHOUT_SETTING: f64 = 0.1;

impl<const N: usize> DriveJudge<'_, N> {
    /// Adds the distance that gravity, and drives that do not receive frames, can move the joints until the brakes engage.
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
        // Friction of one joint can accelerate another one, so the arm is evaluated with and without friction.
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

    /// Checks that no torque acts: brakes hold the arm, or its drives damp it.
    pub(super) fn released(&mut self, truth: &Truth<'_, N>) -> Result<(), Unsafe> {
        self.invisible = false;
        let (from, gravity) = (self.q, [0.0; N]);
        // After an orderly end the brakes have already engaged. After lowering that took too long they have as well, but there fault 15 may also come
        // immediately.
        let orderly = truth.state.0 == StateCode::Idle || matches!(truth.state, (StateCode::Fault, 10 | 20));
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
            // A frame sent in the tick before the safe action may arrive one tick late.
            released.heard[i] |= truth.heard[i] && released.ticks > 0;
            let (from, speed) = (released.from[i], released.speed[i]);
            let moved = (truth.q[i] - from).abs();
            if self.brakes {
                let way = released.way[i] + speed * (0.5 * BRAKING_TIME + self.rules.period);
                let most = 1.01 * way + 1e-4;
                if moved > most {
                    let what = format!("joint {}: {moved} rad since the safe action, at most {most}", i + 1);
                    return broken(SafetyProperty::Stopped, what);
                }
                continue;
            }
            self.unbraked(i, truth, &released, moved)?;
        }
        released.ticks += 1;
        self.released = Some(released);
        Ok(())
    }

    /// Checks that an arm damped by all of its drives comes down slowly, and does not move while it is being armed.
    fn sinks(&self, truth: &Truth<'_, N>, released: &mut Released<N>) -> Result<(), Unsafe> {
        let arms = truth.state.0 == StateCode::Arming;
        let damped = truth.on == [true; N] && truth.heard == [true; N] && (arms == (self.before == StateCode::Arming));
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
                return broken(
                    SafetyProperty::Damped,
                    format!("joint {} sinks at {speed} rad/s, at most {most}", i + 1),
                );
            }
            let moved = (truth.q[i] - released.all_on_from[i]).abs();
            let enabling = f64::from(released.damped) * self.rules.period;
            if arms && moved > ARMED_MAX + self.rules.joints[i].rest_speed * enabling {
                return broken(SafetyProperty::Fell, format!("joint {} moves by {moved} rad while it is armed", i + 1));
            }
        }
        Ok(())
    }

    /// Checks a joint without a brake in the safe action.
    fn unbraked(&mut self, i: usize, truth: &Truth<'_, N>, released: &Released<N>, moved: f64) -> Result<(), Unsafe> {
        let Known { damping, torque: range, .. } = self.drives[i];
        let (torque, speed) = (truth.torque[i], truth.qd[i]);
        if !truth.on[i] {
            if truth.told_off[i] && truth.powered[i] {
                return broken(SafetyProperty::Damped, format!("joint {}: its drive was told to be off", i + 1));
            }
            if moved > HELD_MAX {
                self.exempt(Exemption::NoDrive);
            }
            return Ok(());
        }
        // A drive measures with rounding, and its torque is slightly delayed.
        let wanted = (-damping * speed).clamp(-range, range);
        let error = 0.15 * wanted.abs() + 0.02 * range;
        // While drives are being enabled, one that is on gives no torque for a tick, or a probe torque of 2 % of its range.
        let enabling = truth.state.0 == StateCode::Arming && torque.abs() <= wanted.abs() + 0.03 * range;
        if (torque - wanted).abs() <= error || enabling {
            return Ok(());
        }
        let what = format!("joint {}: {torque} N m at {speed} rad/s, {} ticks after", i + 1, released.ticks);
        if released.heard[i] {
            return broken(SafetyProperty::Damped, what);
        }
        let timeout = if self.tells_state { TIMEOUT } else { TIMEOUT_WITHOUT_SETTING };
        if f64::from(released.ticks) > timeout.max(10.0 * self.rules.period) / self.rules.period + 3.0 {
            return broken(SafetyProperty::OldTorque, what);
        }
        if released.ticks > 1 {
            self.exempt(Exemption::Unheard);
        }
        Ok(())
    }
}
