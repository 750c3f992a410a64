//! Readings from the judge's view: computed independently in f64, and only certain faults are reported.
//!
//! The machine rounds to f32 and the judge does not, so for a value exactly on a bound they may disagree. The judge therefore reports only values
//! that exceed a bound by more than such rounding ([`beyond`]).

use crate::campaign::machine::TickInputs;
use dynamics_core::safety::Rules;
use dynamics_core::{ControllerConfig, Sensed};
use session::Drives;
use std::collections::VecDeque;

/// Margin beyond a bound, relative to the bound plus one unit (for bounds near zero): 80 times the rounding of f32.
const DOUBT: f64 = 1e-5;

/// Relative margin for differences of large numbers: 16 times the rounding of f32.
const ROUNDING: f64 = 1e-6;

/// True if a value exceeds a bound by more than rounding errors.
pub(super) fn beyond(value: f64, bound: f64) -> bool {
    value > bound + DOUBT * (1.0 + bound.abs())
}

/// Faults in the readings of a tick, as codes of docs/safety.md, in the order of the joints.
#[derive(Clone, Debug)]
pub(super) struct ReadingFaults<const N: usize> {
    /// All certain faults.
    pub(super) faults: Vec<u8>,
    /// True if a joint has moved for the whole time that a certain decision needs.
    pub(super) moves: bool,
    /// Positions as read, including NaN and infinity.
    pub(super) position: [f64; N],
    /// True if the positions come from encoders.
    pub(super) counted: bool,
}

/// History of the readings.
#[derive(Clone, Debug)]
pub(super) struct Observation<const N: usize> {
    /// Tick and value of each joint's last good reading.
    last: [Option<(i64, f64)>; N],
    /// Positions of the last ticks, the newest last; cleared by a position that is not finite.
    track: VecDeque<[f64; N]>,
    /// Number of ticks over which a speed is averaged: a multiple of the observer's time constant.
    pub(super) window: usize,
}

impl<const N: usize> Observation<N> {
    pub(super) fn new(config: &ControllerConfig<f64, N>) -> Self {
        // g = 1 - exp(-2 bandwidth h): the window is 8 / bandwidth on each side of its middle.
        let [_, _, g, _] = config.observer.gains();
        let decay = -0.5 * (1.0 - g).ln();
        let window = if decay > 0.0 { (16.0 / decay).ceil() as usize } else { 1 };
        Self { last: [None; N], track: VecDeque::new(), window: window.clamp(10, 1000) }
    }

    /// Checks the readings of a tick. `acted` is the number of ticks with torque; `None` if mean speeds carry no information.
    pub(super) fn look(
        &mut self,
        now: i64,
        told: &TickInputs<N>,
        config: &ControllerConfig<f64, N>,
        rules: &Rules<f64, N>,
        acted: Option<usize>,
    ) -> ReadingFaults<N> {
        let (q, qd) = match &told.sensed {
            Sensed::State { q, qd } => (q.map(f64::from), Some(qd.map(f64::from))),
            Sensed::Counts(counts) => {
                let at =
                    |i: usize| f64::from(counts[i].wrapping_sub(config.encoder[i].zero)) * config.encoder[i].per_count;
                (core::array::from_fn(at), None)
            }
        };
        let mut seen = ReadingFaults { faults: Vec::new(), moves: false, position: q, counted: qd.is_none() };
        if q.iter().all(|x| x.is_finite()) {
            self.track.push_back(q);
        } else {
            self.track.clear();
        }
        while self.track.len() > 2 * self.window + 1 {
            self.track.pop_front();
        }
        for i in 0..N {
            let speed = qd.map(|qd| qd[i].abs());
            if told.age_ticks[i] > config.age_max {
                seen.faults.push(3);
            }
            if !q[i].is_finite() || speed.is_some_and(|speed| !speed.is_finite()) {
                seen.faults.push(1);
                continue;
            }
            let taken = now - i64::from(told.age_ticks[i]);
            if let Some((before, place)) = self.last[i] {
                let ticks = (taken - before).max(0) as f64;
                let way = rules.joints[i].jump_step * ticks + rules.joints[i].resolution;
                // A difference of large numbers has the rounding errors of those numbers.
                if beyond((q[i] - place).abs(), way + ROUNDING * (q[i].abs() + place.abs())) {
                    seen.faults.push(8);
                }
            }
            self.last[i] = Some((taken, q[i]));
            let (low, high) = config.limits[i].position;
            let margin = config.guard[i].position_margin;
            if beyond(q[i], high + margin) || beyond(low - margin, q[i]) {
                seen.faults.push(4);
            }
            let guard = config.guard[i].velocity_max;
            let too_fast = match speed {
                Some(speed) => beyond(speed, guard),
                // With torque in the whole window, the mean speed was reached at some instant; the margin covers the
                // observer's lag.
                None => {
                    acted.is_some_and(|ticks| ticks > self.window)
                        && self.mean(i, 0, rules.period).is_some_and(|v| beyond(v.abs(), 1.25 * guard))
                }
            };
            if too_fast {
                seen.faults.push(5);
            }
            seen.moves |= match speed {
                Some(speed) => beyond(speed, rules.joints[i].rest_speed),
                None => acted.is_some() && self.moves_on(i, 3.0 * rules.joints[i].rest_speed, rules.period),
            };
        }
        seen
    }

    /// True if joint `i` moved faster than `speed` in both of the last two windows, in the same direction.
    fn moves_on(&self, i: usize, speed: f64, period: f64) -> bool {
        match (self.mean(i, 0, period), self.mean(i, self.window, period)) {
            (Some(now), Some(before)) => now.abs() > speed && before.abs() > speed && now * before > 0.0,
            _ => false,
        }
    }

    /// Mean speed of joint `i` over a window that ended `ago` ticks ago, rad/s or m/s.
    pub(super) fn mean(&self, i: usize, ago: usize, period: f64) -> Option<f64> {
        let end = self.track.len().checked_sub(1 + ago)?;
        let (from, to) = (self.track.get(end.checked_sub(self.window)?)?, self.track.get(end)?);
        Some((to[i] - from[i]) / (self.window as f64 * period))
    }
}

/// The acting torque in f64, N m or N, on open or engaged brakes; `None` if no torque acts.
pub(super) fn torque<const N: usize>(drives: &Drives<N>) -> Option<[f64; N]> {
    match drives {
        Drives::Drive(torque) | Drives::Preload(torque) => Some(torque.map(f64::from)),
        Drives::Safe(_) | Drives::Enable(_) => None,
    }
}
