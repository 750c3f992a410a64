//! Sensor readings and their plausibility.

use super::{Inputs, Rules};
use crate::control::{ControllerConfig, Fault, Observed, Sensed, believed};
use crate::scalar::Real;

/// Memory of earlier sensor readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sensors<S, const N: usize> {
    /// The machine's own observer: the same numbers as the controller's, but it runs in every state.
    observed: Observed<S, N>,
    /// The last finite position.
    last: [S; N],
    /// Age of that position in the last tick. At first the greatest age, so that the joint can have come from anywhere.
    last_age: [u32; N],
}

/// Sensor readings of this tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen<S, const N: usize> {
    pub(super) q: [S; N],
    pub(super) qd: [S; N],
    /// Fault of the first joint that has one.
    pub(super) fault: Option<Fault>,
    /// Some joint jumped.
    pub(super) jumped: bool,
}

impl<S: Real, const N: usize> Seen<S, N> {
    /// Whether no joint is faster than its rest speed. Asked for by requests alone.
    pub(super) fn at_rest(&self, rules: &Rules<S, N>) -> bool {
        (0..N).all(|i| self.qd[i].abs() <= rules.joints[i].rest_speed)
    }
}

impl<S: Real, const N: usize> Sensors<S, N> {
    pub(super) fn new() -> Self {
        Self { observed: Observed::new(), last: [S::zero(); N], last_age: [u32::MAX; N] }
    }

    /// Look, judge and remember. `acceleration` is that of the reference in force.
    #[inline]
    pub(super) fn look(
        &mut self,
        inputs: &Inputs<S, N>,
        acceleration: &[S; N],
        config: &ControllerConfig<S, N>,
        rules: &Rules<S, N>,
    ) -> Seen<S, N> {
        let (q, qd) = self.observed.update(config, acceleration, &inputs.sensed);
        let mut seen = Seen { q: *q, qd: *qd, fault: None, jumped: false };
        // Nearly every tick: all readings are of this tick, and so were those before. Then a step is a constant of the program.
        let mut ages = 0;
        for i in 0..N {
            ages |= inputs.age_ticks[i] | self.last_age[i];
        }
        if ages == 0 {
            let (mut good, mut now) = (true, self.last);
            for i in 0..N {
                let rule = &rules.joints[i];
                let position = position(&inputs.sensed, config, i);
                let far = (position - self.last[i]).abs() > rule.jump_step + rule.resolution;
                good &= !far && is_believed(position, seen.qd[i].abs(), believed(config, i));
                now[i] = position;
            }
            if good {
                self.last = now;
                return seen;
            }
        }
        self.judge(inputs, config, rules, &mut seen);
        seen
    }

    /// Judge every joint by itself, and name the first fault.
    #[cold]
    #[inline(never)]
    fn judge(
        &mut self,
        inputs: &Inputs<S, N>,
        config: &ControllerConfig<S, N>,
        rules: &Rules<S, N>,
        seen: &mut Seen<S, N>,
    ) {
        for i in 0..N {
            let (age, rule) = (inputs.age_ticks[i], &rules.joints[i]);
            let position = position(&inputs.sensed, config, i);
            let elapsed = self.last_age[i].saturating_add(1).saturating_sub(age);
            let steps = S::from_i32(elapsed.min(i32::MAX as u32) as i32);
            // Without a speed limit the step is infinite, and zero steps of it give NaN: then nothing counts as
            // farther.
            let way = rule.jump_step * steps + rule.resolution;
            let far = (position - self.last[i]).abs() > way;
            let bounds = believed(config, i);
            let speed = seen.qd[i].abs();
            let finite = position.is_finite() && speed.is_finite();
            if age > config.age_max || far || !is_believed(position, speed, bounds) {
                let jumped = far && finite;
                seen.fault = seen.fault.or(Some(name(i as u8, age > config.age_max, finite, jumped, position, bounds)));
                seen.jumped |= jumped;
            }
            if finite {
                (self.last[i], self.last_age[i]) = (position, age);
            } else {
                self.last_age[i] = self.last_age[i].saturating_add(1);
            }
        }
    }
}

/// Position of a joint as it was read, rad or m. Not the observer's estimate: it would smooth a jump.
#[inline]
fn position<S: Real, const N: usize>(sensed: &Sensed<S, N>, config: &ControllerConfig<S, N>, i: usize) -> S {
    match sensed {
        Sensed::State { q, .. } => q[i],
        Sensed::Counts(counts) => config.encoder[i].position(counts[i]),
    }
}

/// Whether a joint's position and speed are finite and inside their bounds. In a loop a second comparison costs less
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
