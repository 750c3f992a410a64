//! Readings as the judge takes them: its own arithmetic in f64, and only what is beyond doubt.
//!
//! The machine rounds to f32 and the judge does not, so that something exactly on a bound may be seen by one of them alone. The judge
//! calls out what is beyond the bound by more than such rounding ([`beyond`]).

use crate::study::campaign::machine::Told;
use dynamics_core::safety::Rules;
use dynamics_core::{ControllerConfig, Sensed};
use std::collections::VecDeque;

/// Share by which a number must be beyond a bound, and a part of a unit for bounds near zero: 80 times the rounding of f32.
const DOUBT: f64 = 1e-5;

/// The same of a difference of large numbers: 16 times the rounding of f32.
const ROUNDING: f64 = 1e-6;

/// Beyond a bound, whatever was rounded on the way.
pub(super) fn beyond(value: f64, bound: f64) -> bool {
    value > bound + DOUBT * (1.0 + bound.abs())
}

/// Faults of the readings of a tick, by the codes of docs/safety.md, the first joint's first.
#[derive(Clone, Debug)]
pub(super) struct Seen<const N: usize> {
    /// All that is beyond doubt.
    pub(super) faults: Vec<u8>,
    /// A joint has moved all the time that it takes to be sure.
    pub(super) moves: bool,
    /// Positions as read, NaN and infinity too.
    pub(super) position: [f64; N],
    /// Encoders measure them.
    pub(super) counted: bool,
}

/// Memory of the readings.
#[derive(Clone, Debug)]
pub(super) struct Observation<const N: usize> {
    /// Per joint, when its last good reading was taken, and what it was.
    last: [Option<(i64, f64)>; N],
    /// Positions of the last ticks, the newest last; emptied by one with a NaN.
    track: VecDeque<[f64; N]>,
    /// Ticks that a speed is judged over: so many times what the machine's observer takes.
    pub(super) window: usize,
}

impl<const N: usize> Observation<N> {
    pub(super) fn new(config: &ControllerConfig<f64, N>) -> Self {
        // g = 1 - exp(-2 bandwidth h): eight times 1 / bandwidth on each side of the middle.
        let [_, _, g, _] = config.observer.gains();
        let decay = -0.5 * (1.0 - g).ln();
        let window = if decay > 0.0 { (16.0 / decay).ceil() as usize } else { 1 };
        Self { last: [None; N], track: VecDeque::new(), window: window.clamp(10, 1000) }
    }

    /// Look at a tick; `acted` is for how many ticks torque has acted, `None` where means of readings say nothing.
    pub(super) fn look(
        &mut self,
        now: i64,
        told: &Told<N>,
        config: &ControllerConfig<f64, N>,
        rules: &Rules<f64, N>,
        acted: Option<usize>,
    ) -> Seen<N> {
        let (q, qd) = match &told.sensed {
            Sensed::State { q, qd } => (q.map(f64::from), Some(qd.map(f64::from))),
            Sensed::Counts(counts) => {
                let at =
                    |i: usize| f64::from(counts[i].wrapping_sub(config.encoder[i].zero)) * config.encoder[i].per_count;
                (core::array::from_fn(at), None)
            }
        };
        let mut seen = Seen { faults: Vec::new(), moves: false, position: q, counted: qd.is_none() };
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
                // Differences of large numbers are rounded as those are.
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
                // A mean over a window that torque has acted in is some instant's speed; the margin is for the observer's lag.
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

    /// Whether joint `i` was faster than this over both of the last two windows, and to the same side.
    fn moves_on(&self, i: usize, speed: f64, period: f64) -> bool {
        match (self.mean(i, 0, period), self.mean(i, self.window, period)) {
            (Some(now), Some(before)) => now.abs() > speed && before.abs() > speed && now * before > 0.0,
            _ => false,
        }
    }

    /// Mean speed of joint `i` over a window that ended so many ticks ago, rad/s or m/s.
    pub(super) fn mean(&self, i: usize, ago: usize, period: f64) -> Option<f64> {
        let end = self.track.len().checked_sub(1 + ago)?;
        let (from, to) = (self.track.get(end.checked_sub(self.window)?)?, self.track.get(end)?);
        Some((to[i] - from[i]) / (self.window as f64 * period))
    }
}
