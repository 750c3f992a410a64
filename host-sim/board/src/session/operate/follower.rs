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

/// A motion along targets.
#[derive(Clone, Debug)]
pub(super) struct Following {
    /// The reference.
    pub(super) follower: Follower,
    /// Longest time between two targets, s.
    pub(super) patience: f64,
}

#[cfg(test)]
mod tests;
