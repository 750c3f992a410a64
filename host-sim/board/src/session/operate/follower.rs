//! Targets of another program as a smooth reference within the arm's bounds.
//!
//! Each joint has two stages, at points a time `h` apart. The first moves `x` to the target, with a constant acceleration between two points, at most
//! `A`, and a speed of at most `V`. With the distance `L` that is left after `v h / 2`, it stops in the least number `n` of steps that `A` allows:
//!
//! ```text
//! n (n + 1) >= 2 L / (A h^2),   v1 = 2 L / (h (n + 1)),   x1 = x + h (v + v1) / 2
//! ```
//!
//! It does not pass a target that it can still stop at. The second stage is the mean of `x` over the last `M` steps, so that the acceleration has no
//! jumps and is linear between two points, where the board's fifth-degree polynomial repeats it exactly:
//!
//! ```text
//! q'' = (v_k - v_(k-M)) / (M h),   q' = (x_k - x_(k-M)) / (M h),   q = sum (x_i + h v_i / 3 + h v_(i+1) / 6) / M
//! ```
//!
//! A mean exceeds no bound that its values keep. The mean delays the reference by `M h / 2`.

use link::{Joints, Reference};

/// Steps of the mean, `M`.
const MEAN: usize = 5;

/// Distance, rad or m, below which a joint is at its target.
const ARRIVED: f64 = 1e-11;

/// Farthest target, rad or m, of a joint without limits.
const FARTHEST: f64 = 1e4;

/// Bounds of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointBounds {
    /// Lowest and highest position, rad or m.
    pub position: (f64, f64),
    /// Greatest speed, rad/s or m/s.
    pub velocity: f64,
    /// Greatest acceleration, rad/s^2 or m/s^2.
    pub acceleration: f64,
}

/// Reason why a target was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BadTarget {
    /// Another number of joints.
    #[error("{found} positions, expected {expected}")]
    Joints {
        /// Number of positions.
        found: usize,
        /// Number of joints.
        expected: usize,
    },
    /// A position that is no number, or outside the limits.
    #[error("joint {joint}: {position:.4}, expected {low:.4} to {high:.4}")]
    Outside {
        /// The joint, counted from 1.
        joint: usize,
        /// The position, rad or m.
        position: f64,
        /// Lowest position.
        low: f64,
        /// Highest position.
        high: f64,
    },
}

/// A joint on its way to a target.
#[derive(Clone, Debug)]
struct Joint {
    bounds: JointBounds,
    /// Position and velocity of the first stage at the last points, the oldest first.
    past: [(f64, f64); MEAN + 1],
    target: f64,
}

impl Joint {
    fn at_rest(q: f64, bounds: JointBounds) -> Self {
        Self { bounds, past: [(q, 0.0); MEAN + 1], target: q }
    }

    fn now(&self) -> (f64, f64) {
        let [.., now] = self.past;
        now
    }

    /// Advances by `h`, s. With `brakes`, to rest on the shortest way instead of to the target.
    fn step(&mut self, h: f64, brakes: bool) {
        let (x, v) = self.now();
        let JointBounds { velocity, acceleration, .. } = self.bounds;
        let change = acceleration * h;
        let left = self.target - x - 0.5 * h * v;
        let next = if brakes {
            (x + 0.5 * h * (v + v - v.clamp(-change, change)), v - v.clamp(-change, change))
        } else if left.abs() < ARRIVED && v.abs() <= change {
            (self.target, 0.0)
        } else {
            let steps = (0.5 * ((1.0 + 8.0 * left.abs() / (change * h)).sqrt() - 1.0)).ceil();
            let wanted = 2.0 * left / (h * (steps + 1.0));
            let v1 = wanted.clamp(-velocity, velocity).clamp(v - change, v + change);
            (x + 0.5 * h * (v + v1), v1)
        };
        self.past.rotate_left(1);
        self.past[MEAN] = next;
    }

    /// Position, velocity and acceleration of the mean.
    #[allow(clippy::float_cmp, reason = "at rest, all positions have the same bits")]
    fn mean(&self, h: f64) -> [f64; 3] {
        let [(x0, v0), ..] = self.past;
        let (x1, v1) = self.now();
        if self.past.iter().all(|&(x, v)| x == x1 && v == 0.0) {
            return [x1, 0.0, 0.0];
        }
        let of = |pair: &[(f64, f64)]| match pair {
            [(x, v), (_, next)] => x + h * (v / 3.0 + next / 6.0),
            _ => 0.0,
        };
        let count = MEAN as f64;
        let q = self.past.windows(2).map(of).sum::<f64>() / count;
        [q, (x1 - x0) / (count * h), (v1 - v0) / (count * h)]
    }
}

