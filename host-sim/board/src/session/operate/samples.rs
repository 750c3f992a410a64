//! Positions and torques of the last ticks.

use std::collections::VecDeque;

/// Length of the window in which a joint's torque is judged, s.
pub(super) const WINDOW: f64 = 0.1;

/// Fewest samples for fitting a parabola.
pub(super) const SAMPLES_MIN: usize = 8;

/// Positions and commanded torques of a tick.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) tick: u32,
    pub(super) q: Vec<f64>,
    pub(super) torque: Vec<f64>,
}

/// The last ticks in which torque acted.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    pub(super) all: VecDeque<Sample>,
    /// Least number of samples that are kept; 0 keeps those of one window.
    room: usize,
    /// Tick in which torque began to act, and the time since then, s.
    first: Option<u32>,
    pub(super) since: f64,
}

impl Samples {
    pub(super) fn push(&mut self, sample: Sample, period: f64) {
        // Statuses may come every tick or every twentieth, so a window is a length of time, not a number of samples.
        let is_old = |first: &Sample| f64::from(sample.tick.wrapping_sub(first.tick)) * period >= WINDOW;
        while self.all.len() >= SAMPLES_MIN.max(self.room) && self.all.front().is_some_and(is_old) {
            self.all.pop_front();
        }
        let first = self.first.get_or_insert(sample.tick);
        self.since = f64::from(sample.tick.wrapping_sub(*first)) * period;
        self.all.push_back(sample);
    }

    /// Discards all samples, and keeps at least this many from here on; 0 keeps those of one window.
    pub(super) fn keep(&mut self, room: usize) {
        self.all.clear();
        self.room = room;
    }

    /// All stored samples, oldest first.
    pub(super) fn all(&self) -> impl Iterator<Item = &Sample> + Clone {
        self.all.iter()
    }

    pub(super) fn clear(&mut self) {
        self.all.clear();
    }
}
