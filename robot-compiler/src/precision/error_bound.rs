//! A scalar that carries a proven bound on its rounding error through the recursion.
//!
//! A [`Bounded`] represents all states of a box at once. An interval `[lo, hi]` contains the exact value `x` in each of
//! them, and an error `e` satisfies `|x_computed - x| <= e` in each. Every operation of precision `R` adds its own rounding to
//! the errors of its operands:
//!
//! ```text
//! a + b    e = ea + eb                         + r(|a + b| + ea + eb)
//! a b      e = |a| eb + |b| ea + ea eb         + r(|a b| + ...)
//! r(M) = half a unit in the last place of M  = u 2^floor(log2 M),  u = 2^-24 in f32, and of a product never below 2^-150
//! ```
//!
//! `|a|` is the largest magnitude of the interval. Products with zero and sums with zero are exact, and so are products
//! with powers of two. All arithmetic is in `f64`, rounded outwards by a unit in the last place per operation. A value that
//! could overflow in `R` has no bound from then on.
//!
//! Intervals lose the relation `sin^2 + cos^2 = 1`. Therefore sines and cosines carry the number of their joint. If a sum contains
//! `sin A` and `cos B` of the same joint, Cauchy's inequality bounds it by `sqrt(|A|^2 + |B|^2)`, and the
//! error contributions by `sqrt(eA^2 + eB^2)`. The plain sum of bounds is up to 1.41 times as large in each rotation of a recursion,
//! in the outward and in the inward pass.

use super::rounding::{Rounding, binade};
use core::marker::PhantomData;
use dynamics_core::SinCos;

mod operators;

/// All values that a number takes in a box of states, and the largest error of the computed ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded<R> {
    lo: f64,
    hi: f64,
    error: f64,
    origin: Origin,
    format: PhantomData<R>,
}

/// Origin of a value, needed for Cauchy's inequality.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Origin {
    Other,
    /// The sine or the cosine of a joint, either sign.
    Turn(Turn),
    /// A turn times a factor of magnitude up to `size`, known to `error`; `rest` is the product's further error.
    Turned {
        by: Turn,
        size: f64,
        error: f64,
        rest: f64,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Turn {
    joint: usize,
    cosine: bool,
}

impl<R: Rounding> Bounded<R> {
    /// A number of the format itself, anywhere from `lo` to `hi`: an input, assumed to be exact.
    #[must_use]
    pub fn exact(lo: f64, hi: f64) -> Self {
        Self::within(lo, hi, 0.0)
    }

    /// A number from `lo` to `hi` that is known to within `error`.
    #[must_use]
    pub fn within(lo: f64, hi: f64, error: f64) -> Self {
        Self { lo, hi, error, origin: Origin::Other, format: PhantomData }
    }

    /// Sine and cosine of every angle of joint `joint` from `lo` to `hi` (rad, up to 2^20), computed to within
    /// `error.0` and `error.1`.
    ///
    /// Every joint needs its own number: all results with one number are assumed to belong to the same angle.
    #[must_use]
    pub fn sin_cos(joint: usize, (lo, hi): (f64, f64), error: (f64, f64)) -> SinCos<Self> {
        let one = |cosine, (lo, hi), error| Self {
            origin: Origin::Turn(Turn { joint, cosine }),
            ..Self::within(lo, hi, error)
        };
        SinCos {
            sin: one(false, range(f64::sin, lo, hi, core::f64::consts::FRAC_PI_2), error.0),
            cos: one(true, range(f64::cos, lo, hi, 0.0), error.1),
        }
    }

    /// Lowest and highest exact value.
    #[must_use]
    pub const fn interval(&self) -> (f64, f64) {
        (self.lo, self.hi)
    }

    /// Largest distance of a computed value from the exact one, in any state of the box. Infinite if overflow is
    /// possible.
    #[must_use]
    pub const fn error(&self) -> f64 {
        self.error
    }

    /// The largest magnitude of the exact value.
    #[inline]
    fn size(&self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    #[inline]
    fn is_exactly(&self, x: f64) -> bool {
        self.lo.to_bits() == x.to_bits() && self.hi.to_bits() == x.to_bits() && self.error == 0.0
    }

    /// Zero of either sign, known exactly.
    #[inline]
    fn vanishes(&self) -> bool {
        self.size() == 0.0 && self.error == 0.0
    }

    /// The value, if it is a power of two of either sign and known exactly.
    #[inline]
    fn power_of_two(&self) -> Option<f64> {
        let exact = self.error == 0.0 && self.lo.to_bits() == self.hi.to_bits();
        (exact && self.lo.abs() >= f64::MIN_POSITIVE && binade(self.lo.abs()).to_bits() == self.lo.abs().to_bits())
            .then_some(self.lo)
    }

    /// A value without a bound: nothing is known about it.
    fn unbounded() -> Self {
        Self::within(f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY)
    }

    /// The result of an operation, from its exact interval, the operands' error contribution, and its rounding.
    #[inline]
    fn rounded(lo: f64, hi: f64, brought: f64, rounding: impl Fn(f64) -> f64) -> (Self, f64) {
        let size = plus(lo.abs().max(hi.abs()), brought);
        // This also detects a NaN: max ignores it, the difference does not.
        if !(size < R::MAX && (hi - lo).is_finite()) {
            return (Self::unbounded(), f64::INFINITY);
        }
        let own = rounding(size);
        (Self::within(lo, hi, plus(brought, own)), own)
    }

    /// The value times a power of two: exact, unless it leaves the range of the format.
    #[inline]
    fn scaled(self, factor: f64) -> Self {
        if self.is_exactly(1.0) {
            return Self::exact(factor, factor);
        }
        let (a, b) = (self.lo * factor, self.hi * factor);
        let (lo, hi) = if factor < 0.0 { (b, a) } else { (a, b) };
        let own = if factor.abs() < 1.0 { R::LEAST } else { 0.0 };
        let scaled = Self::rounded(lo, hi, times(self.error, factor.abs()), |_| own).0;
        // Only an unscaled turn, or its negative, remains a turn.
        let origin = if factor.abs() > 1.0 || factor.abs() < 1.0 { Origin::Other } else { self.origin };
        Self { origin, ..scaled }
    }
}

/// The range of a sine or cosine with maxima at `peak + 2 k pi`, widened by more than the function's own error.
fn range(f: fn(f64) -> f64, lo: f64, hi: f64, peak: f64) -> (f64, f64) {
    const SLACK: f64 = 1e-9;
    const ERROR: f64 = 1e-15;
    let turn = 2.0 * core::f64::consts::PI;
    let passes = |at: f64| ((hi + SLACK - at) / turn).floor() >= ((lo - SLACK - at) / turn).ceil();
    let (a, b) = (f(lo), f(hi));
    let low = if passes(peak + core::f64::consts::PI) { -1.0 } else { (a.min(b) - ERROR).max(-1.0) };
    let high = if passes(peak) { 1.0 } else { (a.max(b) + ERROR).min(1.0) };
    (low, high)
}

/// `a + b` of non-negative numbers, never below the exact sum.
#[inline]
fn plus(a: f64, b: f64) -> f64 {
    if a == 0.0 {
        b
    } else if b == 0.0 {
        a
    } else {
        (a + b).next_up()
    }
}

/// `a b` of non-negative numbers, never below the exact product.
#[inline]
fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { (a * b).next_up() }
}

/// `sqrt(a^2 + b^2)`, never below the exact value.
#[inline]
fn hypotenuse(a: f64, b: f64) -> f64 {
    plus(times(a, a), times(b, b)).sqrt().next_up()
}