/// A reference that follows targets.
#[derive(Clone, Debug)]
pub struct Follower {
    joints: Vec<Joint>,
    /// Time between two points, s.
    step: f64,
    brakes: bool,
}

impl Follower {
    /// A reference at rest at `q`, with points `step` (s) apart. `None` if a bound is not finite or not above zero.
    #[must_use]
    pub fn new(q: &[f64], bounds: &[JointBounds], step: f64) -> Option<Self> {
        let is_bound = |value: f64| value.is_finite() && value > 0.0;
        let bounded = bounds.iter().all(|joint| is_bound(joint.velocity) && is_bound(joint.acceleration));
        let joints = q.iter().zip(bounds).map(|(q, bounds)| Joint::at_rest(*q, *bounds)).collect();
        (bounded && q.len() == bounds.len() && is_bound(step)).then_some(Self { joints, step, brakes: false })
    }

    /// Goes to these positions from here on.
    ///
    /// # Errors
    /// [`BadTarget`]; nothing is changed.
    pub fn go_to(&mut self, target: &[f64]) -> Result<(), BadTarget> {
        if target.len() != self.joints.len() {
            return Err(BadTarget::Joints { found: target.len(), expected: self.joints.len() });
        }
        for (joint, (state, &position)) in (1..).zip(self.joints.iter().zip(target)) {
            let (low, high) = state.bounds.position;
            if !(low..=high).contains(&position) || position.abs() > FARTHEST {
                return Err(BadTarget::Outside { joint, position, low, high });
            }
        }
        self.joints.iter_mut().zip(target).for_each(|(joint, target)| joint.target = *target);
        Ok(())
    }

    /// Comes to rest on the shortest way, whatever the target.
    pub fn brake(&mut self) {
        self.brakes = true;
    }

    /// True if it brakes.
    #[must_use]
    pub fn is_braking(&self) -> bool {
        self.brakes
    }

    /// Positions of the reference, rad or m.
    #[must_use]
    pub fn position(&self) -> Vec<f64> {
        self.joints.iter().map(|joint| joint.mean(self.step)[0]).collect()
    }

    /// True if it brakes and has come to rest.
    #[must_use]
    pub fn has_stopped(&self) -> bool {
        self.brakes && self.joints.iter().all(|joint| joint.past.iter().all(|&(_, v)| v == 0.0))
    }

