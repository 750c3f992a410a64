//! Positions and torques of the last ticks.

use std::collections::VecDeque;

/// Time over which a joint is judged, s.
pub(super) const WINDOW: f64 = 0.1;

/// Fewest samples of a parabola.
pub(super) const SAMPLES_MIN: usize = 8;

/// Positions and commands of a tick.
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
    /// Samples that are kept at least; 0 keeps those of one window.
    room: usize,
    /// Tick in which torque began to act, and the time since, s.
    first: Option<u32>,
    pub(super) since: f64,
}

impl Samples {
    pub(super) fn push(&mut self, sample: Sample, period: f64) {
        // Statuses may come every tick or every twentieth: a window is a time, not a number of them.
        let is_old = |first: &Sample| f64::from(sample.tick.wrapping_sub(first.tick)) * period >= WINDOW;
        while self.all.len() >= SAMPLES_MIN.max(self.room) && self.all.front().is_some_and(is_old) {
            self.all.pop_front();
        }
        let first = self.first.get_or_insert(sample.tick);
        self.since = f64::from(sample.tick.wrapping_sub(*first)) * period;
        self.all.push_back(sample);
    }

    /// Keep at least so many from here on, and none of before; 0 keeps those of one window.
    pub(super) fn keep(&mut self, room: usize) {
        self.all.clear();
        self.room = room;
    }

    /// All that are kept, oldest first.
    pub(super) fn all(&self) -> impl Iterator<Item = &Sample> + Clone {
        self.all.iter()
    }

    pub(super) fn clear(&mut self) {
        self.all.clear();
    }
}
