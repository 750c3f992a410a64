//! Arithmetic on bounds: the errors passed on from the operands, and the operation's own rounding.

use super::{Bounded, Origin, hypotenuse, plus, times};
use crate::precision::rounding::Rounding;
use core::ops::{Add, Div, Mul, Neg, Sub};
use dynamics_core::{Field, Scalar, assign_by_operators};
use num_traits::{One, Zero};

impl<R: Rounding> Add for Bounded<R> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        if self.vanishes() {
            return other;
        }
        if other.vanishes() {
            return self;
        }
        let (mut lo, mut hi) = ((self.lo + other.lo).next_down(), (self.hi + other.hi).next_up());
        let mut brought = plus(self.error, other.error);
        if let (
            Origin::Turned { by: a, size: size_a, error: error_a, rest: rest_a },
            Origin::Turned { by: b, size: size_b, error: error_b, rest: rest_b },
        ) = (self.origin, other.origin)
            && a.joint == b.joint
            && a.cosine != b.cosine
        {
            let size = hypotenuse(size_a, size_b);
            (lo, hi) = (lo.max(-size), hi.min(size));
            brought = brought.min(plus(hypotenuse(error_a, error_b), plus(rest_a, rest_b)));
        }
        Self::rounded(lo, hi, brought, R::of_sum).0
    }
}

impl<R: Rounding> Mul for Bounded<R> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        if self.vanishes() || other.vanishes() {
            // Zero times a value that may have overflowed may be NaN.
            let finite = self.error.is_finite() && other.error.is_finite();
            return if finite { Self::exact(0.0, 0.0) } else { Self::unbounded() };
        }
        if let Some(factor) = self.power_of_two() {
            return other.scaled(factor);
        }
        if let Some(factor) = other.power_of_two() {
            return self.scaled(factor);
        }
        let products = [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        if products.iter().any(|x| x.is_nan()) {
            return Self::unbounded();
        }
        let lo = products.iter().fold(f64::INFINITY, |lo, x| lo.min(*x)).next_down();
        let hi = products.iter().fold(f64::NEG_INFINITY, |hi, x| hi.max(*x)).next_up();
        let (a, b) = match other.origin {
            Origin::Turn(_) if !matches!(self.origin, Origin::Turn(_)) => (other, self),
            _ => (self, other),
        };
        // Contribution of the first operand's error, then of the second one's.
        let from_a = plus(times(b.size(), a.error), times(a.error, b.error));
        let from_b = times(a.size(), b.error);
        let (product, own) = Self::rounded(lo, hi, plus(from_a, from_b), R::of_product);
        let origin = match a.origin {
            Origin::Turn(by) => Origin::Turned { by, size: b.size(), error: b.error, rest: plus(from_a, own) },
            _ => Origin::Other,
        };
        Self { origin, ..product }
    }
}

impl<R: Rounding> Div for Bounded<R> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        // The computed divisor must stay away from zero too.
        let least = if other.lo > 0.0 { other.lo } else { -other.hi };
        let clear = (least - other.error).next_down();
        if clear.is_nan() || clear <= 0.0 {
            return Self::unbounded();
        }
        let quotients = [self.lo / other.lo, self.lo / other.hi, self.hi / other.lo, self.hi / other.hi];
        if quotients.iter().any(|x| x.is_nan()) {
            return Self::unbounded();
        }
        let lo = quotients.iter().fold(f64::INFINITY, |lo, x| lo.min(*x)).next_down();
        let hi = quotients.iter().fold(f64::NEG_INFINITY, |hi, x| hi.max(*x)).next_up();
        // a'/b' - a/b = ((a' - a) - a/b (b' - b)) / b'
        let brought = plus(self.error, times(lo.abs().max(hi.abs()), other.error));
        let brought = if brought == 0.0 { 0.0 } else { (brought / clear).next_up() };
        Self::rounded(lo, hi, brought, R::of_product).0
    }
}

impl<R: Rounding> Neg for Bounded<R> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo, ..self }
    }
}

impl<R: Rounding> Sub for Bounded<R> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

assign_by_operators!(Bounded<R>, R: Rounding);

impl<R: Rounding> Zero for Bounded<R> {
    #[inline]
    fn zero() -> Self {
        Self::exact(0.0, 0.0)
    }
    #[inline]
    fn is_zero(&self) -> bool {
        self.vanishes()
    }
}

impl<R: Rounding> One for Bounded<R> {
    #[inline]
    fn one() -> Self {
        Self::exact(1.0, 1.0)
    }
}

impl<R: Rounding> Scalar for Bounded<R> {
    /// A constant: the exact value is `x`, the computed one the nearest number of the format.
    #[inline]
    fn literal(x: f64) -> Self {
        // The two are so close that their difference is exact.
        let error = if x.is_finite() { (x - R::nearest(x)).abs() } else { 0.0 };
        Self::within(x, x, error)
    }
}

impl<R: Rounding> Field for Bounded<R> {}
