//! A guaranteed lower bound on the clearance of a whole motion.
//!
//! Between samples no gap shrinks faster than its parts can approach. Within a time `h` of a sample a joint moves by at most `|qd| h + A h^2 / 2`,
//! where `A` is its greatest acceleration, and each radian moves a point of a link by at most its longest lever. If the gap minus that distance is
//! still large enough, the whole stretch of time is clear; otherwise the stretch is halved (conservative advancement, Mirtich 1996).

use super::cell::Cell;
use crate::ranked::Ranked;
use dynamics_core::control::trajectory::Motion;
use std::collections::BinaryHeap;

/// Longest initial stretch of time, s.
const STRETCH: f64 = 0.2;
/// Shortest stretch that is halved, s; for shorter ones the gap counts as too small.
const SHORTEST: f64 = 1e-6;
/// Factor for the peaks of a series, which are sampled and may be missed slightly.
const PEAKS: f64 = 1.01;
/// Largest number of stretches that are evaluated for the smallest gap; after these the bound stays as it is.
const LOOKS: usize = 200_000;

/// Smallest gap of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Lower bound on the gap at all times, m.
    pub bound: f64,
    /// Smallest gap at the times that were evaluated, m.
    pub found: f64,
    /// Time of that gap, s from the start.
    pub time: f64,
    /// Index of its pair; [`Cell::names`] gives its names.
    pub pair: usize,
}

/// A motion with its peak velocities and accelerations.
struct Course<'a, const N: usize> {
    motion: &'a Motion<f64, N>,
    velocity: [f64; N],
    acceleration: [f64; N],
}

impl<'a, const N: usize> Course<'a, N> {
    fn new(motion: &'a Motion<f64, N>) -> Self {
        let peaks = motion.peaks();
        Self {
            motion,
            velocity: peaks.velocity.map(|v| PEAKS * v),
            acceleration: peaks.acceleration.map(|a| PEAKS * a),
        }
    }

    /// Position at a time, and upper bounds on the distance of each joint from it within `half`, s.
    fn about(&self, middle: f64, half: f64) -> ([f64; N], [f64; N]) {
        let state = self.motion.sample(middle);
        let way = core::array::from_fn(|i| {
            let by_acceleration = state.qd[i].abs() * half + 0.5 * self.acceleration[i] * half * half;
            by_acceleration.min(self.velocity[i] * half)
        });
        (state.q, way)
    }

    /// Stretches of equal length from start to end.
    fn stretches(&self) -> impl Iterator<Item = (f64, f64)> {
        let count = (self.motion.duration() / STRETCH).ceil().max(1.0);
        let half = 0.5 * self.motion.duration() / count;
        (0..count as usize).map(move |k| ((2 * k + 1) as f64 * half, half))
    }
}

impl<const N: usize> Cell<N> {
    /// True if every gap is at least `required` (m) at every time of the motion. This is guaranteed for the shapes, also between samples.
    #[must_use]
    pub fn keeps(&self, motion: &Motion<f64, N>, required: f64) -> bool {
        let course = Course::new(motion);
        let mut open: Vec<(f64, f64)> = course.stretches().collect();
        while let Some((middle, half)) = open.pop() {
            let (q, way) = course.about(middle, half);
            let poses = self.poses(&q);
            let mut sure = true;
            for pair in &self.pairs {
                let nearer = approach(&pair.per_joint, &way);
                let gap = self.gap_if_below(pair, &poses, required + nearer);
                if gap < required {
                    return false;
                }
                sure &= gap - nearer >= required;
            }
            if !sure {
                if half < SHORTEST {
                    return false;
                }
                open.extend([(middle - 0.5 * half, 0.5 * half), (middle + 0.5 * half, 0.5 * half)]);
            }
        }
        true
    }

    /// Smallest gap of the motion to within `tolerance`, m; `None` if no pair is judged.
    #[must_use]
    pub fn least(&self, motion: &Motion<f64, N>, tolerance: f64) -> Option<Clearance> {
        let start = self.posture(&motion.sample(0.0).q)?;
        let course = Course::new(motion);
        let mut best = Clearance { bound: f64::INFINITY, found: start.gap, time: 0.0, pair: start.pair };
        // Middle and half length of stretches, those with the smallest bound first.
        let mut open: BinaryHeap<Ranked<(f64, f64)>> = BinaryHeap::new();
        for (middle, half) in course.stretches() {
            let bound = self.look(&course, middle, half, &mut best);
            open.push(Ranked { rank: -bound, item: (middle, half) });
        }
        let mut looks = open.len();
        while let Some(Ranked { rank, item: (middle, half) }) = open.pop() {
            let bound = -rank;
            if bound >= best.found - tolerance || looks > LOOKS || half < SHORTEST {
                // The smallest bound of all open stretches, so nothing else is smaller.
                return Some(Clearance { bound: bound.min(best.found), ..best });
            }
            for middle in [middle - 0.5 * half, middle + 0.5 * half] {
                let bound = self.look(&course, middle, 0.5 * half, &mut best);
                open.push(Ranked { rank: -bound, item: (middle, 0.5 * half) });
            }
            looks += 2;
        }
        Some(best)
    }

    /// Lower bound on all gaps in a stretch, m; updates the smallest gap found with that in its middle.
    fn look(&self, course: &Course<'_, N>, middle: f64, half: f64, best: &mut Clearance) -> f64 {
        let (q, way) = course.about(middle, half);
        let poses = self.poses(&q);
        let mut bound = f64::INFINITY;
        for (index, pair) in self.pairs.iter().enumerate() {
            let nearer = approach(&pair.per_joint, &way);
            let gap = self.gap_if_below(pair, &poses, best.found + nearer);
            if gap < best.found {
                (best.found, best.time, best.pair) = (gap, middle, index);
            }
            bound = bound.min(gap - nearer);
        }
        bound
    }
}

/// Upper bound on the approach of two parts while the joints move by at most `way`, m.
fn approach<const N: usize>(per_joint: &[f64; N], way: &[f64; N]) -> f64 {
    per_joint.iter().zip(way).map(|(lever, way)| lever * way).sum()
}
