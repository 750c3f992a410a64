//! Position and velocity from encoder counts.

use crate::fields::record;
use crate::scalar::Real;

record! {
    /// Joint position from encoder counts: `q = (counts - zero) * per_count`.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Encoder<S> {
        /// Counts at `q = 0`.
        pub zero: i32,
        /// Joint position per count, rad or m.
        pub per_count: S,
    }
}

impl<S: Real> Encoder<S> {
    /// Joint position, rad or m. The offset is subtracted in integers, which wrap and lose nothing.
    #[inline]
    pub fn position(&self, counts: i32) -> S {
        S::from_i32(counts.wrapping_sub(self.zero)) * self.per_count
    }

    /// Counts of a joint position, rad or m: the inverse of [`position`](Self::position), rounded to the nearest count, halves away from zero.
    ///
    /// `counts(position(c)) == c` while `c` is less than 2^23 counts from `zero` in `f32`, and for every `c` in `f64`. A distance from `zero`
    /// beyond the range of `i32` is cut to it; NaN gives `zero`. The division is in double precision: for a simulated encoder or a limit that is
    /// converted once, rather than for every tick of a core without it.
    #[must_use]
    pub fn counts(&self, position: S) -> i32 {
        // The cast cuts to the range of `i32`, and makes 0 of NaN.
        let counts = libm::round(position.to_f64() / self.per_count.to_f64()) as i32;
        counts.wrapping_add(self.zero)
    }
}

record! {
    /// A tracking observer: a critically damped g-h filter with the reference acceleration as an input.
    ///
    /// ```text
    /// x-      = x + h v + (h^2 / 2) a        predict, with the reference's acceleration a
    /// v-      = v + h a
    /// e       = q - x-
    /// x       = x- + g e                     correct
    /// v       = v- + k e
    /// g = 1 - p^2,  k = (1 - p)^2 / h,  p = exp(-bandwidth h)
    /// ```
    ///
    /// Both poles of the error lie at `p`. If the acceleration is constant and is an input, there is no lag. An unknown acceleration
    /// makes the velocity lag by `a h ((1 + p) / (1 - p) - 1/2)`, about `2 a / bandwidth`, and the position by
    /// `a h^2 p^2 / (1 - p)^2`, about `a / bandwidth^2`. (The filter: Brookner, *Tracking and Kalman Filtering Made
    /// Easy*, ch. 1, critically damped g-h filter. The lag: set the error equal to the one before in the equations
    /// above.)
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct TrackingObserver<S> made by from_gains {
        period: S,
        half_period_squared: S,
        g: S,
        k: S,
    }
}

impl<S: Real> TrackingObserver<S> {
    /// An observer with both poles at `exp(-bandwidth * period)`.
    ///
    /// | name | quantity | unit |
    /// |---|---|---|
    /// | `bandwidth` | bandwidth | rad/s |
    /// | `period` | time between samples | s |
    #[must_use]
    pub fn new(bandwidth: f64, period: f64) -> Self {
        let pole = libm::exp(-bandwidth * period);
        Self::from_gains(
            S::literal(period),
            S::literal(0.5 * period * period),
            S::literal(1.0 - pole * pole),
            S::literal((1.0 - pole) * (1.0 - pole) / period),
        )
    }

    /// From the numbers that [`TrackingObserver::gains`] returned, for example on the desk at build time.
    #[must_use]
    pub const fn from_gains(period: S, half_period_squared: S, g: S, k: S) -> Self {
        Self { period, half_period_squared, g, k }
    }

    /// An observer without memory: a step from a zero estimate gives exactly the measured position, at rest.
    #[must_use]
    pub(super) fn start() -> Self {
        Self::from_gains(S::zero(), S::zero(), S::one(), S::zero())
    }

    /// `[h, h^2 / 2, g, k]`.
    #[must_use]
    pub const fn gains(&self) -> [S; 4]
    where
        S: Copy,
    {
        [self.period, self.half_period_squared, self.g, self.k]
    }

    /// The estimate `(x, v)` one step on, without a new position.
    #[inline]
    pub fn predict(&self, x: S, v: S, acceleration: S) -> (S, S) {
        (x + self.period * v + self.half_period_squared * acceleration, v + self.period * acceleration)
    }

    /// The next estimate `(x, v)` from the last, the acceleration over the step, and the new position.
    #[inline]
    pub fn step(&self, x: S, v: S, acceleration: S, position: S) -> (S, S) {
        let predicted = x + self.period * v + self.half_period_squared * acceleration;
        let error = position - predicted;
        (predicted + self.g * error, v + self.period * acceleration + self.k * error)
    }
}
