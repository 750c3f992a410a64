//! A double-double: the sum of two `f64`, about 31 decimal digits.

use core::f64::consts::FRAC_2_PI;
use core::ops::{Add, Div, Mul, Neg, Sub};
use dynamics_core::{Field, Scalar, SinCos, assign_by_operators};
use num_traits::{One, Zero};
use twofloat::TwoFloat;

/// `hi + lo` with `|lo|` at most half a unit in the last place of `hi`: 106 bits.
///
/// Sums and products have errors of a few units of 2^-104 relative to their size, so a recursion of some thousand
/// operations keeps 27 digits or more. Sums and products are the `twofloat` crate's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleDouble(TwoFloat);

impl DoubleDouble {
    /// The sum of two `f64`, exactly.
    #[must_use]
    pub fn sum(a: f64, b: f64) -> Self {
        Self(TwoFloat::new_add(a, b))
    }

    /// The nearest `f64`.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        self.0.hi()
    }

    /// `self - x`, rounded to the nearest `f64`; the difference is taken before rounding.
    #[must_use]
    pub fn minus(self, x: f64) -> f64 {
        (self.0 - x).hi()
    }

    /// Sine and cosine of an angle (rad) to about 30 digits after the point, for angles up to 2^20.
    ///
    /// Quarter turns are subtracted with pi/2 in three parts. Then follows Taylor's series up to `r^31`, whose next term is below
    /// 1e-37 for `|r| <= pi/4`.
    #[must_use]
    pub fn sin_cos(angle: f64) -> SinCos<Self> {
        let turns = (angle * FRAC_2_PI).round();
        // Each product is kept exactly, so the remainder of the angle is accurate to 2^-104 of pi/2.
        let rest = HALF_PI.iter().fold(Self::literal(angle), |rest, part| rest - Self(TwoFloat::new_mul(turns, *part)));
        let square = rest * rest;
        let (mut sine, mut cosine) = (Self::one(), Self::one());
        for k in (1..=15_i32).rev() {
            let k = f64::from(2 * k);
            cosine = Self::one() - square * cosine / Self::literal(k * (k - 1.0));
            sine = Self::one() - square * sine / Self::literal(k * (k + 1.0));
        }
        let sine = rest * sine;
        let (sin, cos) = match (turns as i64).rem_euclid(4) {
            0 => (sine, cosine),
            1 => (cosine, -sine),
            2 => (-sine, -cosine),
            _ => (-cosine, sine),
        };
        SinCos { sin, cos }
    }
}

/// pi/2 in three parts, 160 bits.
const HALF_PI: [f64; 3] = [core::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17, -1.497_384_904_859_169_8e-33];

macro_rules! operators {
    ($($operator:ident, $method:ident;)*) => {$(
        impl $operator for DoubleDouble {
            type Output = Self;
            #[inline]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    )*};
}

operators! {
    Add, add;
    Sub, sub;
    Mul, mul;
}

impl Div for DoubleDouble {
    type Output = Self;
    /// Long division, three digits of 53 bits. The crate's own division rounds its reciprocal's remainder to f64 (0.8.4), and so is accurate to
    /// 17 digits only.
    fn div(self, other: Self) -> Self {
        let digit = |rest: Self| Self::literal(rest.to_f64() / other.to_f64());
        let first = digit(self);
        let rest = self - other * first;
        let second = digit(rest);
        let third = digit(rest - other * second);
        first + second + third
    }
}

assign_by_operators!(DoubleDouble);

impl Neg for DoubleDouble {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Zero for DoubleDouble {
    #[inline]
    fn zero() -> Self {
        Self::literal(0.0)
    }
    #[inline]
    fn is_zero(&self) -> bool {
        *self == Self::zero()
    }
}

impl One for DoubleDouble {
    #[inline]
    fn one() -> Self {
        Self::literal(1.0)
    }
}

impl Scalar for DoubleDouble {
    #[inline]
    fn literal(x: f64) -> Self {
        Self(TwoFloat::from(x))
    }
}

impl Field for DoubleDouble {}