    /// The next point of the reference.
    pub fn next_point(&mut self) -> Reference {
        let (h, brakes) = (self.step, self.brakes);
        self.joints.iter_mut().for_each(|joint| joint.step(h, brakes));
        let of = |value: usize| {
            let all = self.joints.iter().map(|joint| joint.mean(h).get(value).copied().unwrap_or(0.0) as f32);
            all.take(link::JOINTS_MAX).collect::<Joints<f32>>()
        };
        Reference { q: of(0), qd: of(1), qdd: of(2) }
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::float_cmp,
        reason = "a test that fails should stop there; an arm at rest is at its target"
    )]
    use super::{BadTarget, Follower, JointBounds, MEAN};
    use proptest::prelude::*;

    const H: f64 = 0.01;
    const BOUNDS: JointBounds = JointBounds { position: (-3.0, 3.0), velocity: 1.5, acceleration: 8.0 };

    fn points(follower: &mut Follower, count: usize) -> Vec<[f64; 3]> {
        let of = |joints: &link::Joints<f32>| f64::from(joints[0]);
        (0..count)
            .map(|_| {
                let point = follower.next_point();
                [of(&point.q), of(&point.qd), of(&point.qdd)]
            })
            .collect()
    }

    #[test]
    fn a_distant_target_is_reached_at_rest_in_little_more_than_the_shortest_time() {
        let mut follower = Follower::new(&[0.0], &[BOUNDS], H).unwrap();
        follower.go_to(&[2.0]).unwrap();
        let all = points(&mut follower, 400);
        let arrived = all.iter().position(|point| *point == [2.0, 0.0, 0.0]).unwrap();
        // At full acceleration and speed: V / A + distance / V, and the delay of the mean.
        let shortest = (BOUNDS.velocity / BOUNDS.acceleration + 2.0 / BOUNDS.velocity) / H + MEAN as f64;
        assert!((arrived as f64) < shortest + 3.0, "{arrived} points, {shortest}");
        assert!(all[arrived..].iter().all(|point| *point == [2.0, 0.0, 0.0]), "it stays there");
        assert!(all.iter().any(|point| (point[1] - BOUNDS.velocity).abs() < 1e-6), "it uses its speed");
    }

    #[test]
    fn what_is_outside_the_limits_or_no_number_is_refused_and_changes_nothing() {
        let mut follower = Follower::new(&[0.0, 0.0], &[BOUNDS; 2], H).unwrap();
        for (target, joint) in [([0.0, 3.1], 2), ([f64::NAN, 0.0], 1), ([f64::NEG_INFINITY, 0.0], 1)] {
            let refused = follower.go_to(&target).unwrap_err();
            assert!(matches!(refused, BadTarget::Outside { joint: named, .. } if named == joint), "{refused}");
        }
        assert_eq!(follower.go_to(&[0.0]), Err(BadTarget::Joints { found: 1, expected: 2 }));
        assert_eq!(follower.next_point().qd.as_slice(), [0.0, 0.0]);
        let endless = JointBounds { velocity: f64::INFINITY, ..BOUNDS };
        assert!(Follower::new(&[0.0], &[endless], H).is_none());
    }

    #[test]
    fn it_brakes_with_its_whole_acceleration_and_stays_at_rest() {
        let mut follower = Follower::new(&[0.0], &[BOUNDS], H).unwrap();
        follower.go_to(&[3.0]).unwrap();
        let moving = points(&mut follower, 60);
        follower.brake();
        let braked = points(&mut follower, 60);
        assert!(follower.has_stopped());
        let distance = braked[59][0] - moving[59][0];
        let shortest = 0.5 * BOUNDS.velocity.powi(2) / BOUNDS.acceleration;
        // The mean is late by half its length.
        let late = 0.5 * H * MEAN as f64 * BOUNDS.velocity;
        assert!((distance - shortest - late).abs() < 0.02 * shortest, "{distance}, {shortest} and {late}");
        let end = braked[59];
        follower.go_to(&[-3.0]).unwrap();
        assert_eq!(points(&mut follower, 5), [end; 5], "a target does not end the braking");
    }

    proptest! {
        /// Whatever the targets: bounds are kept, no target is passed that was there from rest, and between two points velocity and position are the
        /// integrals of an acceleration that is linear.
        #[test]
        fn bounds_are_kept_and_points_fit_together(
            targets in proptest::collection::vec((-3.0..3.0, 1_usize..40), 1..12),
            velocity in 0.01..10.0,
            acceleration in 0.1..100.0,
            step in 0.001..0.02,
        ) {
            let bounds = JointBounds { position: (-3.0, 3.0), velocity, acceleration };
            let mut follower = Follower::new(&[0.0], &[bounds], step).unwrap();
            let mut before = [0.0; 3];
            for (target, count) in targets {
                follower.go_to(&[target]).unwrap();
                for _ in 0..count {
                    follower.joints[0].step(step, false);
                    let now = follower.joints[0].mean(step);
                    let [q, qd, qdd] = now;
                    prop_assert!((-3.0 - 1e-9..=3.0 + 1e-9).contains(&q), "{q}");
                    prop_assert!(qd.abs() <= velocity * (1.0 + 1e-9), "{qd}");
                    prop_assert!(qdd.abs() <= acceleration * (1.0 + 1e-9), "{qdd}");
                    let speed = before[1] + 0.5 * step * (before[2] + qdd);
                    let place = before[0] + step * before[1] + step * step * (2.0 * before[2] + qdd) / 6.0;
                    prop_assert!((qd - speed).abs() <= 1e-9 * (1.0 + velocity), "{qd}, {speed}");
                    prop_assert!((q - place).abs() <= 1e-9, "{q}, {place}");
                    before = now;
                }
            }
        }

        #[test]
        fn from_rest_no_target_is_passed(target in 0.0..3.0_f64, velocity in 0.01..10.0, acceleration in 0.1..100.0) {
            let bounds = JointBounds { position: (-3.0, 3.0), velocity, acceleration };
            let mut follower = Follower::new(&[0.0], &[bounds], H).unwrap();
            follower.go_to(&[target]).unwrap();
            for _ in 0..2000 {
                follower.joints[0].step(H, false);
                let (x, v) = follower.joints[0].now();
                prop_assert!(x <= target + 1e-12 && v >= 0.0, "{x} of {target}, {v}");
            }
        }
    }
}
