//! Floating-point formats, and the rounding error of an operation in each.

use core::fmt::Debug;

/// A floating-point format whose rounding is bounded: to nearest, subnormal numbers kept.
pub trait Rounding: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Unit roundoff: half the distance of the numbers just above 1.
    const UNIT: f64;
    /// At least half the smallest positive number: the greatest loss of a product by underflow.
    const LEAST: f64;
    /// The largest finite number.
    const MAX: f64;

    /// The number of the format that is nearest to `x`.
    fn nearest(x: f64) -> f64;

    /// Largest rounding error of a sum of magnitude up to `size`.
    #[inline]
    #[must_use]
    fn of_sum(size: f64) -> f64 {
        Self::UNIT * binade(size)
    }

    /// Largest rounding error of a product or quotient of magnitude up to `size`.
    #[inline]
    #[must_use]
    fn of_product(size: f64) -> f64 {
        (Self::UNIT * binade(size)).max(Self::LEAST)
    }
}

/// `f32`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Single;

impl Rounding for Single {
    const UNIT: f64 = 1.0 / (1_u64 << 24) as f64;
    const LEAST: f64 = f64::from_bits((1023 - 150) << 52);
    const MAX: f64 = f32::MAX as f64;
    #[inline]
    fn nearest(x: f64) -> f64 {
        f64::from(x as f32)
    }
}

/// `f64`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Double;

impl Rounding for Double {
    const UNIT: f64 = f64::EPSILON / 2.0;
    const LEAST: f64 = f64::from_bits(1);
    const MAX: f64 = f64::MAX;
    #[inline]
    fn nearest(x: f64) -> f64 {
        x
    }
}

/// The largest power of two that is not above `size`.
#[inline]
pub(super) fn binade(size: f64) -> f64 {
    f64::from_bits(size.to_bits() & (0x7ff << 52))
}
