//! A queue of motions. They are sent as points of the board's trajectory, as far ahead as the board has capacity.

use super::planned_motion::PlannedMotion;
use dynamics_core::control::trajectory::{Bounds, Motion, MotionError, Timing, Waypoint};
use link::Point;
use std::collections::VecDeque;
use std::rc::Rc;

/// Time between two points, s. The board holds [`session::trajectory::WAYS`] of them, 160 ms. That is longer than a host's usual pauses and than a
/// scene's default heartbeat limit. Between two points the board computes a fifth-degree polynomial that matches position, velocity and acceleration
/// at both.
pub const STEP: f64 = 0.01;

/// Share of a joint's velocity limit that a motion without a given duration uses.
pub const SPEED_SHARE: f64 = 0.5;

/// Shortest duration of a motion without a given duration, s.
pub const DURATION_MIN: f64 = 0.2;

/// Jerk limit of a motion without a given duration, as the shortest time in which a joint reaches its acceleration limit, s.
pub const JERK_TIME: f64 = 0.25;

/// Greatest jerk of a rest-to-rest quintic over unit distance in unit time.
const REST_TO_REST_JERK: f64 = 60.0;

/// Motions still to be sent, one after the other.
#[derive(Clone, Debug)]
pub struct MotionQueue {
    period: f64,
    /// Ticks between two points.
    step: u16,
    start: Option<link::Reference>,
    legs: VecDeque<Leg>,
}

/// A motion and the part of it already sent.
#[derive(Clone, Debug)]
struct Leg {
    motion: Rc<dyn PlannedMotion>,
    /// Ticks already sent.
    sent: u64,
    /// Ticks of the whole motion.
    ticks: u64,
}

impl MotionQueue {
    /// An empty queue, for a control period in s.
    #[must_use]
    pub fn new(period: f64) -> Self {
        Self {
            period,
            step: (STEP / period).round().clamp(1.0, f64::from(u16::MAX)) as u16,
            start: None,
            legs: VecDeque::new(),
        }
    }

    /// Ticks between two points.
    #[must_use]
    pub fn step(&self) -> u16 {
        self.step
    }

    /// Removes all unsent motions.
    pub fn clear(&mut self) {
        self.start = None;
        self.legs.clear();
    }

    /// Starts a new trajectory at this reference, at rest.
    pub fn start(&mut self, at_rest: link::Reference) {
        self.clear();
        self.start = Some(at_rest);
    }

    /// Appends a motion. It must start at the end of the motion before it.
    pub fn push(&mut self, motion: Rc<dyn PlannedMotion>) {
        // The tolerance prevents a rounding error from adding a tick to a motion of a whole number of periods.
        let ticks = (motion.duration() / self.period - 1e-6).ceil().max(1.0) as u64;
        self.legs.push_back(Leg { motion, sent: 0, ticks });
    }

    /// True if there is nothing to send.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.start.is_none() && self.legs.is_empty()
    }

    /// The next point to send.
    pub fn next_point(&mut self) -> Option<Point> {
        if let Some(reference) = self.start.take() {
            return Some(Point { ticks: 0, reference });
        }
        let leg = self.legs.front_mut()?;
        let ticks = u64::from(self.step).min(leg.ticks - leg.sent);
        leg.sent += ticks;
        let done = leg.sent == leg.ticks;
        let reference = if done { leg.motion.end() } else { leg.motion.at(leg.sent as f64 * self.period) };
        if done {
            self.legs.pop_front();
        }
        Some(Point { ticks: u16::try_from(ticks).unwrap_or(u16::MAX), reference })
    }
}

