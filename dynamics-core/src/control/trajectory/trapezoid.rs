//! Trapezoidal speed along a straight line.

use super::bounds::{Bounds, Peaks};
use super::error::{MotionError, check_time};
use crate::control::Reference;
use crate::scalar::Real;

/// A straight line in joint space at constant acceleration, constant speed, and constant deceleration.
///
/// All joints share one path variable `s` from 0 to 1, `q = from + (to - from) s`, so they start, cruise and stop together:
///
/// ```text
/// 0 <= t <= b          s = a t^2 / 2                 a = v / b
/// b <= t <= T - b      s = v (t - b / 2)             v = 1 / (T - b)
/// T - b <= t <= T      s = 1 - a (T - t)^2 / 2
/// ```
///
/// The fastest motion within the bounds has `v = min_i qd_i / |D_i|` and `a = min_i qdd_i / |D_i|`. If the distance is too short to reach
/// `v` (`v^2 > a`), the trapezoid is a triangle of height `v = sqrt(a)`. The acceleration jumps at four moments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trapezoid<S, const N: usize> {
    from: [S; N],
    to: [S; N],
    duration: S,
    ramp: S,
}

impl<S: Real, const N: usize> Trapezoid<S, N> {
    pub(super) fn fastest(from: [S; N], to: [S; N], bounds: &Bounds<S, N>) -> Result<Self, MotionError> {
        Self::check_ends(&from, &to, bounds)?;
        let mut speed = S::literal(f64::INFINITY);
        let mut acceleration = speed;
        for i in 0..N {
            let way = (to[i] - from[i]).abs();
            if way > S::zero() {
                speed = smallest(speed, bounds.velocity[i] / way);
                acceleration = smallest(acceleration, bounds.acceleration[i] / way);
            }
        }
        if !acceleration.is_finite() {
            return Err(MotionError::Unbounded { segment: 0 });
        }
        let speed = smallest(speed, acceleration.sqrt());
        let ramp = speed / acceleration;
        let motion = Self { from, to, duration: S::one() / speed + ramp, ramp };
        Ok(motion.stretched(S::literal(1.0 + Bounds::<S, N>::MARGIN)))
    }

    pub(super) fn timed(
        from: [S; N],
        to: [S; N],
        duration: S,
        ramp_share: S,
        bounds: &Bounds<S, N>,
    ) -> Result<Self, MotionError> {
        Self::check_ends(&from, &to, bounds)?;
        check_time("duration", duration)?;
        if !(ramp_share > S::zero() && ramp_share <= S::literal(0.5)) {
            let value = ramp_share.to_f64();
            return Err(MotionError::OutOfRange { what: "ramp share", value, wanted: "above 0 and at most 1/2" });
        }
        let motion = Self { from, to, duration, ramp: ramp_share * duration };
        bounds.check_peaks(&motion.peaks())?;
        Ok(motion)
    }

    fn check_ends(from: &[S; N], to: &[S; N], bounds: &Bounds<S, N>) -> Result<(), MotionError> {
        bounds.check()?;
        bounds.check_position(0, from)?;
        bounds.check_position(1, to)?;
        let moves = (0..N).any(|i| (to[i] - from[i]).abs() > S::zero());
        if moves { Ok(()) } else { Err(MotionError::Standstill { segment: 0 }) }
    }

    pub(super) fn first(&self) -> [S; N] {
        self.from
    }

    pub(super) fn last(&self) -> [S; N] {
        self.to
    }

    pub(super) fn duration(&self) -> S {
        self.duration
    }

    /// Time of acceleration, and again of deceleration, s.
    #[must_use]
    pub fn ramp(&self) -> S {
        self.ramp
    }

    pub(super) fn stretched(&self, factor: S) -> Self {
        Self { duration: self.duration * factor, ramp: self.ramp * factor, ..*self }
    }

    pub(super) fn peaks(&self) -> Peaks<S, N> {
        let (speed, acceleration) = self.rates();
        let way: [S; N] = core::array::from_fn(|i| (self.to[i] - self.from[i]).abs());
        Peaks { velocity: way.map(|way| way * speed), acceleration: way.map(|way| way * acceleration) }
    }

    /// `v` and `a` of the path variable.
    fn rates(&self) -> (S, S) {
        let speed = S::one() / (self.duration - self.ramp);
        (speed, speed / self.ramp)
    }

    pub(super) fn sample(&self, t: S) -> Reference<S, N> {
        let half = S::literal(0.5);
        let (speed, acceleration) = self.rates();
        let left = self.duration - t;
        // The distance is measured from the nearer end, so that both ends are met exactly.
        let (done, sd, sdd) = if t < self.ramp {
            (Ok(half * acceleration * t * t), acceleration * t, acceleration)
        } else if left < self.ramp {
            (Err(half * acceleration * left * left), acceleration * left, -acceleration)
        } else {
            (Ok(speed * (t - half * self.ramp)), speed, S::zero())
        };
        let mut reference = Reference::at_rest(self.from);
        for i in 0..N {
            let (from, to) = (self.from[i], self.to[i]);
            let way = to - from;
            let q = match done {
                Ok(done) => from + way * done,
                Err(left) => to - way * left,
            };
            let (lo, hi) = if from < to { (from, to) } else { (to, from) };
            reference.q[i] = q.clamp_to(lo, hi);
            reference.qd[i] = way * sd;
            reference.qdd[i] = way * sdd;
        }
        reference
    }
}

fn smallest<S: Real>(a: S, b: S) -> S {
    if a < b { a } else { b }
}
