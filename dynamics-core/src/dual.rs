//! Dual numbers: derivatives of any code written on [`Scalar`], without finite differences.

use crate::scalar::Scalar;
use core::ops::{Add, Mul, Neg, Sub};
use num_traits::{One, Zero};

/// A number and its derivative along one direction: `value + slope e` with `e^2 = 0`.
///
/// Run a recursion on it with the slopes of its inputs: 1 for a joint `q_k`, the cosine for its sine, minus the sine for its
/// cosine. The slopes of the results are then the derivatives along that direction, exact up to rounding. A constant has
/// slope zero. A sum costs two additions, a product three multiplications and an addition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual {
    /// The number.
    pub value: f64,
    /// Its derivative.
    pub slope: f64,
}

impl Dual {
    /// A number with a given derivative.
    #[must_use]
    pub const fn new(value: f64, slope: f64) -> Self {
        Self { value, slope }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.value + other.value, self.slope + other.slope)
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.value - other.value, self.slope - other.slope)
    }
}

impl Mul for Dual {
    type Output = Self;
    /// `(a + a' e) (b + b' e) = a b + (a' b + a b') e`.
    fn mul(self, other: Self) -> Self {
        Self::new(self.value * other.value, self.slope * other.value + self.value * other.slope)
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.value, -self.slope)
    }
}

crate::assign_by_operators!(Dual);

impl Zero for Dual {
    fn zero() -> Self {
        Self::new(0.0, 0.0)
    }
    fn is_zero(&self) -> bool {
        *self == Self::zero()
    }
}

impl One for Dual {
    fn one() -> Self {
        Self::new(1.0, 0.0)
    }
}

impl Scalar for Dual {
    fn literal(x: f64) -> Self {
        Self::new(x, 0.0)
    }
}
