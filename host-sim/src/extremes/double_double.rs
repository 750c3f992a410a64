//! A scalar of about 31 digits, beside which the error of `f64` can be seen.

use core::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use dynamics_core::Scalar;
use num_traits::{One, Zero};
use twofloat::TwoFloat;

/// A double-double.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DoubleDouble(TwoFloat);

impl DoubleDouble {
    /// The difference to a number, rounded once.
    pub(super) fn minus(self, x: f64) -> f64 {
        (self.0 - x).hi()
    }

    /// The nearest number.
    pub(super) fn value(self) -> f64 {
        self.0.hi()
    }
}

macro_rules! operators {
    ($($operator:ident, $method:ident, $assigning:ident, $assign:ident;)*) => {$(
        impl $operator for DoubleDouble {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
        impl $assigning for DoubleDouble {
            fn $assign(&mut self, other: Self) {
                *self = self.$method(other);
            }
        }
    )*};
}

operators! {
    Add, add, AddAssign, add_assign;
    Sub, sub, SubAssign, sub_assign;
    Mul, mul, MulAssign, mul_assign;
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Zero for DoubleDouble {
    fn zero() -> Self {
        Self::literal(0.0)
    }
    fn is_zero(&self) -> bool {
        *self == Self::zero()
    }
}

impl One for DoubleDouble {
    fn one() -> Self {
        Self::literal(1.0)
    }
}

impl Scalar for DoubleDouble {
    fn literal(x: f64) -> Self {
        Self(TwoFloat::from(x))
    }
}