/// Motion from rest to rest, as a fifth-degree polynomial: in the given time, s, or as fast as the bounds allow.
///
/// Without a given time, the jerk is limited too, and the motion lasts [`DURATION_MIN`] at least. With bounds on velocity and acceleration alone, a
/// motion of 1 mrad would last 20 ms at full acceleration, which is a knock.
///
/// # Errors
/// A goal outside the position limits, or a time that would make a joint too fast.
pub fn way<const N: usize>(
    from: [f64; N],
    to: [f64; N],
    duration: Option<f64>,
    bounds: &Bounds<f64, N>,
) -> Result<Motion<f64, N>, MotionError> {
    let points = [Waypoint::through(from), Waypoint::through(to)];
    match duration {
        Some(duration) => Motion::quintic(&points, Timing::Durations(&[duration]), bounds),
        None => {
            let slow = bounds.velocity.map(|velocity| SPEED_SHARE * velocity);
            let fastest = Motion::quintic(&points, Timing::Fastest, &Bounds { velocity: slow, ..*bounds })?;
            let of_jerk = |joint: usize| {
                let jerk = bounds.acceleration[joint] / JERK_TIME;
                (REST_TO_REST_JERK * (to[joint] - from[joint]).abs() / jerk).cbrt()
            };
            let shortest = (0..N).map(of_jerk).fold(DURATION_MIN, f64::max);
            let duration = fastest.duration();
            if duration < shortest { fastest.stretched(shortest / duration) } else { Ok(fastest) }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
    use super::{DURATION_MIN, JERK_TIME, MotionQueue, way};
    use dynamics_core::Reference;
    use dynamics_core::control::trajectory::{Bounds, Motion};
    use std::rc::Rc;

    fn bounds() -> Bounds<f64, 1> {
        Bounds { position: [(-1.0, 1.0)], velocity: [2.0], acceleration: [10.0] }
    }

    #[test]
    fn points_are_10_ms_apart_the_last_one_less_and_end_at_rest_at_the_goal() {
        let mut feed = MotionQueue::new(0.001);
        feed.start(link::Reference::new(&Reference::at_rest([0.2])));
        feed.push(Rc::new(way([0.2], [0.5], Some(0.9955), &bounds()).unwrap()));
        let points: Vec<_> = std::iter::from_fn(|| feed.next_point()).collect();
        let ticks: Vec<u16> = points.iter().map(|point| point.ticks).collect();
        assert_eq!((ticks[0], ticks[1], ticks.len()), (0, 10, 101));
        assert_eq!(ticks.iter().map(|&ticks| u32::from(ticks)).sum::<u32>(), 996);
        let end = &points[100].reference;
        assert_eq!((end.q[0], end.qd[0], end.qdd[0]), (0.5, 0.0, 0.0));
        assert!(feed.is_empty());
    }

    #[test]
    fn a_period_of_more_than_10_ms_has_a_point_every_tick() {
        let mut feed = MotionQueue::new(0.02);
        feed.push(Rc::new(way([0.0], [0.1], Some(1.0), &bounds()).unwrap()));
        assert_eq!(std::iter::from_fn(|| feed.next_point()).map(|point| point.ticks).collect::<Vec<_>>(), [1; 50]);
    }

    #[test]
    fn a_tiny_motion_has_no_more_jerk_than_a_long_one() {
        // Largest jerk: the greatest change of acceleration in a millisecond, over that time.
        let jerk = |motion: &Motion<f64, 1>| {
            let steps = (motion.duration() / 1e-3) as usize;
            let at = |step: usize| motion.sample(step as f64 * 1e-3).qdd[0];
            (0..steps).map(|step| (at(step + 1) - at(step)).abs() / 1e-3).fold(0.0, f64::max)
        };
        let limit = 10.0 / JERK_TIME;
        for distance in [1e-6, 1e-4, 1e-3, 0.01, 0.1, 0.4, 1.0] {
            let motion = way([0.0], [distance], None, &bounds()).unwrap();
            assert!(jerk(&motion) <= 1.001 * limit, "{distance}: {}", jerk(&motion));
            assert!(motion.duration() >= DURATION_MIN, "{distance}: {}", motion.duration());
            // The motion is not longer than the limits require either.
            let needed = (60.0 * distance / limit).cbrt().max(15.0 / 8.0 * distance).max(DURATION_MIN);
            assert!(motion.duration() < 1.01 * needed, "{distance}: {}, {needed}", motion.duration());
        }
        let peak = way([0.0], [1e-3], None, &bounds()).unwrap().peaks().acceleration[0];
        assert!(peak < 0.2, "{peak} of 10 rad/s^2");
    }

    #[test]
    fn no_way_leaves_the_limits_or_is_faster_than_a_joint_may_be() {
        assert!(way([0.0], [1.1], None, &bounds()).unwrap_err().to_string().contains("1.1"));
        assert!(way([0.0], [0.8], Some(0.5), &bounds()).is_err(), "its peak would be 3 rad/s");
        let motion = way([-0.8], [0.8], None, &bounds()).unwrap();
        let peaks = motion.peaks();
        assert!((0.99..=1.0).contains(&peaks.velocity[0]), "half the limit: {peaks:?}");
    }
}
