//! Sensor readings and their plausibility.

use super::{Inputs, Rules};
use crate::control::{ControllerConfig, Fault, Reference, believed};
use crate::scalar::Real;

/// Memory of earlier sensor readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sensors<S, const N: usize> {
    /// The last finite position.
    pub(super) last: [S; N],
    /// Age of that position in the last tick. Initially the greatest age, so that any first position is accepted.
    age: [u32; N],
    /// True if all of these ages are zero.
    pub(super) fresh: bool,
}

/// Sensor readings of this tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct JudgedInput<'a, S, const N: usize> {
    /// Position as it was read, rad or m. The observer's estimate would smooth a jump.
    pub(super) read: &'a [S; N],
    pub(super) q: &'a [S; N],
    pub(super) qd: &'a [S; N],
}

/// Result of the exact rules for a tick's readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Judgement {
    /// Fault of the first joint that has one.
    pub(super) fault: Option<Fault>,
    /// True if some joint jumped.
    pub(super) jumped: bool,
}

impl<S: Real, const N: usize> JudgedInput<'_, S, N> {
    /// True if no joint is faster than its rest speed.
    pub(super) fn at_rest(&self, rules: &Rules<S, N>) -> bool {
        self.fast(rules).is_none()
    }

    /// The first joint that is faster than its rest speed.
    pub(super) fn fast(&self, rules: &Rules<S, N>) -> Option<u8> {
        for i in 0..N {
            let rests = self.qd[i].abs() <= rules.joints[i].rest_speed;
            if !rests {
                return Some(i as u8);
            }
        }
        None
    }
}

impl<S: Real, const N: usize> Sensors<S, N> {
    pub(super) fn new() -> Self {
        Self { last: [S::zero(); N], age: [u32::MAX; N], fresh: false }
    }

    /// Judges every joint separately, returns the first fault, and stores the readings.
    pub(super) fn judge(
        &mut self,
        inputs: &Inputs<S, N>,
        seen: &JudgedInput<'_, S, N>,
        config: &ControllerConfig<S, N>,
        rules: &Rules<S, N>,
    ) -> Judgement {
        let mut judgement = Judgement { fault: None, jumped: false };
        self.fresh = true;
        for i in 0..N {
            let (age, rule, position) = (inputs.age_ticks[i], &rules.joints[i], seen.read[i]);
            let elapsed = self.age[i].saturating_add(1).saturating_sub(age);
            let steps = S::from_i32(elapsed.min(i32::MAX as u32) as i32);
            // Without a speed limit the step is infinite, and zero times the step is NaN: then no position counts as
            // too far.
            let way = rule.jump_step * steps + rule.resolution;
            let far = (position - self.last[i]).abs() > way;
            let bounds = believed(config, i);
            let speed = seen.qd[i].abs();
            let finite = position.is_finite() && speed.is_finite();
            if age > config.age_max || far || !is_believed(position, speed, bounds) {
                let jumped = far && finite;
                let fault = name(i as u8, age > config.age_max, finite, jumped, position, bounds);
                judgement.fault = judgement.fault.or(Some(fault));
                judgement.jumped |= jumped;
            }
            if finite {
                (self.last[i], self.age[i]) = (position, age);
            } else {
                self.age[i] = self.age[i].saturating_add(1);
            }
            self.fresh &= self.age[i] == 0;
        }
        judgement
    }
}

/// True if a joint's position and speed are finite and inside their bounds. In a loop, a second comparison is cheaper
/// than making the bound finite first.
#[inline]
fn is_believed<S: Real>(q: S, speed: S, (lo, hi, velocity_max): (S, S, S)) -> bool {
    q >= lo && q <= hi && q.abs() <= S::MAX && speed <= velocity_max && speed <= S::MAX
}

/// Fault of a joint's reading.
#[cold]
fn name<S: Real>(joint: u8, old: bool, finite: bool, jumped: bool, position: S, (lo, hi, _): (S, S, S)) -> Fault {
    if old {
        Fault::StaleMeasurement
    } else if !finite {
        Fault::NonFiniteMeasurement { joint }
    } else if jumped {
        Fault::ImpossibleJump { joint }
    } else if !(position >= lo && position <= hi) {
        Fault::PositionOutOfBounds { joint }
    } else {
        Fault::VelocityOutOfBounds { joint }
    }
}

/// The first joint that is farther from the reference than this multiple of its reach.
pub(super) fn astray<S: Real, const N: usize>(
    reference: &Reference<S, N>,
    seen: &JudgedInput<'_, S, N>,
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
